"""Mouth shapes read from sentences: as far open as by their phonemes, in voices that nothing was fitted to."""

from collections.abc import AsyncIterator

import numpy as np
import pytest
from openrois_body.speech.mouth import Opening
from openrois_body.speech.synthesizer import Synthesizer

from tests.support.mouth import agreement, confusion, openings, read_mouth, spoken_by_espeak, spoken_by_flite
from tests.support.mouth_sentences import FITTED, JUDGED

VOICES = (None, "m3", "f2", "f5", "Annie")
"""The language's own voice, and some that nothing was fitted to."""


@pytest.fixture
async def synthesizer() -> AsyncIterator[Synthesizer]:
    async with Synthesizer() as synthesizer:
        yield synthesizer


@pytest.mark.engine
@pytest.mark.parametrize(("language", "least"), [("en", 0.80), ("de", 0.80), ("fr", 0.75), ("es", 0.75), ("ja", 0.75)])
async def test_it_is_as_far_open_as_by_the_phonemes_of_sentences_it_was_not_fitted_to(
    synthesizer: Synthesizer, language: str, least: float
) -> None:
    counts = np.zeros((3, 3), np.int64)
    for number, sentence in enumerate(JUDGED[language]):
        speaker = VOICES[number % len(VOICES)]
        spoken = await spoken_by_espeak(synthesizer, sentence, language, speaker)
        counts += confusion(spoken, read_mouth(spoken.samples, spoken.rate))
    assert agreement(counts) >= least
    # To say the same all the time would be right in so many.
    assert counts.sum(axis=1).max() / counts.sum() < 0.65
    assert all(counts[each, each] == counts[each].max() for each in Opening)


@pytest.mark.usefixtures("flite")
def test_it_reads_a_voice_that_another_program_makes_of_what_persons_said() -> None:
    counts = np.zeros((3, 3), np.int64)
    for sentence in JUDGED["en"]:
        spoken = spoken_by_flite(sentence, "rms")
        counts += confusion(spoken, read_mouth(spoken.samples, spoken.rate))
    assert agreement(counts) >= 0.70


def test_no_sentence_is_both_fitted_and_judged() -> None:
    assert all(len(set(JUDGED[language])) == len(set(FITTED[language])) == 50 for language in FITTED)
    assert not {each for said in FITTED.values() for each in said} & {each for said in JUDGED.values() for each in said}


@pytest.mark.engine
@pytest.mark.parametrize("decibels", [-20, -10, 6, 12])
async def test_how_loud_a_voice_is_changes_little(synthesizer: Synthesizer, decibels: float) -> None:
    for language, speaker in (("en", "f2"), ("de", "m3")):
        spoken = await spoken_by_espeak(synthesizer, " ".join(JUDGED[language][:5]), language, speaker)
        times = np.arange(0, spoken.duration_ms, 10.0)
        loud = np.clip(spoken.samples * 10 ** (decibels / 20), -32_768, 32_767).astype(np.int16)
        before, after = (openings(read_mouth(each, spoken.rate), times) for each in (spoken.samples, loud))
        assert np.mean(before != after) < 0.05
