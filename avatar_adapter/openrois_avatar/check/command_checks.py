"""Checks of an engine's commands: reactions, mouth, eyes, hearing, input, and walking."""

import math
import statistics
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass
from itertools import count
from typing import Any, Final

from openrois_avatar.check.connection import CheckedConnection
from openrois_avatar.check.finding import Finding, failed, judged, not_tried, passed
from openrois_avatar.link.media import Audio
from openrois_avatar.link.messages import (
    Bitrate,
    Completed,
    Demand,
    Drive,
    Halt,
    Hello,
    Idle,
    Input,
    KeyFrame,
    Look,
    Place,
    Reached,
    React,
    Silence,
    Speak,
    Stop,
    Viseme,
    Walk,
    Waypoint,
)

__all__ = ["Patience", "check_commands"]

MESSAGES: Final = "JSON messages"
ENCODED: Final = "Encoded pictures"
_UNKNOWN: Final = "a reaction that no engine has"
_STEP: Final = 0.5
_SPEED: Final = 0.5
"""Length of the walk in metres, and its speed in metres a second."""
_NEAR: Final = 0.1
"""Metres by which it may miss its target."""
_BLOCK: Final = 480
_ON_ITS_WAY: Final = 0.3
"""Seconds."""
_ids: Final = (f"check-{number}" for number in count(1))


@dataclass(frozen=True, slots=True)
class Patience:
    """Time limits of the checks, in seconds.

    Attributes:
        asleep: without demand, in which an engine draws nothing, and sends `idle` at least once.
    """

    connect: float = 60.0
    greet: float = 5.0
    watch: float = 3.0
    answer: float = 2.0
    react: float = 30.0
    asleep: float = 1.0
    come_back: float = 15.0
    end: float = 5.0


async def check_commands(connection: CheckedConnection, hello: Hello, patience: Patience) -> AsyncIterator[Finding]:
    """Check everything that the engine's HELLO announces, one after another."""
    if hello.reactions:
        yield await _reaction(connection, hello, patience)
        yield await _stopped(connection, hello, patience)
        yield await _unknown(connection, patience)
    else:
        yield not_tried("reaction", "HELLO lists none", MESSAGES)
    yield await _key_frame(connection, hello, patience)
    yield await _demanded(connection, hello, patience)
    yield await _gestures(connection, patience)
    yield await _hearing(connection, hello, patience)
    yield await _operated(connection, hello, patience)
    if hello.walks:
        yield await _walk(connection, patience)
        yield await _halt(connection, patience)
        yield await _drive(connection, patience)
    else:
        yield not_tried("walk", "HELLO does not say `walks`", MESSAGES)
    yield _answers(connection)


async def _completed(connection: CheckedConnection, id: str, seconds: float) -> str:
    """Return the status with which a command was completed; empty if it was not in time."""
    await connection.until(lambda: bool(connection.completed(id)), seconds)
    return next(iter(connection.completed(id)), "")


async def _reaction(connection: CheckedConnection, hello: Hello, patience: Patience) -> Finding:
    id, name = next(_ids), hello.reactions[0]
    began = time.monotonic()
    connection.send_command(React(id, name))
    status = await _completed(connection, id, patience.react)
    took = time.monotonic() - began
    wrong = {
        "": f"{name} was not completed within {patience.react:g} s",
        "ABORT": f"{name} was completed with ABORT, although it had not been stopped",
        "ERROR": f"{name} was completed with ERROR, and HELLO lists it",
    }
    faults = [wrong[status]] if status in wrong else []
    return judged("reaction", faults, f"{name} was completed with OK after {took:.1f} s", MESSAGES)


async def _stopped(connection: CheckedConnection, hello: Hello, patience: Patience) -> Finding:
    id, name = next(_ids), hello.reactions[0]
    connection.send_command(React(id, name))
    connection.send_command(Stop(id))
    status = await _completed(connection, id, patience.answer)
    if status == "":
        return failed("stop", f"{name} was not completed within {patience.answer:g} s of `stop`", MESSAGES)
    wrong = [f"{name} was completed with ERROR when it was stopped, not with ABORT"] if status == "ERROR" else []
    told = "completed with ABORT" if status == "ABORT" else "it was over before it could be stopped"
    return judged("stop", wrong, told, MESSAGES)


async def _unknown(connection: CheckedConnection, patience: Patience) -> Finding:
    id = next(_ids)
    connection.send_command(React(id, _UNKNOWN))
    status = await _completed(connection, id, patience.answer)
    if status == "":
        told = f"a reaction that there is not was not answered within {patience.answer:g} s: ERROR is expected"
        return failed("unknown", told, MESSAGES)
    faults = [] if status == "ERROR" else [f"a reaction that there is not was completed with {status}, not with ERROR"]
    return judged("unknown", faults, "a reaction that there is not was completed with ERROR", MESSAGES)


