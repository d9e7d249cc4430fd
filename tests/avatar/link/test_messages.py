import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from openrois_avatar.link.messages import (
    MAX_NAME,
    MAX_REACTIONS,
    MAX_TEXT,
    MAX_VISEMES,
    VISEMES,
    Bitrate,
    Bye,
    Command,
    Completed,
    Drive,
    Event,
    Floor,
    Halt,
    Hello,
    Input,
    KeyFrame,
    LinkError,
    Log,
    Look,
    Pause,
    Place,
    Quit,
    Reached,
    React,
    RingPlace,
    Silence,
    Speak,
    Stop,
    Thing,
    Things,
    VideoShape,
    Viewpoint,
    Viseme,
    Walk,
    Waypoint,
    Welcome,
    command_from_json,
    event_from_json,
)

HELLO = Hello(
    "puppet",
    "1.0",
    VideoShape(640, 360, 29.97, "i420"),
    2,
    ("nod", "bow"),
    "s3cret",
    viewpoints=("face", "room"),
)
SPEAK = Speak("7", 123_456_789_000, (Viseme(0, "PP", 0.5), Viseme(62.5, "aa", 1)), 900)
INPUT = Input({"seq": 1, "t": 2.5, "event": "key", "code": "KeyW", "down": True})
COMMANDS: list[Command] = [React("1", "nod"), SPEAK, Silence(), Look(-1, 0.25), Stop("1"), Stop(), INPUT, Quit()]
COMMANDS += [
    Walk("2", (Waypoint(1.5, -2, 3.14159), Waypoint(0, 0)), 0.8),
    Drive(1, -0.5, 2),
    Halt(),
    KeyFrame(),
    Bitrate(2_000_000),
    Viewpoint("face"),
]
EVENTS: list[Event] = [
    Completed("1", "OK"),
    Completed("é", "ABORT"),
    Completed("2", "ERROR"),
    Completed("3", "ERROR", "stuck 0.46 m before the goal"),
    Log("shader compiled"),
    Pause(True),
    Pause(False),
    Reached("2", 1),
    Place(0.5, -1.25, -1.5708),
    Floor(((-2, -2), (2, -2), (0, 2.5)), (((0, 0), (1, 0), (0, 1)),)),
    Things((Thing("guest", "person", 1, 2, 0.5, "Mia"), Thing("plant", "object", -1, 0), Thing("bell", "sound", 0, 0))),
]

json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)


def on_the_wire(body: dict[str, Any]) -> dict[str, Any]:
    read: dict[str, Any] = json.loads(json.dumps(body))
    return read


def test_hello_travels_whole() -> None:
    assert Hello.from_json(on_the_wire(HELLO.to_json())) == HELLO


def test_an_engine_of_an_earlier_revision_has_no_viewpoints() -> None:
    body = HELLO.to_json()
    assert Hello.from_json(on_the_wire(body)).viewpoints == ("face", "room")
    del body["viewpoints"]
    assert Hello.from_json(on_the_wire(body)).viewpoints == ()
    for wrong in (None, "face", [1], ["x"] * 33):
        with pytest.raises(LinkError, match="viewpoints: expected"):
            Hello.from_json({**body, "viewpoints": wrong})


def test_an_engine_without_sound_says_null() -> None:
    silent = Hello("x", "1", VideoShape(2, 2, 1))
    assert silent.to_json()["audio"] is None
    assert Hello.from_json(on_the_wire(silent.to_json())) == silent


def test_an_engine_of_an_earlier_revision_hears_nothing() -> None:
    body = HELLO.to_json()
    del body["hears"]
    assert not Hello.from_json(on_the_wire(body)).hears
    assert Hello.from_json(on_the_wire({**body, "hears": True})).hears


@pytest.mark.parametrize("member", ["hears", "walks", "ring"])
def test_missing_capabilities_of_hello_are_false(member: str) -> None:
    said = Hello.from_json(on_the_wire({**HELLO.to_json(), member: True}))
    assert getattr(said, member)
    assert not getattr(
        Hello.from_json({name: value for name, value in said.to_json().items() if name != member}), member
    )
    with pytest.raises(LinkError, match=f"{member}: expected true or false"):
        Hello.from_json({**HELLO.to_json(), member: 1})


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"slots": 1}, "slots: expected an integer from 2 to 64"),
        ({"slots": 65}, "slots"),
        ({"slot_bytes": 0}, "slot_bytes: expected an integer"),
        ({"slot_bytes": 100}, "slot_bytes: expected a multiple of 64"),
        ({"slot_bytes": 2**26 + 64}, "slot_bytes"),
        ({"path": None}, "path: expected a string"),
    ],
)
def test_a_ring_is_described_so_that_it_can_be_mapped(change: dict[str, Any], named: str) -> None:
    welcome = Welcome("openrois", RingPlace("dev/shm/x", 4, 4096))
    assert Welcome.from_json(on_the_wire(welcome.to_json())) == welcome
    assert Welcome.from_json({"name": "of an earlier revision"}).ring is None
    with pytest.raises(LinkError, match=named):
        Welcome.from_json({"name": "x", "ring": {"path": "x", "slots": 4, "slot_bytes": 4096, **change}})
    with pytest.raises(LinkError, match="ring: expected an object"):
        Welcome.from_json({"name": "x", "ring": True})


