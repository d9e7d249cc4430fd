"""Metrics of senses, of teleoperation and of speech as sound."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Final

from openrois_media.metrics.figures import FigureGroup

from openrois.metrics.figure import Figure
from openrois_body.sensing.figures import SenseFigures
from openrois_body.speech.speech_control import SpeechFigures, SpeechOutcomes
from openrois_body.teleoperation.operator_control import OperatorFigures

__all__ = ["INPUT", "INPUT_LABELS", "SENSE", "SENSE_LABELS", "SPEECH", "SPEECHES", "SPEECH_LABELS", "body_figures"]

SENSE_LABELS: Final = ("sense",)

SENSE: Final[tuple[Figure[SenseFigures], ...]] = (
    Figure("openrois_sense_analysed_total", "counter", "Pictures or utterances analysed.", lambda s: s.analysed),
    Figure(
        "openrois_sense_failures_total",
        "counter",
        "Pictures or utterances whose analysis failed.",
        lambda s: s.failed,
    ),
    Figure(
        "openrois_sense_lost_total",
        "counter",
        "Utterances that were never analysed, because too many waited.",
        lambda s: s.lost,
    ),
    Figure("openrois_sense_analysis_seconds_total", "counter", "Time spent on analysing.", lambda s: s.seconds),
)
"""Of the senses `vision` (the operator's camera) and `hearing` (speech at the microphone)."""

INPUT_LABELS: Final = ("outcome",)

INPUT: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_input_messages_total",
        "counter",
        "Messages of applications' keyboards, pointers and gamepads, by what became of them.",
        lambda count: count,
    ),
)

SPEECH_LABELS: Final = ("outcome",)

SPEECH: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_speech_frames_total",
        "counter",
        "Frames and messages of applications that speak by sound, by what became of them.",
        lambda count: count,
    ),
)

SPEECHES: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_speeches_total",
        "counter",
        "Speeches as sound that have begun, run dry (each time), finished, or were cut off.",
        lambda count: count,
    ),
)


def body_figures(
    senses: Mapping[str, SenseFigures] | None = None,
    operator: OperatorFigures | None = None,
    speech: SpeechFigures | None = None,
    speeches: SpeechOutcomes | None = None,
) -> tuple[FigureGroup, ...]:
    """Return a copy of the figures.

    Args:
        senses: the figures of each sense, by its name; None without senses.
        operator: the figures of input; None where the body cannot be operated.
        speech: the figures of frames of speech as sound; None where the body plays none.
        speeches: those of whole speeches; None likewise.
    """
    return (
        FigureGroup(SENSE, SENSE_LABELS, tuple(((name,), replace(each)) for name, each in (senses or {}).items())),
        FigureGroup(INPUT, INPUT_LABELS, _by_outcome(operator)),
        FigureGroup(SPEECH, SPEECH_LABELS, _by_outcome(speech)),
        FigureGroup(SPEECHES, SPEECH_LABELS, _by_outcome(speeches)),
    )


def _by_outcome(
    counts: OperatorFigures | SpeechFigures | SpeechOutcomes | None,
) -> tuple[tuple[tuple[str], int], ...]:
    """Return a copy of counts, each behind its name."""
    return () if counts is None else tuple(((name,), count) for name, count in asdict(counts).items())
