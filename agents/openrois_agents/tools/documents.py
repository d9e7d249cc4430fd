"""Documents for agents: the bodies, the profile of each, and the event log, as JSON."""

import json
import re
from collections.abc import Mapping
from typing import Any, Final

from openrois.client import BadParameter, where
from openrois.types.profiles import HRIComponentProfile, ParameterProfile
from openrois_agents.tools.event_log import tellable
from openrois_agents.tools.session import Session
from openrois_agents.tools.tasks import describe
from openrois_agents.tools.untrusted import marked

__all__ = ["BODIES", "EVENTS", "PROFILE", "profile_address", "read_document"]

BODIES: Final = "openrois://bodies"
"""The address of the list of bodies."""

EVENTS: Final = "openrois://events"
"""The address of the event log."""

PROFILE: Final = "openrois://profile/{body}"
"""The addresses of profiles."""

MAX_DOCUMENT: Final = 500_000
"""Characters of one document."""


def profile_address(body: str) -> str:
    """Return the address of a body's profile."""
    return PROFILE.format(body=body)


async def read_document(session: Session, address: str) -> str:
    """Return a document.

    Raises:
        BadParameter: there is none at this address, or it is too large.
        RoISError, ConnectionLost: the gateway does not tell.
    """
    if address == EVENTS:
        last, events = session.log.last, await tellable(session.log.after(0))
        return marked({"events": [each.as_json() for each in events], "last": last})
    if address == BODIES:
        held = session.held.engine_id if session.held is not None else ""
        bodies = await (await session.link.client()).bodies()
        return _text({"bodies": [describe(each, held) for each in bodies]})
    if named := re.fullmatch(r"openrois://profile/([^/]+)", address):
        return _text(await _profile(session, named[1]))
    raise BadParameter(f"there is no document {address!r}: there are {BODIES}, {EVENTS} and {PROFILE}")


async def _profile(session: Session, body: str) -> dict[str, Any]:
    """Return what the components of a body understand."""
    info = await session.body_info(body)
    client = await session.link.client()
    components = {}
    for each in info.components:
        answer = await client.get_profile(where(component_ref=each.component_ref))
        if (profile := answer.component_profiles.get(each.component_ref)) is not None:
            components[each.component_ref] = _component(profile)
    return {"body": info.engine_id, "components": components}


def _component(profile: HRIComponentProfile) -> dict[str, Any]:
    return {
        "type": profile.component_type,
        "function": profile.function,
        "part": profile.part or None,
        "commands": {each.name: _names(each.arguments) for each in profile.command_profiles},
        "queries": {each.name: _names(each.results) for each in profile.query_profiles},
        "events": {each.name: _names(each.results) for each in profile.event_profiles},
        "parameters": _names(profile.parameter_profiles),
    }


def _names(profiles: tuple[ParameterProfile, ...]) -> Mapping[str, str]:
    """Return the types of parameters, arguments or results by their names, with what they are."""
    return {
        each.name: each.data_type_ref.code + (f": {each.description}" if each.description else "") for each in profiles
    }


def _text(document: Mapping[str, Any]) -> str:
    text = json.dumps(document, ensure_ascii=False, indent=1)
    if len(text) > MAX_DOCUMENT:
        raise BadParameter(f"the document has more than {MAX_DOCUMENT} characters: ask for the profile of one body")
    return text
