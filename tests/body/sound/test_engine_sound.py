import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from openrois_body.sound.engine_sound import (
    APART,
    BLOCK,
    LAG_MARGIN,
    LAG_MEMORY,
    LENGTH,
    LONGEST_LAG,
    SEAM,
    EngineSound,
    SoundLag,
)

START = 48_000 * 100
"""The sample at which everything begins here."""
LOUD = 10_000
# The steepest step of the tone, and what a cross-fade of 5 ms adds to it at most.
SMOOTH = LOUD * 2 * np.pi * 200 / 48_000 + 2 * LOUD / SEAM


def tone(first: int, count: int = BLOCK, channels: int = 1) -> NDArray[np.int16]:
    """A steady tone by the number of its samples: what is at a wrong place shows."""
    moments = np.arange(first - START, first - START + count)
    wave = np.round(LOUD * np.sin(2 * np.pi * 200 * moments / 48_000)).astype(np.int16)
    return np.repeat(wave[:, np.newaxis], channels, axis=1)


def started(channels: int = 1) -> EngineSound:
    sound = EngineSound(channels)
    sound.start(START)
    return sound


def put(sound: EngineSound, first: int, count: int = BLOCK, stamp: int | None = None) -> int:
    """Sound of the moments that its stamp says, or of others."""
    return sound.put(tone(first, count), (first if stamp is None else stamp) / 48_000)


def taken(sound: EngineSound, blocks: int, first: int = START) -> NDArray[np.int16]:
    return np.concatenate([sound.next_block(first + number * BLOCK) for number in range(blocks)])


def steepest(sound: NDArray[np.int16]) -> int:
    return int(np.abs(np.diff(sound[:, 0].astype(int))).max())


def test_without_sound_there_is_silence() -> None:
    sound = started(2)
    block = sound.next_block(START)
    assert block.shape == (BLOCK, 2)
    assert block.dtype == np.int16
    assert not block.any()
    assert sound.made_up == 0


@pytest.mark.parametrize("size", [BLOCK, 1600, 441])
@pytest.mark.parametrize("offset", [0, 123])
def test_every_sample_lies_where_its_stamp_says(size: int, offset: int) -> None:
    sound = started()
    for first in range(START + offset, START + 30 * BLOCK, size):
        assert put(sound, first, size) == first
    heard = taken(sound, 28)
    begin = offset + SEAM
    np.testing.assert_array_equal(heard[begin:], tone(START + begin, len(heard) - begin))
    assert not heard[:offset].any()
    assert sound.late == sound.made_up == 0


def test_stamps_that_jitter_move_nothing() -> None:
    sound, random = started(), np.random.default_rng(1)
    for number in range(60):
        first = START + number * BLOCK
        put(sound, first, stamp=first + int(random.integers(-30, 30)))
    heard = taken(sound, 59)
    # The first piece lies where its own stamp says, and the others behind it.
    shifts = [
        abs(heard[SEAM + 100 + each : 9000 + each] - tone(START + SEAM + 100, 8900 - SEAM)).max()
        for each in range(-30, 30)
    ]
    assert min(shifts) == 0


@pytest.mark.parametrize("speed", [1.001, 0.999, 1.01, 0.99])
def test_drift_is_followed_without_a_click(speed: float) -> None:
    sound, heard, behind, due = started(), [], [], START
    for number in range(1500):
        stamp = START + round(number * BLOCK / speed)
        # The tone as a sample clock makes it that is too fast or too slow.
        place = put(sound, START + number * BLOCK, stamp=stamp)
        behind.append(stamp - place)
        while due < stamp - 2 * BLOCK:
            heard.append(sound.next_block(due))
            due += BLOCK
    assert max(map(abs, behind)) < 0.010 * 48_000
    assert steepest(np.concatenate(heard)) < SMOOTH
    assert sound.late == 0


def test_a_pause_of_the_engine_is_a_pause_and_what_follows_lies_where_it_belongs() -> None:
    sound = started()
    after = START + 5 * BLOCK + APART + 100
    for number in range(5):
        put(sound, START + number * BLOCK)
    for number in range(5):
        put(sound, after + number * BLOCK)
    heard = taken(sound, 12)
    assert steepest(heard) < SMOOTH
    gap = heard[5 * BLOCK : after - START]
    assert np.abs(gap[:100]).max() > LOUD / 2
    assert not gap[BLOCK:].any()
    np.testing.assert_array_equal(heard[after - START + SEAM :][: 3 * BLOCK], tone(after + SEAM, 3 * BLOCK))
    assert sound.made_up >= BLOCK


def test_late_sound_is_lost_and_moves_nothing() -> None:
    sound = started()
    put(sound, START)
    put(sound, START + BLOCK)
    heard = [taken(sound, 4)]
    put(sound, START + 2 * BLOCK)
    put(sound, START + 3 * BLOCK, BLOCK + 300)
    put(sound, START + 4 * BLOCK + 300, 2 * BLOCK)
    heard.append(taken(sound, 2, START + 4 * BLOCK))
    assert sound.late == 2 * BLOCK
    whole = np.concatenate(heard)
    assert steepest(whole) < SMOOTH
    assert not whole[3 * BLOCK : 4 * BLOCK].any()
    np.testing.assert_array_equal(whole[4 * BLOCK + SEAM :], tone(START + 4 * BLOCK + SEAM, 2 * BLOCK - SEAM))


