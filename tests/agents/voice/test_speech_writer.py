"""Utterances of an agent through a real avatar: what is told of them is what was heard."""

import asyncio
import itertools
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_agents.voice.speech_writer import MAX_WRITTEN, SpeechWriter
from openrois_media import Media
from openrois_media.client.speaking import Speaking, Spoken
from openrois_media.client.stream import News

from openrois.aio.listeners import Listeners
from openrois.client import Client
from tests.support.loopback import PATIENCE
from tests.support.operated import operated_avatar
from tests.support.sounds import tone
from tests.support.voice_agents import hearing

pytestmark = pytest.mark.media

RATE = 24_000


def sound(seconds: float) -> NDArray[np.int16]:
    return tone(seconds, RATE)


class Told:
    """What a writer tells of its utterances."""

    def __init__(self, writer: SpeechWriter) -> None:
        self.steps: list[str | Spoken] = []
        self.broken_off: list[str] = []
        self._news = News()
        writer.started.add(self._start)
        writer.finished.add(self._finish)
        writer.broken_off.add(self.broken_off.append)

    @property
    def ends(self) -> list[Spoken]:
        return [each for each in self.steps if isinstance(each, Spoken)]

    def _start(self) -> None:
        self.steps.append("started")
        self._news.notify()

    def _finish(self, spoken: Spoken) -> None:
        self.steps.append(spoken)
        self._news.notify()

    async def until(self, so: Callable[[], object]) -> None:
        async with asyncio.timeout(PATIENCE):
            await self._news.until(so)


@asynccontextmanager
async def speaking(url: str) -> AsyncIterator[tuple[Client, Media, SpeechWriter, Told]]:
    async with (
        asyncio.timeout(PATIENCE),
        Client(url) as client,
        Media(client) as media,
        media.speech("avatar", rate=RATE) as speech,
        SpeechWriter(speech) as writer,
    ):
        yield client, media, writer, Told(writer)


@pytest.fixture
async def url(tmp_path: Path) -> AsyncIterator[str]:
    async with operated_avatar(tmp_path) as (running, _):
        yield running.url.replace("http", "ws")


async def test_utterances_are_heard_one_after_the_other_and_told_of_in_order(url: str) -> None:
    async with speaking(url) as (_, _, writer, told):
        await writer.write(sound(0.35))
        assert writer.written == pytest.approx(0.35)
        writer.end_utterance()
        writer.end_utterance()
        await writer.write(sound(0.2).tobytes())
        writer.end_utterance()
        await writer.until_over()
        assert told.steps == ["started", Spoken(0.35), "started", Spoken(0.2)]
        assert (writer.position, writer.written, writer.waiting) == (0.0, 0.0, 0.0)


async def test_sound_that_comes_faster_than_it_is_heard_waits_within_the_bound(url: str) -> None:
    async with speaking(url) as (_, _, writer, told):
        writing = asyncio.create_task(writer.write(sound(6.0)))
        most = 0.0
        while not told.steps or writer.position < 1.5:
            most = max(most, writer.waiting)
            await asyncio.sleep(0)
        assert not writing.done()
        assert MAX_WRITTEN - 0.2 < most <= MAX_WRITTEN
        # What was written is what was heard, what the body has, and what waits.
        assert writer.written - writer.position <= MAX_WRITTEN + 1.2
        writer.clear()
        await writing
        assert writer.waiting == 0.0


async def test_an_interruption_is_told_with_what_was_heard_and_the_next_utterance_is_spoken(url: str) -> None:
    async with speaking(url) as (_, media, writer, told), hearing(media) as ear:
        writing = asyncio.create_task(writer.write(sound(6.0)))
        await told.until(lambda: told.steps)
        assert await writer.until_heard(writer.mark().after(0.5 - writer.written))
        writer.clear()
        await writing
        await ear.until_quiet()
        # The viewer may make up a little where a busy machine is late.
        assert told.ends[0].seconds == pytest.approx(ear.loud, abs=0.1)
        await writer.write(sound(0.2))
        writer.end_utterance()
        await writer.until_over()
        first = told.ends[0]
        assert first.interrupted
        assert 0.5 <= first.seconds < 6.0
        assert told.broken_off == []
        assert told.steps == ["started", first, "started", Spoken(0.2)]