async def _key_frame(connection: CheckedConnection, hello: Hello, patience: Patience) -> Finding:
    if not hello.encodes:
        return not_tried("key frame", "the pictures do not come encoded", ENCODED)

    def key_frames() -> int:
        return sum(picture.keyframe for picture in connection.record.pictures)

    await connection.watch(_ON_ITS_WAY)
    before, at = key_frames(), time.monotonic()
    connection.send_command(Bitrate(500_000))
    connection.send_command(KeyFrame())
    if not await connection.until(lambda: key_frames() > before, patience.answer):
        return failed("key frame", f"none came within {patience.answer:g} s of `key_frame`", ENCODED)
    return passed("key frame", f"one came {1000 * (time.monotonic() - at):.0f} ms after it was asked for", ENCODED)


async def _demanded(connection: CheckedConnection, hello: Hello, patience: Patience) -> Finding:
    """Check that the engine draws nothing without demand but sends `idle`, and draws at once with demand."""
    if not hello.demand:
        return not_tried("demand", "HELLO does not say `demand`: it draws while no pictures are wanted", MESSAGES)
    if connection.paused:
        return not_tried("demand", "the engine pauses its pictures", MESSAGES)
    # A clock that was set by WELCOME, or a busy machine, makes all timestamps earlier by the same amount.
    behind = statistics.median([each.at - each.claimed for each in connection.record.pictures] or [0.0])
    connection.send_command(Demand(0))
    await connection.watch(_ON_ITS_WAY)
    before, signs = len(connection.record.pictures), _signs(connection)
    await connection.watch(patience.asleep)
    drawn, signs = len(connection.record.pictures) - before, _signs(connection) - signs
    woken, before = time.monotonic(), len(connection.record.pictures)
    connection.send_command(Demand(1))
    await connection.until(lambda: len(connection.record.pictures) > before, patience.answer)
    faults = [f"{drawn} pictures came while none were wanted"] if drawn else []
    faults += [] if signs else [f"no `idle` came in {patience.asleep:g} s in which no pictures were wanted"]
    if len(connection.record.pictures) == before:
        return judged(
            "demand", [*faults, f"no picture came for {patience.answer:g} s when it was wanted"], "", MESSAGES
        )
    first = connection.record.pictures[before]
    if first.claimed < woken - behind - 1 / hello.video.fps and not drawn:
        faults.append("the first picture that came shows a moment before it was wanted")
    told = (
        f"nothing was drawn while no pictures were wanted, the first {1000 * (first.at - woken):.0f} ms after one was"
    )
    return judged("demand", faults, told, MESSAGES)


def _signs(connection: CheckedConnection) -> int:
    return sum(isinstance(told.event, Idle) for told in connection.record.events)


async def _gestures(connection: CheckedConnection, patience: Patience) -> Finding:
    """Check that the engine survives commands for mouth and eyes, which have no answer."""
    start = time.monotonic_ns() + 100_000_000
    visemes = tuple(Viseme(60.0 * number, shape, 1.0) for number, shape in enumerate(("PP", "aa", "E", "sil")))
    connection.send_command(Speak(next(_ids), start, visemes, 240))
    connection.send_command(Speak(next(_ids), start + 10_000_000_000, visemes, 240))
    connection.send_command(Look(1.0, 0.5))
    connection.send_command(Silence())
    connection.send_command(Look(0.0, 0.0))
    connection.send_command(Stop(None))
    told = "speak, silence, look and stop"
    return await _lives(connection, patience, "mouth and eyes", told)


async def _hearing(connection: CheckedConnection, hello: Hello, patience: Patience) -> Finding:
    if not hello.hears:
        return not_tried("hearing", "HELLO does not say `hears`", "Frames")
    for number in range(20):
        connection.send_sound(Audio(number, time.monotonic_ns(), 1, bytes(2 * _BLOCK)))
    return await _lives(connection, patience, "hearing", "20 blocks of the operator's sound")


async def _operated(connection: CheckedConnection, hello: Hello, patience: Patience) -> Finding:
    if not hello.input:
        return not_tried("input", "HELLO does not say `input`", MESSAGES)
    held = {"keys": ["KeyW"], "pointer": [0.5, 0.5, 1], "gamepad": {"axes": [0.5, 0, 0, 0], "buttons": [1]}}
    messages: list[dict[str, Any]] = [
        {"event": "key", "code": "KeyW", "down": True},
        held,
        {"event": "wheel", "dx": 0, "dy": 120, "x": 0.5, "y": 0.5},
        {"event": "release", "why": "lost"},
    ]
    for number, message in enumerate(messages):
        connection.send_command(Input({"seq": number, "t": 20.0 * number, **message}))
    return await _lives(connection, patience, "input", "a key, a pointer, a wheel, a gamepad and `release`")


