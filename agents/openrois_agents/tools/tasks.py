"""Tools that begin and end a task with a body, and stop it."""

from typing import Any, Final

from openrois.client import BodyInfo
from openrois_agents.tools.abilities import ABILITIES
from openrois_agents.tools.answer import Answer
from openrois_agents.tools.arguments import Nothing, Stop, UseBody
from openrois_agents.tools.running import Progress
from openrois_agents.tools.session import Session

__all__ = ["bodies", "describe", "give_back", "stop", "use_body"]

MAX_LISTED: Final = 50
"""Bodies in one list; those that are free stand first."""


async def bodies(session: Session, _given: Nothing, _progress: Progress) -> Answer:
    """List the bodies."""
    found = await (await session.link.client()).bodies()
    held = session.held.engine_id if session.held is not None else ""
    data = [describe(each, held) for each in sorted(found, key=lambda each: not each.free)[:MAX_LISTED]]
    lines = [f"{each['body']}: {each['state']}; {', '.join(each['tools']) or 'nothing that acts'}" for each in data]
    if len(found) > MAX_LISTED:
        lines.append(f"and {len(found) - MAX_LISTED} more, which can be named")
    return Answer("\n".join(lines) or "There is no body behind the gateway.", {"bodies": data})


def describe(info: BodyInfo, held: str) -> dict[str, Any]:
    """Return a body for a list: whether it is free, and which tools act on it."""
    state = {True: "free", False: "taken, at least a part of it", None: "unknown"}[info.free]
    tools = [tool for tool, ability in ABILITIES.items() if info.refs(ability.urn)]
    return {"body": info.engine_id, "state": "yours" if info.engine_id == held else state, "tools": tools}


async def use_body(session: Session, given: UseBody, progress: Progress) -> Answer:
    """Reserve a body for a task."""
    await progress(0.0, "reserving a body")
    held = await session.use_body(given.body, given.tools, given.wait)
    data = {"body": held.engine_id, "tools": held.tools, "idle_seconds": session.settings.idle}
    text = f"{held.engine_id} is yours for this task, with {', '.join(held.tools)}. Call give_back at its end."
    return Answer(text, data)


async def stop(session: Session, given: Stop, _progress: Progress) -> Answer:
    """Stop everything that a body does."""
    info = await session.body_info(given.body)
    client = await session.link.client()
    stopped = await client.control.stop_all(info.engine_id)
    return Answer(f"{info.engine_id} has stopped.", {"body": info.engine_id, "stopped": list(stopped)})


async def give_back(session: Session, _given: Nothing, _progress: Progress) -> Answer:
    """End the task: stop what runs, and release the body."""
    given_back = await session.give_back("the task is over")
    return Answer(f"{given_back} was given back." if given_back else "No body was held.", {"body": given_back or None})
