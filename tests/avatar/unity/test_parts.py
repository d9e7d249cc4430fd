"""The pure parts of the package for Unity, under Mono, beside the Python reference."""

import json
import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from openrois_avatar.engines.animation.pose import Mouth
from openrois_avatar.engines.animation.visemes import _FIRMNESS, SHAPES, Track
from openrois_avatar.link.messages import (
    VISEMES,
    Bitrate,
    Bye,
    Drive,
    Halt,
    Input,
    KeyFrame,
    LinkError,
    Look,
    Quit,
    React,
    RingPlace,
    Silence,
    Speak,
    Stop,
    Viseme,
    Walk,
    Waypoint,
    Welcome,
    command_from_json,
)
from openrois_avatar.link.protocol import HEADER, MAGIC, Audio, Message, Parser, Sender

from tests.support.avatar_link import plain, wire
from tests.support.mono import Mono
from tests.support.unity import vectors

pytestmark = [pytest.mark.engine, pytest.mark.timeout(90)]

WELCOME = Welcome("アバター", RingPlace("/proc/7/fd/9", 4, 4096), 2**62)
SPEAK = Speak(
    "s",
    10**18 + 1,
    tuple(Viseme(70.5 * number, shape, 1.0) for number, shape in enumerate(VISEMES)),
    int(70.5 * len(VISEMES)),
)
MUMBLED = Speak("m", 5, (Viseme(0, "PP", 0.25), Viseme(90, "aa", 0.75), Viseme(90, "E", 0), Viseme(500, "oh", 1)), 400)
MESSAGES: Sequence[Message] = (
    WELCOME,
    React("r1", "shake_hands 🤝"),
    Stop("r1"),
    Stop(None),
    SPEAK,
    MUMBLED,
    Silence(),
    Look(-1.0, 0.5),
    Walk("w", (Waypoint(1.5, -2.25, None), Waypoint(0, 0, -3.14)), 0.75),
    Drive(-10.0, 0.0, 10.0),
    Halt(),
    KeyFrame(),
    Bitrate(10**9),
    Input({"seq": 1, "t": 20.5, "event": "key", "code": "2026-11-22T03:00:00Z", "down": True}),
    Audio(3, 2**60, 2, bytes(range(256))),
    Audio(4, 0, 1, b""),
    Quit(),
    Bye("that is all"),
)


def frame(kind: int, payload: bytes, **header: int) -> bytes:
    """A message by hand, after a welcome where it is none itself."""
    fields = {"version": 1, "flags": 0, "length": len(payload), "reserved": 0, **header}
    head = HEADER.pack(MAGIC, kind, *(fields[name] for name in ("version", "flags", "length", "reserved")))
    return (b"" if kind == 2 else wire(Welcome("a"))) + head + payload


def command(body: Mapping[str, Any]) -> bytes:
    return frame(5, json.dumps(body).encode())


