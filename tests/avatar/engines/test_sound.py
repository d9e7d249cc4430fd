import numpy as np
import pytest
from openrois_avatar.engines.animation.reactions import REACTIONS
from openrois_avatar.engines.sound import BLOCK, PERIOD, RATE, Samples, Sound

CUED = ("nod", "shake_head", "wave", "bow", "shrug", "surprise", "raise_hand", "clap")


def stream(sound: Sound, start: float, seconds: float) -> Samples:
    blocks = [sound.block(start + number * PERIOD) for number in range(int(seconds / PERIOD))]
    assert {(block.shape, str(block.dtype)) for block in blocks} == {((BLOCK, 1), "int16")}
    return np.concatenate(blocks)[:, 0]


def test_at_rest_there_is_silence() -> None:
    assert not stream(Sound(), 5.0, 0.2).any()


@pytest.mark.parametrize("name", REACTIONS)
def test_a_cue_is_soft_short_and_ends_in_silence(name: str) -> None:
    sound = Sound()
    sound.cue(name, 5.0)
    samples = stream(sound, 5.0, 3.0)
    peak = int(np.abs(samples.astype(int)).max())
    # -20 dBFS is a tenth of full scale.
    assert (3000 <= peak <= 3280) if name in CUED else peak == 0
    assert not samples[-RATE // 2 :].any()


@pytest.mark.parametrize("name", CUED)
def test_a_cue_does_not_click(name: str) -> None:
    sound = Sound()
    sound.cue(name, 5.0)
    samples = stream(sound, 5.0, 3.0).astype(int)
    heard = np.flatnonzero(samples)
    assert abs(samples[heard[0]]) < 400
    assert abs(samples[heard[-1]]) < 100


def test_a_cue_starts_at_its_time_within_a_block_and_goes_on_in_the_next() -> None:
    sound, aligned = Sound(), Sound()
    sound.cue("clap", 5.0)
    aligned.cue("clap", 5.0)
    shifted = stream(sound, 4.99, 3.0)
    assert np.array_equal(shifted[RATE // 100 : RATE], stream(aligned, 5.0, 3.0)[: RATE - RATE // 100])


def test_a_cue_in_the_future_is_not_lost() -> None:
    sound = Sound()
    sound.cue("nod", 6.0)
    assert not stream(sound, 5.0, 0.98).any()
    assert stream(sound, 5.98, 0.2).any()


def test_claps_are_heard_when_the_hands_meet() -> None:
    sound = Sound()
    sound.cue("clap", 0.0)
    samples = np.abs(stream(sound, 0.0, 2.5).astype(int))
    hands = REACTIONS["clap"].curves["left.out"]
    for beat in (0.78, 1.06, 1.34, 1.62, 1.90):
        assert samples[int((beat - 0.05) * RATE) : int((beat - 0.01) * RATE)].max() < 300
        assert samples[int(beat * RATE) : int((beat + 0.03) * RATE)].max() > 800
        assert hands(beat) == pytest.approx(min(hands(beat + shift / 100) for shift in range(-6, 7)), abs=1e-9)


def test_several_cues_mix_and_hush_ends_them_all() -> None:
    sound = Sound()
    for number in range(9):
        sound.cue("nod", 5.0 + number / 1000)
    alone = Sound()
    alone.cue("nod", 5.0)
    single, loud = (int(np.abs(one.block(5.02).astype(int)).max()) for one in (alone, sound))
    assert single < loud <= 4 * single + 400
    sound.hush()
    assert not sound.block(5.12).any()


def test_the_radio_is_heard_as_far_as_it_is_near_and_without_a_step() -> None:
    sound = Sound()
    assert not sound.block(7.0).any()
    blocks = [sound.block(7.02 + number * PERIOD, min(1.0, number / 10)) for number in range(60)]
    blocks += [sound.block(7.02 + number * PERIOD) for number in range(60, 62)]
    played = np.concatenate(blocks)[:, 0].astype(int)
    assert played[0] == 0
    assert 800 < np.abs(played).max() <= 0.05 * 32767 + 1
    assert np.abs(np.diff(played)).max() < 220
    assert not blocks[-1].any()
    sound.cue("nod", 9.0)
    sound.hush()
    assert sound.block(9.0, 1.0).any()
