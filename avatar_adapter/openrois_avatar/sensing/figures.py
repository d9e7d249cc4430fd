"""What a sense has analysed so far, and how often it could not; counted where it happens, read by who measures."""

from dataclasses import dataclass

__all__ = ["SenseFigures"]


@dataclass(slots=True)
class SenseFigures:
    """Counts since the adapter began.

    Attributes:
        analysed: pictures or utterances.
        failed: those that what analyses them failed at.
        lost: those that were never analysed, because too many waited; None where only the newest is wanted anyway.
        seconds: spent on all of them.
    """

    analysed: int = 0
    failed: int = 0
    lost: int | None = None
    seconds: float = 0.0