WALK = {"command": "walk", "id": "w", "path": [[0, 0, None]], "speed": 1}
TALK = {"command": "speak", "id": "s", "start_ns": 0, "visemes": [[0, "aa", 1]], "duration_ms": 9}
RING = {"path": "/r", "slots": 4, "slot_bytes": 4096}
MALFORMED = {
    "no magic": (b"GET / HTTP/1.1\r\n\r\n", "bad magic"),
    "version": (frame(5, b"", version=2), "version 2 is not spoken here"),
    "flags": (frame(5, b"", flags=1), "unknown flags in the header"),
    "reserved": (frame(5, b"", reserved=1), "unknown flags in the header"),
    "type": (frame(99, b""), "unknown message type 99"),
    "no welcome": (wire(Quit()), "COMMAND is not expected here"),
    "twice welcome": (wire(Welcome("a"), Welcome("a")), "WELCOME is not expected here"),
    "an engine's": (frame(3, b""), "VIDEO is not expected here"),
    "too long": (frame(5, b"", length=2**17), "COMMAND of 131072 bytes is over the limit"),
    "far too long": (frame(5, b"", length=2**32 - 1), "over the limit"),
    "no JSON": (frame(5, b"{"), "bad COMMAND: the payload is not JSON"),
    "nothing": (frame(5, b""), "bad COMMAND: the payload is not JSON"),
    "two": (frame(5, b'{"command":"halt"} {}'), "the payload is not JSON"),
    "no UTF-8": (frame(5, b'{"command":"\xff"}'), "the payload is not JSON"),
    "no object": (frame(5, b"[]"), "the payload is not a JSON object"),
    "deep": (frame(5, b'{"a":' * 9000), "the payload is not JSON"),
    "no command": (command({}), "command: expected a string"),
    "unknown": (command({"command": "fly"}), "command: unknown: 'fly'"),
    "id": (command({"command": "react", "id": 1, "reaction": "nod"}), "bad COMMAND: id: expected a string"),
    "long": (command({"command": "react", "id": "1", "reaction": "n" * 201}), "reaction: longer than 200 characters"),
    "look": (command({"command": "look", "x": 0, "y": 2}), "y: expected a number from -1 to 1"),
    "true": (command({"command": "look", "x": True, "y": 0}), "x: expected a number from -1 to 1"),
    "NaN": (frame(5, b'{"command":"look","x":NaN,"y":0}'), "x: expected a number"),
    "drive": (command({"command": "drive", "ahead": 11, "left": 0, "turn": 0}), "ahead: expected a number"),
    "no path": (command({**WALK, "path": []}), "path: expected at least one point"),
    "path": (command({**WALK, "path": [[0, 0]]}), "path: expected arrays of 3"),
    "paths": (command({**WALK, "path": [[0, 0, 0]] * 1001}), "path: expected an array of at most 1000 items"),
    "far": (command({**WALK, "path": [[1e5, 0, 0]]}), "path: expected a number from -10000 to 10000"),
    "slow": (command({**WALK, "speed": 0}), "speed: expected a number from 0.01 to 10"),
    "shape": (command({**TALK, "visemes": [[0, "ah", 1]]}), "visemes: unknown shape"),
    "order": (command({**TALK, "visemes": [[9, "aa", 1], [8, "aa", 1]]}), "visemes: not in order of time"),
    "weight": (command({**TALK, "visemes": [[0, "aa", 1.1]]}), "visemes weight: expected a number from 0 to 1"),
    "start": (command({**TALK, "start_ns": 2**63}), "start_ns: expected an integer"),
    "half": (command({**TALK, "duration_ms": 0.5}), "duration_ms: expected an integer"),
    "bitrate": (command({"command": "bitrate", "bits_per_second": 0}), "bits_per_second: expected an integer"),
    "input": (command({"command": "input", "message": 1}), "message: expected an object"),
    "slots": (frame(2, json.dumps({"name": "a", "ring": {**RING, "slots": 1}}).encode()), "slots: expected an integer"),
    "slot": (frame(2, json.dumps({"name": "a", "ring": {**RING, "slot_bytes": 65}}).encode()), "a multiple of 64"),
    "sound": (frame(4, bytes(25)), "bad AUDIO: channels from 1 to 2 expected"),
    "short sound": (frame(4, bytes(23)), "bad AUDIO: shorter than its header"),
    "half a sample": (frame(4, bytes(16) + b"\1" + bytes(8)), "bad AUDIO: the last sample is not whole"),
}
"""Bytes of an adapter that is out of its mind, and what is said of them."""

PLACES = [(1.5, -2.0, th) for th in (-math.pi / 2, 0.0, math.pi / 2, math.pi, -3.0, 0.1, 2 * math.pi, -6.0)]
MOMENTS = [SPEAK.start_ns + int(1e6 * ms) for ms in range(-100, 1400, 13)]
CUT = SPEAK.start_ns + 300_000_000
MOUTHS: Sequence[tuple[Speak, int | None, Sequence[int]]] = (
    (SPEAK, None, MOMENTS),
    (SPEAK, CUT, MOMENTS),
    (MUMBLED, None, [int(1e6 * ms) for ms in range(-100, 700, 7)]),
)
AHEAD = {"command": "drive", "ahead": 1.0, "left": 0.0, "turn": 0.0}
DRIVES: Sequence[Sequence[Any]] = (
    [AHEAD, 5.0],
    [AHEAD, 0.2, AHEAD, 0.2, AHEAD, 0.2, {"command": "halt"}, 1.0],
    [*[AHEAD, 0.1] * 30],
    [{**WALK, "path": [[0.5, 0.5, None], [0.5, 0.5, 0.0]]}, *[0.02] * 200],
    [WALK, {**AHEAD, "ahead": 0.0}, 1.0],
    [{**WALK, "path": [[5, 0, None]]}, 0.5, {**WALK, "id": "x"}, 5.0],
)
NOW = 10**15
SOUNDS: Sequence[Mapping[str, Any]] = (
    {"rate": 44100, "channels": 1, "to": 1, "calls": [{"frames": 1024, "at": NOW + i * 23_220_000} for i in range(20)]},
    {"rate": 48000, "channels": 2, "to": 2, "calls": [{"frames": 512, "at": NOW + i * 10_666_667} for i in range(9)]},
    {"rate": 48000, "channels": 2, "to": 1, "calls": [{"frames": 960, "at": NOW}, {"frames": 1920, "at": 2 * NOW}]},
)