async def _lives(connection: CheckedConnection, patience: Patience, check: str, told: str) -> Finding:
    # Pictures that are on their way already show nothing.
    await connection.watch(_ON_ITS_WAY)
    before = len(connection.record.pictures)
    await connection.until(lambda: len(connection.record.pictures) > before, patience.answer)
    if connection.is_over():
        return failed(check, f"after {told}: {connection.end}", MESSAGES)
    if len(connection.record.pictures) == before and not connection.paused:
        return failed(check, f"after {told} no picture came for {patience.answer:g} s", MESSAGES)
    return passed(check, f"{told} were taken, and pictures go on", MESSAGES)


def _place(connection: CheckedConnection) -> Place | None:
    return next((told.event for told in reversed(connection.record.events) if isinstance(told.event, Place)), None)


def _there(place: Place | None) -> str:
    return "nowhere" if place is None else f"{place.x:.2f}, {place.y:.2f}"


async def _walk(connection: CheckedConnection, patience: Patience) -> Finding:
    await connection.until(lambda: _place(connection) is not None, patience.answer)
    start = _place(connection)
    if start is None:
        return failed("walk", "no `place` came after the greeting", MESSAGES)
    id = next(_ids)
    target = Waypoint(start.x + _STEP, start.y)
    connection.send_command(Walk(id, (target, Waypoint(start.x, start.y, start.th)), _SPEED))
    status = await _completed(connection, id, 4 * _STEP / _SPEED + patience.answer + 4.0)
    reached = [
        told.event.index for told in connection.record.events if isinstance(told.event, Reached) and told.event.id == id
    ]
    places = [told.event for told in connection.record.events if isinstance(told.event, Place)]
    halfway = [math.dist((place.x, place.y), (target.x, target.y)) for place in places]
    now = _place(connection)
    assert now is not None, "there was a place before"
    faults = []
    if status != "OK":
        faults.append(f"a walk of {_STEP} m and back was completed with {status or 'nothing'}")
    if reached != [0, 1]:
        faults.append(f"`reached` came for the points {reached}, not for 0 and 1")
    if min(halfway) > _NEAR:
        faults.append(f"the nearest `place` to {target.x:.2f}, {target.y:.2f} was {min(halfway):.2f} m away")
    if math.dist((now.x, now.y), (start.x, start.y)) > _NEAR:
        faults.append(f"it ended at {_there(now)}, not at {_there(start)}")
    return judged("walk", faults, f"{_STEP} m and back to {_there(now)}, each point told when it was reached", MESSAGES)


async def _halt(connection: CheckedConnection, patience: Patience) -> Finding:
    start = _place(connection)
    if start is None:
        return not_tried("halt", "it is not known where the figure is", MESSAGES)
    id = next(_ids)
    connection.send_command(Walk(id, (Waypoint(start.x - 3 * _STEP, start.y),), _SPEED))
    connection.send_command(Halt())
    status = await _completed(connection, id, patience.answer)
    fault = "" if status == "ABORT" else f"a walk that was halted was completed with {status or 'nothing'}, not ABORT"
    told = f"the walk was completed with ABORT at {_there(_place(connection))}"
    return judged("halt", [fault] if fault else [], told, MESSAGES)


async def _drive(connection: CheckedConnection, patience: Patience) -> Finding:
    start = _place(connection)
    connection.send_command(Drive(0.0, 0.0, 1.0))
    moved = await connection.until(lambda: _turned(_place(connection), start), patience.answer)
    await connection.watch(1.0)
    then = _place(connection)
    await connection.watch(0.5)
    faults = []
    if not moved:
        faults.append(f"`drive` with a turn moved nothing within {patience.answer:g} s")
    elif _place(connection) != then:
        faults.append("it still moves 1.5 s after one `drive`: it holds for 0.5 s at most")
    connection.send_command(Halt())
    return judged("drive", faults, "it moved, and stood still by itself when nothing followed", MESSAGES)


def _turned(place: Place | None, start: Place | None) -> bool:
    return place is not None and start is not None and abs(place.th - start.th) > 0.05


def _answers(connection: CheckedConnection) -> Finding:
    """Check that each command is completed once, and none that was never sent."""
    ids = [told.event.id for told in connection.record.events if isinstance(told.event, Completed)]
    twice = sorted({id for id in ids if ids.count(id) > 1})
    strange = sorted({id for id in ids if not id.startswith("check-")})
    faults = [f"{', '.join(twice)} completed more than once"] if twice else []
    faults += [f"{', '.join(strange)} completed without having been asked for"] if strange else []
    return judged("answers", faults, f"{len(ids)} completed, each once", MESSAGES)
