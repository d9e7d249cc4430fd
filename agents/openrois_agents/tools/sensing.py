"""Tools by which an agent sees, hears and waits."""

from collections.abc import Collection
from typing import Any

from openrois.catalog.sensing import SPEECH_RECOGNITION
from openrois.catalog.streaming import VIDEO_STREAMING
from openrois.catalog.system_information import SYSTEM_INFORMATION
from openrois.client import BadParameter, BodyInfo, Client, ComponentProxy, RoISError, RpcError, Unsupported, where
from openrois_agents.tools import acting
from openrois_agents.tools.answer import Answer
from openrois_agents.tools.arguments import AskVisitor, Listen, Look, Say, WaitForEvent, Where
from openrois_agents.tools.consents import HEARING
from openrois_agents.tools.event_log import LoggedEvent, tellable
from openrois_agents.tools.failures import failure
from openrois_agents.tools.picture import take_picture
from openrois_agents.tools.running import Progress
from openrois_agents.tools.session import Session
from openrois_agents.tools.untrusted import PICTURE_WARNING, marked, plain_text
from openrois_agents.tools.vocabulary import persons_of, places_of

__all__ = ["ask_visitor", "listen", "look", "wait_for_event", "where_is"]


async def look(session: Session, given: Look, progress: Progress) -> Answer:
    """Return a picture of a body's camera."""
    if not session.settings.pictures:
        raise Unsupported("look is withheld from all tasks here (--no-pictures)")
    info = await session.body_info(given.body)
    cameras = info.refs(VIDEO_STREAMING)
    camera = given.camera or next(iter(cameras), None)
    if camera is None:
        raise Unsupported(f"{info.engine_id} has no camera")
    if camera not in cameras:
        raise BadParameter(f"{info.engine_id} has no camera {camera!r}: it has {', '.join(cameras)}")
    await progress(0.0, f"waiting for a picture of {camera}")
    picture = await take_picture(session.link, camera, given.width)
    age = "of an unknown age" if picture.age is None else f"{picture.age:.1f} s old"
    data = {"camera": camera, "width": picture.width, "height": picture.height, "age_seconds": picture.age}
    return Answer(f"{camera}, {picture.width}x{picture.height}, {age}. {PICTURE_WARNING}", data, picture.file)


async def where_is(session: Session, given: Where, _progress: Progress) -> Answer:
    """Return where a body is, and the places and persons that it knows; these also where the position is not told."""
    info = await session.body_info(given.body)
    client = await session.link.client()
    data: dict[str, Any] = {"body": info.engine_id}
    data["places"] = dict(await places_of(client, info))
    data["persons"] = dict(await persons_of(client, info))
    for component_ref in info.refs(SYSTEM_INFORMATION)[:1]:
        try:
            data["position"] = plain_text(await client.component(component_ref).query("robot_position"))
        except (RoISError, RpcError, TimeoutError) as error:
            if not data["places"] and not data["persons"]:
                raise
            _, data["no_position"] = failure("where", error)
    if "position" not in data and not data["places"] and not data["persons"]:
        raise Unsupported(f"{info.engine_id} does not know where it is")
    return Answer(marked(data), data)


async def listen(session: Session, given: Listen, progress: Progress) -> Answer:
    """Return what a visitor says next."""
    info = await session.body_info(given.body)
    event = await _hear(session, info)
    return await _heard(session, info, event, given.seconds, progress)


async def ask_visitor(session: Session, given: AskVisitor, progress: Progress) -> Answer:
    """Ask a question, and return what a visitor says behind it."""
    held = session.require_body()
    event = await _hear(session, held.info)
    await acting.say(session, Say(text=given.question), progress)
    return await _heard(session, held.info, event, given.seconds, progress)


async def _hear(session: Session, info: BodyInfo) -> str:
    """Watch what a body hears; return the event that tells it."""
    client = await session.link.client()
    for urn, event in ((HEARING, "heard"), (SPEECH_RECOGNITION.urn, "speech_recognized")):
        for component_ref in info.refs(urn)[:1]:
            await session.watching.watch(client.component(component_ref), event, await session.consents(info))
            return event
    raise Unsupported(f"{info.engine_id} does not hear words")


async def _heard(session: Session, info: BodyInfo, event: str, seconds: float, progress: Progress) -> Answer:
    """Return the next words that stay as they are."""
    clock, after, consents = session.clock, session.log.last, await session.consents(info)
    deadline, consents.withheld = clock() + seconds, False
    await progress(0.0, "listening")
    while True:
        found, after = await _next(session, after, (event,), deadline - clock())
        for each in found:
            if words := _words(each):
                data = {"heard": plain_text(words), "visitor": each.data.get("visitor_ref"), "number": each.number}
                return Answer(marked(data), data)
        if clock() >= deadline:
            told = f"No words were heard within {seconds:g} s"
            why = " that may be told: a visitor does not consent to agents" if consents.withheld else ""
            return Answer(f"{told}{why}.", {"heard": None})


def _words(event: LoggedEvent) -> str:
    """Return what was said; nothing where it is not final, or no words were understood."""
    if event.name == "heard":
        return str(event.data.get("text", "")) if event.data.get("final") else ""
    candidates = event.data.get("recognized_text", ())
    return str(candidates[0]) if isinstance(candidates, list) and candidates else ""


async def wait_for_event(session: Session, given: WaitForEvent, progress: Progress) -> Answer:
    """Return the next events of a body."""
    after = session.log.last if given.after is None else given.after
    if given.events:
        info = await session.body_info(given.body)
        client, consents = await session.link.client(), await session.consents(info)
        for component, event in await _sources(client, info, given.events):
            await session.watching.watch(component, event, consents)
    await progress(0.0, "waiting")
    found, last = await _next(session, after, given.events, given.seconds)
    data = {"events": [each.as_json() for each in found], "last": last}
    if not found:
        return Answer(f"Nothing happened within {given.seconds:g} s.", data)
    return Answer(marked(data), data)


async def _next(session: Session, after: int, events: Collection[str], seconds: float) -> tuple[list[LoggedEvent], int]:
    """Return the events behind a number as soon as one may be told, or the seconds are over; and the last number."""
    deadline = session.clock() + seconds
    while True:
        came = await session.log.wait(after, events, max(deadline - session.clock(), 0.0))
        last = session.log.last
        if (found := await tellable(came)) or session.clock() >= deadline:
            return found, last
        after = last


async def _sources(client: Client, info: BodyInfo, events: Collection[str]) -> list[tuple[ComponentProxy, str]]:
    """Return the components of a body that announce these events.

    Raises:
        BadParameter: none announces one of them.
    """
    found: list[tuple[ComponentProxy, str]] = []
    for each in info.components:
        answer = await client.get_profile(where(component_ref=each.component_ref))
        profile = answer.component_profiles.get(each.component_ref)
        if profile is not None:
            names = [event.name for event in profile.event_profiles if event.name in events]
            found += [(client.component(each.component_ref), name) for name in names]
    if unknown := sorted(set(events) - {event for _, event in found}):
        raise BadParameter(f"{info.engine_id} announces no {', '.join(unknown)}: its profile has its events")
    return found