def mutated() -> list[bytes]:
    """Good messages with some bytes that are not."""
    chance = random.Random(5)
    streams = []
    for _ in range(600):
        stream = bytearray(wire(WELCOME, chance.choice(MESSAGES[1:])))
        for _ in range(chance.randint(1, 3)):
            at = chance.randrange(len(stream))
            stream[at] = chance.choice((stream[at] ^ 1 << chance.randrange(8), chance.randrange(256)))
        streams.append(bytes(stream))
    return streams


STREAMS = [wire(*MESSAGES), *(stream for stream, _ in MALFORMED.values()), *mutated()]


@pytest.fixture(scope="module")
def told(mono: Mono, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What the package made of all of it."""
    folder = tmp_path_factory.mktemp("vectors")
    asked = {
        "streams": [stream.hex() for stream in STREAMS],
        "mouths": [{"speak": s.to_json(), "cut_ns": cut, "moments": moments} for s, cut, moments in MOUTHS],
        "places": PLACES,
        "drives": DRIVES,
        "sounds": SOUNDS,
    }
    (folder / "asked.json").write_text(json.dumps(asked))
    return json.loads(mono.run(vectors(mono, folder), str(folder / "asked.json")))


def as_message(told: Mapping[str, Any]) -> Message:
    """Return the message that it reported, as the reference has it."""
    if "welcome" in told:
        return Welcome.from_json(told["welcome"])
    if "bye" in told:
        return Bye(told["bye"])
    if "heard" in told:
        samples = np.array(told["heard"], "<i2").tobytes()
        return Audio(0, told["timestamp_ns"], told["channels"], samples)
    return command_from_json(told["command"])


def by_reference(stream: bytes) -> list[Message] | None:
    """The messages of an adapter, None if something is wrong with them."""
    try:
        messages = Parser(Sender.ADAPTER).feed(stream)
    except LinkError:
        return None
    return [plain(uncounted(message)) for message in messages]


def uncounted(message: Message) -> Message:
    """Sound without its sequence, which the package drops."""
    if isinstance(message, Audio):
        return Audio(0, message.timestamp_ns, message.channels, message.samples)
    return message


def test_every_message_is_read(told: Any) -> None:
    assert told["streams"][0]["fault"] is None
    read = [as_message(each) for each in told["streams"][0]["messages"]]
    assert read == [plain(uncounted(message)) for message in MESSAGES]


@pytest.mark.parametrize("case", MALFORMED)
def test_malformed_message_ends_with_a_clear_exception(told: Any, case: str) -> None:
    stream, said = MALFORMED[case]
    assert by_reference(stream) is None
    assert said in told["streams"][STREAMS.index(stream)]["fault"]


def test_mutations_are_read_as_the_reference_does_or_refused(told: Any) -> None:
    start, refused = 1 + len(MALFORMED), 0
    for stream, each in zip(STREAMS[start:], told["streams"][start:], strict=True):
        expected = by_reference(stream)
        if expected is None:
            refused += each["fault"] is not None
        else:
            assert each["fault"] is None, stream
            assert [as_message(message) for message in each["messages"]] == expected
    # JSON is read less strictly than the reference does it: single quotes, say, are let through.
    assert refused > 300


def test_mouths_move_as_in_the_embedded_avatar(told: Any) -> None:
    for (speak, cut, moments), weights in zip(MOUTHS, told["mouths"], strict=True):
        visemes = [(each.offset_ms / 1000, each.shape, each.weight) for each in speak.visemes]
        # Seconds from the start, to be exact where nanoseconds are many.
        track = Track(0.0, visemes, speak.duration_ms / 1000)
        for moment, found in zip(moments, weights, strict=True):
            at = (moment - speak.start_ns) / 1e9
            if cut is not None and moment >= cut:
                track.cut((cut - speak.start_ns) / 1e9)
            assert as_share(found) == pytest.approx(track.share(at).shape, abs=1e-5)
        assert max(max(found) for found in weights) > 0.2
        assert not any(weights[-1])


def as_share(weights: Sequence[float]) -> list[float]:
    """What the reference says of the mouth, out of the weights of the visemes."""
    parts = [part.name for part in fields(Mouth)]
    total = dict.fromkeys(parts, 0.0)
    for name, weight in zip(VISEMES, weights, strict=True):
        for part in parts:
            total[part] += weight * _FIRMNESS.get(name, 1.0) * getattr(SHAPES[name], part)
    return list(total.values())


def test_coordinates(told: Any) -> None:
    for (x, y, th), (unity_x, unity_z, yaw, back_x, back_y, back_th) in zip(PLACES, told["places"], strict=True):
        assert (unity_x, unity_z) == (back_x, back_y) == (x, y)
        # Unity's forward, (sin, cos) of the yaw in x and z, is the direction of the figure.
        assert (math.sin(math.radians(yaw)), math.cos(math.radians(yaw))) == pytest.approx((math.cos(th), math.sin(th)))
        assert 0 <= yaw < 360
        assert math.isclose(math.remainder(back_th - th, 2 * math.pi), 0, abs_tol=1e-9)
        assert -math.pi <= back_th <= math.pi
    assert told["places"][0][2] == 180


def test_walkers(told: Any) -> None:
    held, halted, walled, walked, replaced, changed = told["drives"]
    # One drive is half a second, however long the frame.
    assert held["at"] == pytest.approx([0, -0.45, -math.pi / 2])
    assert halted["at"] == pytest.approx([0, -0.6, -math.pi / 2])
    assert walled["at"][1] == pytest.approx(-0.9, abs=0.1)
    assert walked["at"] == pytest.approx([0.5, 0.5, 0.0], abs=0.006)
    assert walked["told"] == ["reached w 0", "reached w 1", "completed w Ok"]
    assert replaced["told"] == ["completed w Abort"]
    assert changed["told"] == ["completed w Abort", "reached x 0", "completed x Ok"]
    assert not any(each["moving"] for each in told["drives"] if each is not walled)


def test_sound_is_counted_by_samples_and_sounds_the_same(told: Any) -> None:
    resampled, stereo, mixed = told["sounds"]
    assert resampled["stamps"] == [NOW + 20_000_000 * number for number in range(len(resampled["stamps"]))]
    samples = np.array(resampled["samples"]) / 32767
    tone = 0.5 * np.sin(2 * np.pi * 440 * np.arange(len(samples)) / 48_000)
    assert len(samples) == 23 * 960
    assert np.abs(samples - tone).max() < 1e-3
    both = np.array(stereo["samples"]).reshape(-1, 2)
    assert np.abs(both[:, 0] - 2 * both[:, 1]).max() <= 2
    # A game that stood still begins anew, at the new moment.
    assert mixed["stamps"] == [2 * NOW]
    tone = 0.375 * np.sin(2 * np.pi * 440 * np.arange(960, 1920) / 48_000)
    assert np.abs(np.array(mixed["samples"]) / 32767 - tone).max() < 1e-3


def test_oversized_message_is_refused_at_once(told: Any) -> None:
    assert told["refused"] == [
        "address: expected unix:/path or tcp:host:port, not '127.0.0.1:1'",
        "address: expected unix:/path or tcp:host:port, not 'unix:'",
        "place: expected a number from -10000 to 10000",
        "floor: expected at least three corners",
        "things: two have the id 'a'",
        "id: half of a surrogate pair",
        "place: expected a number from -10000 to 10000",
        "16 bytes of pixels expected, 3 found",
        "a picture of 1x2: from 2 to 16384 is possible",
        "width, height and stride must be even in I420 and NV12",
        "the stride is shorter than a row",
        "a picture of 1073741824 bytes is over the limit of 67108864",
        "a picture of 2x1: from 2 to 16384 is possible",
        "a picture of 0 bytes",
        "HELLO announced no encoded pictures",
        "HELLO announced encoded pictures, and this one is not",
        "a block of sound of 3 bytes in 1 channels",
    ]