def test_the_secret_is_never_printed() -> None:
    assert "s3cret" not in repr(HELLO)


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_travel_whole(command: Command) -> None:
    assert command_from_json(on_the_wire(command.to_json())) == command


@pytest.mark.parametrize("event", EVENTS)
def test_events_travel_whole(event: Event) -> None:
    assert event_from_json(on_the_wire(event.to_json())) == event


def test_greeting_and_farewell_travel_whole() -> None:
    for welcome in (Welcome("openrois"), Welcome("openrois", now_ns=987_654_321_987_654)):
        assert Welcome.from_json(on_the_wire(welcome.to_json())) == welcome
    assert Bye.from_json(on_the_wire(Bye("drain").to_json())) == Bye("drain")


@pytest.mark.parametrize("now_ns", [-1, 1.5, True, "now", None])
def test_a_welcome_tells_a_time_or_none(now_ns: object) -> None:
    with pytest.raises(LinkError, match="now_ns"):
        Welcome.from_json({"name": "x", "now_ns": now_ns})


def test_unknown_members_are_ignored() -> None:
    assert command_from_json({"command": "look", "x": 0, "y": 0, "z": 1}) == Look(0, 0)


def test_long_reasons_and_logs_are_cut_to_what_the_peer_accepts() -> None:
    assert Bye.from_json(Bye("x" * 10_000).to_json()) == Bye("x" * MAX_TEXT)
    assert event_from_json(Log("y" * 10_000).to_json()) == Log("y" * MAX_TEXT)


def hello_with(**changes: Any) -> dict[str, Any]:
    return {**HELLO.to_json(), **changes}


def shape_with(**changes: Any) -> dict[str, Any]:
    return hello_with(video={**HELLO.video.to_json(), **changes})


@pytest.mark.parametrize(
    ("body", "named"),
    [
        (hello_with(name=None), "name: expected a string"),
        (hello_with(name="x" * (MAX_NAME + 1)), "name: longer"),
        (hello_with(version=1), "version"),
        (hello_with(secret="\ud800"), "secret: half of a surrogate pair"),
        (hello_with(video=None), "video: expected an object"),
        (hello_with(video=[]), "video: expected an object"),
        (hello_with(audio={}), "channels"),
        (hello_with(audio={"channels": 3}), "channels"),
        (hello_with(audio={"channels": True}), "channels"),
        (hello_with(audio=1), "audio"),
        (hello_with(reactions=None), "reactions"),
        (hello_with(hears=1), "hears: expected true or false"),
        (hello_with(hears=None), "hears"),
        (hello_with(reactions=["nod", 1]), "reactions"),
        (hello_with(reactions=["nod"] * (MAX_REACTIONS + 1)), "reactions"),
        (shape_with(width=1), "width: expected an integer from 2 to 16384"),
        (shape_with(height=20_000), "height"),
        (shape_with(width=640.0), "width"),
        (shape_with(fps=0), "fps"),
        (shape_with(fps=float("nan")), "fps"),
        (shape_with(fps="30"), "fps"),
        (shape_with(fps=True), "fps"),
        (shape_with(format="rgba"), "format: expected one of bgra, i420, nv12"),
    ],
)
def test_a_bad_hello_is_refused_by_name(body: dict[str, Any], named: str) -> None:
    with pytest.raises(LinkError, match=named):
        Hello.from_json(body)


