import asyncio
import logging
import os
import select
import signal
import sys
from asyncio.subprocess import PIPE

import numpy as np
import pytest
import uvloop
from openrois_avatar.link import embedded
from openrois_avatar.link.embedded import LONGEST_DELAY, QUIT_TIMEOUT, START_TIMEOUT, EmbeddedEngine
from openrois_avatar.link.messages import Completed, Event, Hello, LinkError, Log, Pause, React, Silence
from openrois_body.processes.child import TERMINATE_TIMEOUT
from openrois_streaming.source.source import RawAudio
from openrois_streaming.source.supervision import CHECK_INTERVAL, HUNG

from tests.support.streaming import VirtualClock, settle

pytestmark = pytest.mark.engine

FAKE = "tests.support.fake_engine"


class Witness:
    """Records the notifications of an embedded engine, and lets a test wait for them."""

    def __init__(self) -> None:
        self.lost = asyncio.Queue[str]()
        self.back = asyncio.Queue[Hello]()
        self.events = asyncio.Queue[Event]()
        self.audio = asyncio.Queue[RawAudio]()

    def engine(self, behaviour: str, **options: object) -> EmbeddedEngine:
        return EmbeddedEngine(
            FAKE,
            behaviour,
            on_audio=self.audio.put_nowait,
            on_event=self.events.put_nowait,
            on_lost=self.lost.put_nowait,
            on_back=self.back.put_nowait,
            **options,  # type: ignore[arg-type]
        )


def pid_of(engine: EmbeddedEngine) -> int:
    """The fake engine's version is its process id."""
    assert engine.hello is not None
    return int(engine.hello.version)


def is_gone(pid: int, timeout: float = 0.0) -> bool:
    """Whether the process has ended, `timeout` seconds from now at the latest."""
    try:
        handle = os.pidfd_open(pid)
    except ProcessLookupError:
        return True
    try:
        return bool(select.select([handle], [], [], timeout)[0])
    finally:
        os.close(handle)


async def test_an_engine_runs_and_is_ended_with_the_context(caplog: pytest.LogCaptureFixture) -> None:
    witness = Witness()
    with caplog.at_level(logging.INFO):
        async with asyncio.timeout(60), witness.engine("good") as engine:
            async with engine.video.open() as pictures:
                assert (await anext(pictures)).sequence < (await anext(pictures)).sequence
            assert (await witness.audio.get()).samples.shape == (960, 2)
            engine.send(React("1", "nod"))
            assert [await witness.events.get(), await witness.events.get()] == [Log("nod"), Completed("1", "OK")]
            pid = pid_of(engine)
    assert is_gone(pid)
    assert witness.lost.empty()
    assert f"{FAKE}: running" in caplog.text
    assert engine.hello is None
    with pytest.raises(LinkError, match="no game engine is connected"):
        engine.send(Silence())


async def test_an_engine_that_crashes_is_started_again_after_a_while() -> None:
    witness, clock = Witness(), VirtualClock()
    async with asyncio.timeout(60), witness.engine("good", clock=clock) as engine, engine.video.open() as pictures:
        last = await anext(pictures)
        for delay in (0.5, 1.0):
            pid = pid_of(engine)
            engine.send(React("1", "crash"))
            assert await witness.lost.get() == "the engine closed the connection"
            assert is_gone(pid, 5)
            assert engine.hello is None
            while not clock.sleepers:
                await settle()
            await clock.advance(delay - 0.01)
            assert clock.sleepers
            await clock.advance(0.01)
            assert int((await witness.back.get()).version) != pid
            following = await anext(pictures)
            assert following.sequence > last.sequence
            last = following


async def test_an_engine_that_hangs_up_is_replaced() -> None:
    witness, clock = Witness(), VirtualClock()
    async with asyncio.timeout(60), witness.engine("stubborn", clock=clock) as engine:
        pid = pid_of(engine)
        engine.send(React("1", "hang up"))
        assert await witness.lost.get() == "hanging up"
        while not clock.sleepers:
            await settle()
        assert is_gone(pid)


async def test_an_engine_that_hangs_is_replaced() -> None:
    witness, clock = Witness(), VirtualClock()
    async with asyncio.timeout(60), witness.engine("good", clock=clock) as engine:
        pid = pid_of(engine)
        async with engine.video.open() as pictures:
            for _ in range(4):
                # A picture that came while the clock was going on is older than it looks.
                while engine.last_sign_at != clock.now():
                    await anext(pictures)
                await clock.advance(HUNG - 0.1)
        assert witness.lost.empty()
        engine.send(React("1", "freeze"))
        assert await witness.events.get() == Log("freeze")
        # Not a moment longer: while its process ends, no time may pass in which the next one would be started.
        await clock.advance(HUNG + CHECK_INTERVAL)
        assert await witness.lost.get() == "the engine does not respond"
        while not clock.sleepers:
            await settle()
        assert is_gone(pid)
        await clock.advance(LONGEST_DELAY)
        assert int((await witness.back.get()).version) != pid