def test_a_gap_within_a_block_is_faded_on_both_sides() -> None:
    sound = started()
    put(sound, START, 1300)
    put(sound, START + 3200, 1600)
    heard = taken(sound, 5)
    assert steepest(heard) < SMOOTH
    assert sound.made_up == BLOCK


def test_sound_that_returns_at_the_end_of_a_block_has_faded_in_there() -> None:
    sound = started()
    put(sound, START + BLOCK - 20, BLOCK)
    heard = taken(sound, 2)
    assert abs(int(heard[BLOCK - 20, 0])) < LOUD / 10
    np.testing.assert_array_equal(heard[BLOCK:][:900], tone(START + BLOCK, 900))


def test_buffered_sound_stays_when_stamps_go_back() -> None:
    sound = started()
    put(sound, START, 4 * BLOCK)
    sound.put(np.full((3 * BLOCK, 1), 99, np.int16), (START + BLOCK) / 48_000)
    np.testing.assert_array_equal(taken(sound, 4)[SEAM:], tone(START + SEAM, 4 * BLOCK - SEAM))


def test_no_more_is_kept_than_there_is_room_for() -> None:
    sound = started()
    put(sound, START, LENGTH + 5 * BLOCK)
    put(sound, START + LENGTH + 50 * BLOCK)
    blocks = LENGTH // BLOCK
    np.testing.assert_array_equal(taken(sound, blocks)[SEAM:], tone(START + SEAM, LENGTH - SEAM))
    assert not taken(sound, 6, START + LENGTH)[BLOCK:].any()


def test_skipped_sound_is_dropped() -> None:
    sound = started()
    put(sound, START, 10 * BLOCK)
    sound.next_block(START + 5 * BLOCK)
    later = START + LENGTH
    assert not taken(sound, 6, later)[BLOCK:].any()


def test_starting_forgets_all_sound() -> None:
    sound = started()
    put(sound, START, 10 * BLOCK)
    sound.next_block(START)
    sound.start(START + BLOCK)
    assert not taken(sound, 8, START + BLOCK).any()


def test_nothing_is_as_good_as_no_sound() -> None:
    sound = started()
    nothing = np.zeros((0, 1), np.int16)
    assert sound.put(nothing, START / 48_000) == START
    assert not taken(sound, 2).any()
    put(sound, START, stamp=START + 200)
    assert sound.put(nothing, START / 48_000) == START + BLOCK


def test_channels_are_mixed_down_or_doubled() -> None:
    mono, stereo = started(1), started(2)
    left_right = np.tile(np.array([[30_000, 32_000]], np.int16), (BLOCK, 1))
    mono.put(left_right, START / 48_000)
    stereo.put(left_right[:, :1], START / 48_000)
    assert mono.next_block(START)[-1].tolist() == [31_000]
    assert stereo.next_block(START)[-1].tolist() == [30_000, 30_000]


@given(
    st.lists(st.tuples(st.integers(-50_000, 70_000), st.integers(0, 3000), st.integers(0, 5))), st.sampled_from([1, 2])
)
def test_whatever_comes_there_is_a_block_and_no_wrong_sample(pieces: list[tuple[int, int, int]], channels: int) -> None:
    sound, due = started(channels), START
    for stamp, count, blocks in pieces:
        sound.put(np.full((count, 1), 1000, np.int16), (due + stamp) / 48_000)
        for _ in range(blocks):
            block = sound.next_block(due)
            assert block.shape == (BLOCK, channels)
            assert 0 <= block.min() <= block.max() <= 1000
            due += BLOCK


def test_sound_that_is_sent_ahead_is_not_waited_for() -> None:
    lag = SoundLag()
    assert lag.seconds == 0
    for number in range(100):
        lag.arrived(-0.04, 10 + number / 50)
        assert lag.seconds == 0


def test_late_sound_is_waited_for_at_once_and_a_while() -> None:
    lag = SoundLag()
    for number in range(500):
        late = 0.05 if number == 100 else 0.01
        lag.arrived(late, number / 50)
        remembered = 100 <= number < 100 + 100 * LAG_MEMORY
        if number < 100 or not remembered:
            assert lag.seconds == pytest.approx(0.01 + LAG_MARGIN)
        elif number < 100 + 50 * LAG_MEMORY:
            assert lag.seconds == pytest.approx(0.05 + LAG_MARGIN)


def test_delay_is_bounded() -> None:
    lag = SoundLag()
    lag.arrived(0.9, 1)
    assert lag.seconds == LONGEST_LAG


def test_old_lag_is_forgotten_at_once() -> None:
    lag = SoundLag()
    lag.arrived(0.1, 1)
    lag.arrived(0.01, 1 + 2 * LAG_MEMORY)
    assert lag.seconds == pytest.approx(0.01 + LAG_MARGIN)
