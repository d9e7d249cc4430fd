"""The signs of life of a gateway, in time that is turned by hand."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any, cast

import pytest

from openrois.cluster.frames import Beat, parse_said
from openrois.cluster.presence import Present
from openrois.cluster.pulse import Pulse
from openrois.cluster.subjects import Subjects
from openrois.version import __version__
from tests.support.streaming import VirtualClock

LINK = "0123456789abcdef"
OTHER = "fedcba9876543210"


class Nats:
    """Stands in for a connection: it delivers to its one subscriber what that publishes, unless it is frozen."""

    def __init__(self) -> None:
        self.said: list[Beat] = []
        self.frozen = False
        self.waiting: list[bytes] = []
        self.aborted = ""
        self.deliver: Callable[[bytes, bytes, bytes], None] = lambda *_: None

    def subscribe(self, _subject: str, receiver: Callable[[bytes, bytes, bytes], None]) -> None:
        self.deliver = receiver

    def publish(self, _subject: str, payload: bytes) -> None:
        self.said.append(parse_said(Beat, payload))
        self.waiting.append(payload)
        if not self.frozen:
            self.flush()

    def flush(self) -> None:
        waiting, self.waiting = self.waiting, []
        for payload in waiting:
            self.deliver(b"", b"", payload)

    def abort(self, reason: str) -> None:
        self.aborted = self.aborted or reason

    def hear(self, gateway: str, link: str = OTHER, **more: Any) -> None:
        beat = Beat(gateway=gateway, instance=more.pop("instance", OTHER), link=link, version="1", **more)
        self.deliver(b"", b"", beat.model_dump_json().encode())


class Beating:
    """A pulse that beats, and all around it."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.nats = Nats()
        self.changes: list[list[str]] = []
        self.happened: list[str] = []
        self.pulse = Pulse(Subjects("test"), "a", {"room": 1}, self.clock.now, self.sleep)
        self.pulse.on_gone = lambda: self.happened.append("gone")
        self.pulse.on_pause = lambda: self.happened.append("pause")
        self.pulse.listeners.add(lambda present: self.changes.append(sorted(present)))

    async def sleep(self, seconds: float) -> None:
        await self.clock.sleep_until(self.clock.now() + seconds)

    def begin(self) -> None:
        self.pulse.begin(cast(Any, self.nats), LINK)


@asynccontextmanager
async def beating() -> AsyncIterator[Beating]:
    made = Beating()
    running = asyncio.ensure_future(made.pulse.run())
    made.begin()
    try:
        yield made
    finally:
        running.cancel()
        await asyncio.wait({running})


async def test_it_beats_four_times_a_second_with_what_it_tells() -> None:
    async with beating() as world:
        beats: list[float] = []
        world.pulse.on_beat = beats.append
        await world.clock.advance(1.0)
        assert beats == [1000.25, 1000.5, 1000.75, 1001.0]
        assert len(world.nats.said) == 5
        said = world.nats.said[-1]
        assert (said.gateway, said.link, said.version, said.attributes) == ("a", LINK, __version__, {"room": 1})
        assert world.changes == [["a"]]


async def test_another_gateway_is_gone_one_second_after_its_last_sign() -> None:
    async with beating() as world:
        await world.clock.advance(0.1)
        world.nats.hear("b", attributes={"x": 1})
        assert world.pulse.presence.present["b"] == Present("b", OTHER, OTHER, "1", {"x": 1})
        await world.clock.advance(0.99)
        assert sorted(world.pulse.presence.present) == ["a", "b"]
        await world.clock.advance(0.02)
        assert sorted(world.pulse.presence.present) == ["a"]
        assert world.happened == ["gone"]
        assert world.changes == [["a"], ["a", "b"], ["a"]]


async def test_a_gateway_that_leaves_or_changes_is_told_at_once() -> None:
    async with beating() as world:
        world.nats.hear("b")
        world.nats.hear("b", attributes={"drains": True})
        world.nats.hear("b", leaving=True)
        assert world.changes == [["a"], ["a", "b"], ["a", "b"], ["a"]]
        assert world.happened == ["gone"]


async def test_its_own_attributes_change_at_once() -> None:
    async with beating() as world:
        world.pulse.announce({"drains": True})
        assert world.nats.said[-1].attributes == {"drains": True}
        with pytest.raises(ValueError, match="the attributes of a gateway are too much"):
            world.pulse.announce({"x": "x" * 10_000})
        await world.clock.advance(0.25)
        assert world.nats.said[-1].attributes == {"drains": True}
    with pytest.raises(ValueError, match="too much"):
        Pulse(Subjects("test"), "a", {"x": "x" * 10_000})


async def test_nats_is_silent_one_second_after_the_last_echo() -> None:
    async with beating() as world:
        await world.clock.advance(0.5)
        world.nats.frozen = True
        await world.clock.advance(0.99)
        assert world.nats.aborted == ""
        await world.clock.advance(0.02)
        assert world.nats.aborted == "NATS is silent"


async def test_without_a_connection_no_gateway_is_there() -> None:
    async with beating() as world:
        world.nats.hear("b")
        world.pulse.lose_connection()
        assert world.pulse.presence.present == {}
        said = len(world.nats.said)
        await world.clock.advance(5.0)
        world.pulse.leave()
        assert len(world.nats.said) == said
        assert world.nats.aborted == ""
        world.begin()
        assert world.changes == [["a"], ["a", "b"], [], ["a"]]


async def test_a_process_that_stood_still_loses_its_streams_and_blames_no_other() -> None:
    async with beating() as world:
        world.nats.hear("b")
        await world.clock.advance(0.3)
        world.nats.frozen = True
        world.clock.jump(3.0)
        world.nats.hear("c", "0" * 15 + "c")
        assert world.happened == ["pause"]
        assert sorted(world.pulse.presence.present) == ["a", "b", "c"]
        assert world.pulse.is_behind
        # All that came before this sign of life comes before it here, too.
        world.nats.flush()
        assert not world.pulse.is_behind
        world.nats.frozen = False
        await world.clock.advance(0.9)
        assert world.nats.aborted == ""
        assert world.happened == ["pause"]


async def test_signs_of_life_from_before_a_pause_do_not_end_it() -> None:
    async with beating() as world:
        world.nats.frozen = True
        await world.clock.advance(0.3)
        old, world.nats.waiting = world.nats.waiting, []
        world.clock.jump(3.0)
        for payload in old:
            world.nats.deliver(b"", b"", payload)
        assert world.pulse.is_behind
        world.nats.flush()
        assert not world.pulse.is_behind


async def test_a_short_pause_is_none() -> None:
    async with beating() as world:
        world.clock.jump(0.9)
        await world.clock.advance(0.1)
        assert world.happened == []


async def test_two_processes_with_one_id_are_said_once(caplog: pytest.LogCaptureFixture) -> None:
    async with beating() as world:
        for _ in range(3):
            world.nats.hear("a")
        assert caplog.text.count("another process is gateway 'a' too: give each an id of its own") == 1
