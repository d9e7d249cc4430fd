"""The tool for everything that has none of its own: a message of a component, by its profile."""

from collections.abc import Mapping
from typing import Any

from openrois.client import BadParameter, Client, Unsupported
from openrois.types.codes import ComponentFunction
from openrois.types.references import engine_of
from openrois_agents.tools.answer import Answer
from openrois_agents.tools.arguments import Call
from openrois_agents.tools.consents import TELLING_QUERIES
from openrois_agents.tools.running import Progress
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import CALL
from openrois_agents.tools.untrusted import marked, plain_text

__all__ = ["call"]


async def call(session: Session, given: Call, progress: Progress) -> Answer:
    """Send a message to a component, and return its results."""
    client = await session.link.client()
    if given.kind in ("query", "get_parameters"):
        component = client.component(given.component)
        results = await (component.query(given.name) if given.name else component.get_parameter())
        if given.name in TELLING_QUERIES:
            await _require_consent(session, given.component, given.name, results)
    else:
        results = await _act(session, client, given, progress)
    data = {"component": given.component, "results": plain_text(results)}
    return Answer(marked(data), data)


async def _require_consent(session: Session, component_ref: str, query: str, results: Mapping[str, Any]) -> None:
    """Refuse results that tell of visitors who do not consent to agents.

    Raises:
        Unsupported: they do.
    """
    consents = await session.consents(await session.body_info(engine_of(component_ref)))
    if consents.concern_query(component_ref, query) and not (await consents.ask())(results):
        raise Unsupported(f"{query} tells of a visitor who does not consent to agents")


async def _act(session: Session, client: Client, given: Call, progress: Progress) -> dict[str, Any]:
    """Run a command of the body that is held, or set parameters there.

    Raises:
        Unsupported: the task may not, or the component is of another body.
    """
    held = session.require_body()
    held.permits.require(CALL)
    component = client.component(given.component)
    profile = await component.profile()
    if profile.function is ComponentFunction.ACTUATION:
        component = await held.bind(given.component)
        held.permits.count_movement()
    elif given.component not in {each.component_ref for each in held.info.components}:
        raise Unsupported(f"{given.component} is no component of {held.engine_id}, which this task holds")
    if given.name is None:
        if unknown := sorted(name for name in given.arguments if profile.parameter(name) is None):
            raise BadParameter(f"{given.component} has no parameter {', '.join(unknown)}")
        await component.set_parameter(**given.arguments)
        return {}
    return await held.runner.run(component, given.name, progress, arguments=given.arguments)
