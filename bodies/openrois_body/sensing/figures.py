"""Counts of a sense: what it has analysed, and how often it failed."""

from dataclasses import dataclass

__all__ = ["SenseFigures"]


@dataclass(slots=True)
class SenseFigures:
    """Counts since the adapter began.

    Attributes:
        analysed: pictures or utterances.
        failed: those whose analysis failed.
        lost: those that were not analysed, because too many waited; None where only the newest counts anyway.
        seconds: spent on all of them.
    """

    analysed: int = 0
    failed: int = 0
    lost: int | None = None
    seconds: float = 0.0
