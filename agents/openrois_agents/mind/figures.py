"""Figures of conversations: what a mind heard, answered and refused. Pure."""

from dataclasses import dataclass, field
from typing import Final

from openrois.metrics.figure import Figure

__all__ = ["MIND_FIGURES", "REFUSALS", "REFUSAL_LABELS", "REFUSED", "MindFigures"]

REFUSALS: Final = ("busy", "consent", "limit")
"""Why a visitor was not answered: another application has the body, no consent, a limit is reached."""

REFUSAL_LABELS: Final = ("reason",)


@dataclass(slots=True)
class MindFigures:
    """What happened since the process began.

    Attributes:
        conversations: that began.
        holds: 1 while one lasts.
        turns: what visitors said in them.
        answers: that came to their end.
        interruptions: answers that were broken off.
        stops: times that a visitor said "stop".
        moves: times that a conversation went on with another body.
        sound: seconds of speech.
        refusals: turns that were not answered, by the reason.
    """

    conversations: int = 0
    holds: int = 0
    turns: int = 0
    answers: int = 0
    interruptions: int = 0
    stops: int = 0
    moves: int = 0
    sound: float = 0.0
    refusals: dict[str, int] = field(default_factory=lambda: dict.fromkeys(REFUSALS, 0))


MIND_FIGURES: Final[tuple[Figure[MindFigures], ...]] = (
    Figure("openrois_mind_conversations_total", "counter", "Conversations that began.", lambda f: f.conversations),
    Figure("openrois_mind_conversing", "gauge", "1 while a conversation lasts.", lambda f: f.holds),
    Figure("openrois_mind_turns_total", "counter", "What visitors said in conversations.", lambda f: f.turns),
    Figure("openrois_mind_answers_total", "counter", "Answers that came to their end.", lambda f: f.answers),
    Figure("openrois_mind_interruptions_total", "counter", "Answers that were broken off.", lambda f: f.interruptions),
    Figure("openrois_mind_stops_total", "counter", 'Times that a visitor said "stop".', lambda f: f.stops),
    Figure(
        "openrois_mind_moves_total",
        "counter",
        "Conversations that went on with another body, as theirs was lost.",
        lambda f: f.moves,
    ),
    Figure("openrois_mind_sound_seconds_total", "counter", "Seconds of speech.", lambda f: f.sound),
)

REFUSED: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_mind_refusals_total",
        "counter",
        "Turns that were not answered, by the reason: another application has the body, no consent, a limit.",
        lambda count: count,
    ),
)
