"""A speech in the body's sound whose sound comes while it is played, on a clock turned by hand."""

from collections.abc import AsyncIterator

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.sound.engine_sound import BLOCK, SEAM
from openrois_body.sound.mixer import BodySound
from openrois_body.sound.playback import AHEAD_LIMIT, SoundOverrun

from tests.body.sound.test_mixer import START, Listener, constant, play, start
from tests.support.streaming import VirtualClock, settle


class Room:
    def __init__(self) -> None:
        self.clock = VirtualClock(now=START)
        self.sound = BodySound(self.clock)
        self.listener: Listener

    def heard(self) -> NDArray[np.int16]:
        """The sound from its first sample to its last one."""
        loud = np.flatnonzero(self.listener.sound)
        return self.listener.sound[loud[0] : loud[-1] + 1] if len(loud) else self.listener.sound[:0]


@pytest.fixture
async def room() -> AsyncIterator[Room]:
    room = Room()
    async with room.sound.open() as blocks:
        room.listener = Listener(blocks)
        await settle()
        yield room
        await room.listener.stop()


async def test_sound_that_comes_while_it_is_played_is_appended_without_a_seam(room: Room) -> None:
    playback = room.sound.play()
    assert playback.end is None
    wave = (np.sin(np.arange(4 * BLOCK) / 20) * 9000 + 10_000).astype(np.int16)
    starts = []
    for part in np.split(wave, 4):
        starts.append(playback.push(part))
        await room.clock.advance(0.02)
    assert starts == pytest.approx([1000.06, 1000.08, 1000.1, 1000.12])
    assert playback.end == pytest.approx(1000.14)
    playback.finish()
    await room.clock.advance(0.2)
    heard = room.heard()
    assert np.array_equal(heard[SEAM : len(wave)], wave[SEAM:])
    assert len(heard) <= len(wave) + SEAM
    assert (playback.pushed, playback.played, playback.heard) == (len(wave),) * 3


async def test_where_nothing_has_come_there_is_silence_between_fades_and_the_rest_is_played_later(room: Room) -> None:
    playback = room.sound.play()
    first = playback.push(constant(8000, 1000))
    await room.clock.advance(0.5)
    assert playback.played == 1000
    second = playback.push(constant(8000, 1000))
    assert second - room.clock.now() == pytest.approx(0.05, abs=0.011)
    await room.clock.advance(0.2)
    sound, zero = room.listener.sound, room.listener.blocks[0].captured_at
    gap = sound[round((first - zero) * 48_000) + 1000 : round((second - zero) * 48_000)]
    assert not gap[SEAM:].any()
    assert np.all(np.diff(gap[:SEAM].astype(int)) <= 0)
    steps = np.abs(np.diff(sound.astype(int)))
    assert steps.max() <= 8000 // SEAM + 2
    assert playback.moment(500) == pytest.approx(first + 500 / 48_000)
    assert playback.moment(1500) == pytest.approx(second + 500 / 48_000)
    assert playback.moment(2000) is None


async def test_stopping_fades_out_within_a_block_and_keeps_the_rest(room: Room) -> None:
    playback = room.sound.play()
    begins = playback.push(constant(6000, 48_000))
    await room.clock.advance(begins - room.clock.now() + 0.1)
    stopped = room.clock.now()
    playback.stop()
    await room.clock.advance(0.3)
    heard = room.heard()
    assert begins + len(heard) / 48_000 <= stopped + 0.025 + 0.001
    assert playback.heard == pytest.approx(0.1 * 48_000, abs=BLOCK)
    rest = playback.take_rest()
    assert len(rest) == 48_000 - playback.heard
    assert playback.played == playback.heard
    with pytest.raises(ValueError, match="before finish or stop"):
        playback.push(constant(1, 10))


async def test_stopping_after_it_ran_dry_keeps_all_as_heard(room: Room) -> None:
    playback = room.sound.play()
    playback.push(constant(6000, 480))
    await room.clock.advance(0.5)
    playback.stop()
    await room.clock.advance(0.1)
    assert (playback.heard, len(playback.take_rest()), playback.is_settled) == (480, 0, True)


async def test_a_speech_behind_it_waits_for_its_end(room: Room) -> None:
    playback = room.sound.play()
    playback.push(constant(5000, 9600))
    with pytest.raises(ValueError, match="wait for its turn"):
        room.sound.play()
    playback.finish()
    following = play(room.sound, constant(2000, 960))
    assert start(following) == playback.end
    assert following.end is not None
    await room.clock.advance(0.5)
    assert start(play(room.sound, constant(1, 1))) > following.end


async def test_time_passes_without_a_reader() -> None:
    clock = VirtualClock(now=START)
    playback = BodySound(clock).play()
    begins = playback.push(constant(5000, 48_000))
    await clock.advance(begins - START + 0.5)
    assert playback.played == pytest.approx(24_000, abs=BLOCK)
    playback.stop()
    assert playback.heard == pytest.approx(24_000, abs=BLOCK)


async def test_a_push_beyond_the_limit_is_refused_and_the_sound_before_it_stays(room: Room) -> None:
    playback = room.sound.play()
    playback.push(constant(1, round(AHEAD_LIMIT * 48_000)))
    with pytest.raises(SoundOverrun, match="60 seconds"):
        playback.push(constant(1, 1))
    assert playback.pushed == AHEAD_LIMIT * 48_000


async def test_for_hours_of_starts_and_stops_little_is_remembered(room: Room) -> None:
    playback = room.sound.play()
    for _ in range(200):
        playback.push(constant(500, 960))
        await room.clock.advance(0.5)
    assert len(playback._runs) < 20
    assert playback.played == 200 * 960


async def test_behind_the_last_sample_is_the_end_once_that_is_set(room: Room) -> None:
    playback = room.sound.play()
    playback.finish()
    assert playback.moment(0) is None
    playback = room.sound.play()
    playback.push(constant(500, 960))
    assert playback.moment(960) is None
    playback.finish()
    assert playback.moment(960) == playback.moment(1000) == playback.end
    assert playback.moment(1100) is None
