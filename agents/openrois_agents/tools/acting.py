"""Tools that let a body speak and move."""

from openrois.client import BadParameter
from openrois.types.profiles import component_urn
from openrois_agents.tools.answer import Answer
from openrois_agents.tools.arguments import Gesture, GoTo, LookAt, Say
from openrois_agents.tools.held_body import HeldBody
from openrois_agents.tools.running import Progress
from openrois_agents.tools.session import Session
from openrois_agents.tools.vocabulary import gestures_of, places_of

__all__ = ["gesture", "go_to", "look_at", "say"]

_DIRECTIONS = {"ahead": (0.0, 0.0), "left": (1.0, 0.0), "right": (-1.0, 0.0), "up": (0.0, 1.0), "down": (0.0, -1.0)}
"""Where the eyes look, as the viewer sees it, by the directions as the body sees them."""

_MILLISECONDS = 1000

_SPEECH_PROGRESS = component_urn("SpeechProgress", "OpenRoIS")


async def say(session: Session, given: Say, progress: Progress) -> Answer:
    """Say a text; return when it was heard."""
    held = session.require_body()
    parameters = {"speech_text": given.text, "language": given.language, "volume": given.volume}
    words = [(held.client.component(ref), "word_spoken") for ref in held.info.refs(_SPEECH_PROGRESS)]
    news = next(iter(words), None)
    await held.runner.run(held.acting("say"), "start", progress, parameters=parameters, news=news)
    return Answer(f"{held.engine_id} said it.", {"body": held.engine_id})


async def gesture(session: Session, given: Gesture, progress: Progress) -> Answer:
    """Make a gesture; return at its end."""
    held = session.require_body()
    held.permits.require("gesture")
    gestures = await gestures_of(held.client, held.info)
    if given.name not in gestures:
        raise BadParameter(f"{held.engine_id} has no gesture {given.name!r}: it has {', '.join(gestures) or 'none'}")
    parameters = {"reaction_ref": gestures[given.name]}
    await held.runner.run(held.acting("gesture"), "start", progress, parameters=parameters)
    return Answer(f"{held.engine_id} did: {given.name}.", {"body": held.engine_id, "gesture": given.name})


async def look_at(session: Session, given: LookAt, progress: Progress) -> Answer:
    """Turn the eyes."""
    held = session.require_body()
    x, y = _DIRECTIONS[given.direction] if given.direction else (given.x or 0.0, given.y or 0.0)
    await held.runner.run(held.acting("look_at"), "look", progress, arguments={"x": x, "y": y})
    return Answer(f"{held.engine_id} looks there.", {"body": held.engine_id, "x": x, "y": y})


async def go_to(session: Session, given: GoTo, progress: Progress) -> Answer:
    """Go to a place; return on arrival."""
    held = session.require_body()
    held.permits.require("go_to")
    target = await _target(held, given)
    navigation = held.acting("go_to")
    await held.runner.run(
        navigation,
        "start",
        progress,
        parameters={"target_positions": (target,), "time_limit": round(given.seconds * _MILLISECONDS)},
        seconds=given.seconds + 1,
        news=(navigation, "reached_target"),
    )
    return Answer(f"{held.engine_id} is there.", {"body": held.engine_id, "target": target})


async def _target(held: HeldBody, given: GoTo) -> str:
    """Return where to go, as Navigation takes it."""
    if given.place is None:
        return ",".join(f"{each:g}" for each in (given.x, given.y, given.facing) if each is not None)
    places = await places_of(held.client, held.info)
    if given.place not in places:
        there = f"it knows {', '.join(places)}" if places else "it knows none by name: give x and y"
        raise BadParameter(f"{held.engine_id} knows no place {given.place!r}: {there}")
    return given.place