async def test_pausing_engine_does_not_count_as_hung() -> None:
    witness, clock = Witness(), VirtualClock()
    async with asyncio.timeout(60), witness.engine("good", clock=clock) as engine:
        async with engine.video.open() as pictures:
            await anext(pictures)
        engine.send(React("1", "pause"))
        assert await witness.events.get() == Pause(True)
        for _ in range(6):
            await clock.advance(HUNG)
        assert witness.lost.empty()
        engine.send(React("2", "go on"))
        while await witness.events.get() != Pause(False):
            pass
        async with engine.video.open() as pictures:
            await anext(pictures)


async def test_an_engine_hears_the_operator() -> None:
    witness = Witness()
    sound = RawAudio(np.array([[100, 200], [-3, -5]], np.int16), 1.0)
    async with asyncio.timeout(60), witness.engine("good") as engine:
        engine.send_audio(sound)
        assert await witness.events.get() == Log("heard (2, 1) 150")
    engine.send_audio(sound)


async def test_an_engine_that_refuses_to_end_is_killed_in_time() -> None:
    # What is waited for on the way, however busy this machine is.
    assert QUIT_TIMEOUT + TERMINATE_TIMEOUT < 2.0
    async with asyncio.timeout(60), Witness().engine("stubborn") as engine:
        pid = pid_of(engine)
    assert is_gone(pid)


async def test_a_fault_of_our_own_is_not_swallowed(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(*_arguments: object, **_options: object) -> None:
        raise ZeroDivisionError

    witness, clock = Witness(), VirtualClock()
    async with asyncio.timeout(60), witness.engine("good", clock=clock) as engine:
        monkeypatch.setattr(embedded, "child_process", fail)
        engine.send(React("1", "crash"))
        await witness.lost.get()
        while not clock.sleepers:
            await settle()
        await clock.advance(1)
    assert f"engine {FAKE} failed" in caplog.text
    assert "ZeroDivisionError" in caplog.text


async def test_an_engine_that_cannot_start_says_why() -> None:
    words = "first line / no graphics pipe is available"
    expected = f"{FAKE} sent no HELLO (status 1): {words}; the log has its output"
    with pytest.raises(LinkError) as refused:
        async with asyncio.timeout(60), Witness().engine("broken"):
            pass
    assert str(refused.value) == expected


async def test_an_engine_that_never_greets_is_not_waited_for(caplog: pytest.LogCaptureFixture) -> None:
    async def enter() -> None:
        async with Witness().engine("mute", clock=clock):
            pass

    clock = VirtualClock()
    async with asyncio.timeout(60):
        with caplog.at_level(logging.INFO):
            entering = asyncio.create_task(enter())
            while f"{FAKE}: thinking" not in caplog.text:
                await settle()
        await clock.advance(START_TIMEOUT - 0.01)
        assert not entering.done()
        await clock.advance(0.01)
        with pytest.raises(LinkError, match=r"sent no HELLO \(status -15\): thinking; the log has its output"):
            await entering


async def test_entering_can_be_given_up() -> None:
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.3), Witness().engine("mute"):
            pass


ADAPTER = f"""
import asyncio
from openrois_avatar.link import embedded
from openrois_avatar.link.embedded import LONGEST_DELAY, EmbeddedEngine
async def main():
    async with EmbeddedEngine("{FAKE}", "stubborn") as engine:
        print(engine.hello.version, flush=True)
        await asyncio.Event().wait()
asyncio.run(main())
"""


async def test_nothing_is_left_behind_when_the_adapter_is_killed() -> None:
    adapter = await asyncio.create_subprocess_exec(sys.executable, "-c", ADAPTER, stdout=PIPE)
    try:
        assert adapter.stdout is not None
        async with asyncio.timeout(60):
            pid = int(await adapter.stdout.readline())
    finally:
        adapter.send_signal(signal.SIGKILL)
        await adapter.wait()
    assert is_gone(pid, 5)


def test_link_works_under_uvloop() -> None:
    async def run() -> int:
        async with asyncio.timeout(60), EmbeddedEngine(FAKE, "good") as engine, engine.video.open() as pictures:
            await anext(pictures)
            return pid_of(engine)

    assert is_gone(uvloop.run(run()), 5)
