"""Whether a visitor has agreed that a mind gets what the visitor says."""

import logging
from typing import Final

from openrois.client import BodyInfo, Client, ConnectionLost, RoISError, RpcError
from openrois.types.codes import Purpose
from openrois.types.profiles import component_urn
from openrois_agents.mind.contract import Mind

__all__ = ["missing_consent"]

_log = logging.getLogger(__name__)

_VISITORS: Final = component_urn("Visitors", "OpenRoIS")


async def missing_consent(client: Client, body: BodyInfo, visitor: str, mind: Mind) -> tuple[str, ...]:
    """Return what a visitor has to consent to before a mind gets the visitor's words; none where nothing is missing.

    Where a body does not tell what its visitors consent to, none of it is taken for granted.
    """
    if not mind.needs_consent:
        return ()
    needed = {Purpose.AGENT, *((Purpose.TRANSFER,) if mind.sends_to else ())}
    given: set[str] = set()
    for component_ref in body.refs(_VISITORS)[:1]:
        try:
            found = await client.component(component_ref).query("visitors")
        except (ConnectionLost, RoISError, RpcError, TimeoutError) as error:
            _log.warning("%s does not tell what visitors consent to: %s", body.engine_id, error)
            continue
        consents = dict(zip(found.get("visitor_ref", ()), found.get("consent", ()), strict=False))
        given = set(str(consents.get(visitor, "")).split())
    return tuple(sorted(each.value for each in needed if each.value not in given))