def speak_with(**changes: Any) -> dict[str, Any]:
    return {**SPEAK.to_json(), **changes}


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ({}, "command: expected a string"),
        ({"command": "dance"}, "command: expected one of react, .*, not 'dance'"),
        ({"command": "react", "id": "1"}, "reaction"),
        ({"command": "react", "reaction": "nod"}, "id"),
        ({"command": "look", "x": 2, "y": 0}, "x: expected a number from -1 to 1"),
        ({"command": "look", "x": 0}, "y"),
        ({"command": "stop", "id": 3}, "id"),
        (speak_with(start_ns=-1), "start_ns"),
        (speak_with(start_ns=2**63), "start_ns"),
        (speak_with(duration_ms=1.5), "duration_ms"),
        (speak_with(visemes={}), "visemes"),
        (speak_with(visemes=[[0, "aa", 1]] * (MAX_VISEMES + 1)), "visemes"),
        (speak_with(visemes=[[0, "aa"]]), "arrays of three"),
        (speak_with(visemes=["abc"]), "arrays of three"),
        (speak_with(visemes=[[0, "AA", 1]]), "unknown shape"),
        (speak_with(visemes=[[0, [], 1]]), "unknown shape"),
        (speak_with(visemes=[[-1, "aa", 1]]), "offset_ms"),
        (speak_with(visemes=[[86_400_001, "aa", 1]]), "offset_ms"),
        (speak_with(duration_ms=86_400_001), "duration_ms"),
        (speak_with(visemes=[[0, "aa", 1.1]]), "weight"),
        (speak_with(visemes=[[5, "aa", 1], [4, "aa", 1]]), "not in order"),
        ({"command": "walk", "id": "1", "path": [], "speed": 1}, "path: expected at least one point"),
        ({"command": "walk", "id": "1", "path": [[0, 0]], "speed": 1}, "path: expected arrays of 3"),
        ({"command": "walk", "id": "1", "path": [[0, 0, 7]], "speed": 1}, "path"),
        ({"command": "walk", "id": "1", "path": [[0, 1e5, 0]], "speed": 1}, "path"),
        ({"command": "walk", "id": "1", "path": [[0, 0, 0]] * 1001, "speed": 1}, "path: expected an array of at most"),
        ({"command": "walk", "id": "1", "path": [[0, 0, 0]], "speed": 0}, "speed"),
        ({"command": "walk", "path": [[0, 0, 0]], "speed": 1}, "id"),
        ({"command": "drive", "ahead": 11, "left": 0, "turn": 0}, "ahead"),
        ({"command": "drive", "ahead": 1, "left": 0}, "turn"),
    ],
)
def test_a_bad_command_is_refused_by_name(body: dict[str, Any], named: str) -> None:
    with pytest.raises(LinkError, match=named):
        command_from_json(body)


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ({"event": "dance"}, "event: expected one of completed, .* not 'dance'"),
        ({"event": "completed", "id": "1", "status": "DONE"}, "status: expected OK, ABORT or ERROR"),
        ({"event": "completed", "status": "OK"}, "id"),
        ({"event": "completed", "id": "1", "status": "ERROR", "reason": 4}, "reason: expected a string"),
        ({"event": "log"}, "text"),
        ({"event": "pause"}, "on: expected true or false"),
        ({"event": "pause", "on": 1}, "on"),
        ({"event": "reached", "id": "1", "index": -1}, "index"),
        ({"event": "place", "x": 0, "y": None, "th": 0}, "y: expected a number"),
        ({"event": "place", "x": 0, "y": 0, "th": 6.3}, "th"),
        ({"event": "floor", "obstacles": []}, "outline: expected an array"),
        ({"event": "floor", "outline": [[0, 0], [1, 1]], "obstacles": []}, "outline: expected at least three corners"),
        ({"event": "floor", "outline": [[0, 0], [1, 1], [1, 0, 0]], "obstacles": []}, "outline: expected arrays of 2"),
        ({"event": "floor", "outline": [[0, 0], [1, 1], [1, 0]]}, "obstacles: expected an array"),
        ({"event": "floor", "outline": [[0, 0]] * 999, "obstacles": [[[0, 0]] * 3]}, "obstacles: more than 1000"),
        ({"event": "things", "things": ["x"]}, "things: expected an array of objects"),
        ({"event": "things", "things": [{"id": "1", "kind": "cat", "x": 0, "y": 0}]}, "kind: expected one of person"),
        ({"event": "things", "things": [{"id": "1", "kind": "person", "x": 0, "y": 0}] * 2}, "two with one id"),
    ],
)
def test_a_bad_event_is_refused_by_name(body: dict[str, Any], named: str) -> None:
    with pytest.raises(LinkError, match=named):
        event_from_json(body)


def test_there_are_fifteen_mouth_shapes() -> None:
    assert len(set(VISEMES)) == 15


def test_the_largest_speech_fits_one_message() -> None:
    longest = Viseme(86_399_999.95, "sil", 1 / 3)
    body = Speak("x" * MAX_NAME, 2**63 - 1, (longest,) * MAX_VISEMES, 86_400_000).to_json()
    assert len(json.dumps(body, separators=(",", ":"))) < 64 * 1024


READERS: list[Callable[[Mapping[str, Any]], object]] = [
    Hello.from_json,
    Welcome.from_json,
    Bye.from_json,
    command_from_json,
    event_from_json,
]
TEMPLATES = [HELLO.to_json(), Welcome("x").to_json(), Bye("y").to_json()]
TEMPLATES += [command.to_json() for command in COMMANDS] + [event.to_json() for event in EVENTS]


@given(st.data())
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_no_body_does_more_harm_than_a_link_error(data: st.DataObject) -> None:
    body = dict(data.draw(st.sampled_from(TEMPLATES)))
    for name in data.draw(st.lists(st.sampled_from(sorted(body)), max_size=2)):
        body[name] = data.draw(json_values)
    for read in READERS:
        with suppress(LinkError):
            read(body)