async def test_what_was_not_begun_is_told_of_as_interrupted_without_having_started(url: str) -> None:
    async with speaking(url) as (_, _, writer, told):
        for _ in range(2):
            await writer.write(sound(0.5))
            writer.end_utterance()
        await told.until(lambda: told.steps)
        writer.clear()
        writer.clear()
        await writer.until_over()
        assert [type(each) for each in told.steps] == [str, Spoken, Spoken]
        assert [each.interrupted for each in told.ends] == [True, True]
        assert told.ends[1].seconds == 0.0
        writer.clear()


async def test_the_number_of_utterances_that_wait_is_bounded_too(url: str) -> None:
    async with speaking(url) as (_, _, writer, told):

        async def write_all() -> None:
            for _ in range(25):
                await writer.write(sound(0.01))
                writer.end_utterance()

        writing = asyncio.create_task(write_all())
        await told.until(lambda: told.ends)
        assert not writing.done()
        writer.clear()
        await writing
        await writer.until_over()
        assert len(told.ends) == 25
        assert told.steps[:2] == ["started", Spoken(0.01)]


async def test_a_body_that_is_stopped_ends_the_utterance_while_the_agent_thinks_and_the_rest_is_dropped(
    url: str,
) -> None:
    async with speaking(url) as (client, _, writer, told):
        await writer.write(sound(0.6))
        await told.until(lambda: told.steps)
        await client.component("avatar/speech_stream").command("stop")
        await told.until(lambda: told.ends)
        assert told.ends[0].reason.startswith("the speech was stopped")
        assert told.broken_off == [told.ends[0].reason]
        # All of this is of the utterance that was interrupted.
        await writer.write(sound(6.0))
        assert not await writer.until_heard(writer.mark())
        writer.end_utterance()
        await writer.write(sound(0.1))
        writer.end_utterance()
        await writer.until_over()
        assert told.ends[1:] == [Spoken(0.1)]


async def test_a_lost_connection_ends_the_utterance_and_speech_without_one_is_told_of_as_unheard(url: str) -> None:
    async with speaking(url) as (_, media, writer, told):
        writing = asyncio.create_task(writer.write(sound(6.0)))
        await told.until(lambda: told.steps)
        for peer in media._streams._peers.values():  # type: ignore[union-attr]
            await peer.connection.close()
        await told.until(lambda: told.ends)
        assert told.ends[0].reason == "the connection over which it was spoken was lost"
        await writing
        writer.end_utterance()
        while told.ends[-1].interrupted:
            await writer.write(sound(0.1))
            writer.end_utterance()
            await writer.until_over()
        assert told.ends[-1] == Spoken(0.1)


async def test_the_end_of_the_block_silences_what_is_spoken_and_tells_of_it(url: str) -> None:
    async with speaking(url) as (_, _, writer, told):
        await writer.write(sound(1.5))
        await told.until(lambda: told.steps)
    assert len(told.ends) == 1
    assert told.ends[0].interrupted
    assert 0.0 < told.ends[0].seconds < 1.5
    with pytest.raises(RuntimeError, match="within the block of the SpeechWriter: it has ended"):
        await writer.write(sound(0.1))


async def test_other_sound_is_refused(url: str) -> None:
    async with speaking(url) as (_, _, writer, told):
        with pytest.raises(ValueError, match="whole samples of 2 bytes, not 3 bytes"):
            await writer.write(b"abc")
        with pytest.raises(ValueError, match="must be int16"):
            await writer.write(np.zeros((2, 2), np.int16))
        assert told.steps == []


async def test_a_mark_is_heard_when_its_sound_was_and_never_when_that_was_silenced(url: str) -> None:
    async with speaking(url) as (_, _, writer, told):
        start = writer.mark()
        assert start.seconds == 0.0
        await writer.write(sound(1.5))
        end = writer.mark()
        assert (end.utterance, end.seconds) == (start.utterance, pytest.approx(1.5))
        assert await writer.until_heard(start)
        assert told.steps == ["started"]
        assert await writer.until_heard(start.after(0.5))
        assert 0.5 <= writer.position < 1.5
        writer.clear()
        assert not await writer.until_heard(end)
        assert await writer.until_heard(start.after(told.ends[0].seconds))
        await writer.until_ended(end)
        silenced = writer.mark()
        writer.clear()
        assert not await writer.until_heard(silenced)


def failing(monkeypatch: pytest.MonkeyPatch, name: str, at: int) -> None:
    """Let one call of a method of the speech fail with a mistake."""
    method: Callable[..., Awaitable[Any]] = getattr(Speaking, name)
    calls = 0

    async def call(speech: Speaking, *arguments: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == at:
            raise ValueError("a mistake")
        return await method(speech, *arguments)

    monkeypatch.setattr(Speaking, name, call)


@pytest.mark.parametrize(("name", "at"), [("push", 1), ("push", 3), ("finish", 1)])
async def test_a_mistake_breaks_an_utterance_off_and_the_next_one_is_spoken(
    url: str, monkeypatch: pytest.MonkeyPatch, name: str, at: int
) -> None:
    async with speaking(url) as (_, _, writer, told):
        failing(monkeypatch, name, at)
        # More than waits at once: `write` waits for room meanwhile.
        await writer.write(sound(4.0 if name == "push" else 0.3))
        mark = writer.mark()
        writer.end_utterance()
        await writer.until_ended(mark)
        await writer.until_over()
        assert told.ends[0].reason == "a mistake"
        assert "a mistake" in told.broken_off
        while told.ends[-1].interrupted:
            await writer.write(sound(0.2))
            writer.end_utterance()
            await writer.until_over()
        assert told.ends[-1] == Spoken(0.2)


def failing_events(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the first step that the body tells end its reading with a mistake."""
    events, calls = Speaking.events, itertools.count()

    async def read(speech: Speaking) -> AsyncIterator[Any]:
        async for step in events(speech):
            if next(calls) == 0:
                raise ValueError("a mistake")
            yield step

    monkeypatch.setattr(Speaking, "events", read)


def failing_listener(told: Listeners[*tuple[Any, ...]]) -> None:
    """Let a listener fail with a mistake, once."""
    calls = itertools.count()

    def listen(*what: Any) -> None:
        if next(calls) == 0:
            raise ValueError("a mistake")

    told.add(listen)


@pytest.mark.parametrize("where", ["events", "started"])
async def test_a_mistake_in_following_the_body_breaks_an_utterance_off_and_the_next_one_is_spoken(
    url: str, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    if where == "events":
        failing_events(monkeypatch)
    async with speaking(url) as (_, _, writer, told):
        if where == "started":
            failing_listener(writer.started)
        await writer.write(sound(6.0))
        writer.end_utterance()
        await writer.until_over()
        (end,) = told.ends
        assert end.reason == "a mistake"
        assert end.seconds < 6.0
        assert told.broken_off == ["a mistake"]
        await writer.write(sound(0.2))
        writer.end_utterance()
        await writer.until_over()
        assert told.steps[-2:] == ["started", Spoken(0.2)]


async def test_a_body_that_does_not_fall_silent_does_not_hold_up_the_end_of_what_cannot_be_followed(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing_events(monkeypatch)
    hang = asyncio.Event()

    async def clear(speech: Speaking) -> Spoken:
        await hang.wait()
        return Spoken(0.0)

    async with speaking(url) as (_, _, writer, told):
        monkeypatch.setattr(Speaking, "clear", clear)
        await writer.write(sound(6.0))
        writer.end_utterance()
        await told.until(lambda: told.ends)
        assert told.ends[0].reason == "a mistake"
        assert told.ends[0].seconds < 6.0
        monkeypatch.undo()


@pytest.mark.parametrize("name", ["broken_off", "finished"])
async def test_a_listener_that_fails_at_the_end_of_an_utterance_does_not_end_the_next_one(url: str, name: str) -> None:
    async with speaking(url) as (_, _, writer, told):
        failing_listener(getattr(writer, name))
        await writer.write(sound(1.5))
        await told.until(lambda: told.steps)
        failing = writer.mark()
        # The body breaks it off.
        for sender in writer._speaking._spoken:
            sender.clear()
        await writer.until_ended(failing)
        writer.end_utterance()
        await writer.write(sound(0.2))
        writer.end_utterance()
        await writer.until_over()
        assert told.ends[-1] == Spoken(0.2)
        assert [each.interrupted for each in told.ends] == [True, False]
