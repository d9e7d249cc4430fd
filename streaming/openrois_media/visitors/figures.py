"""Counts of visitors of one body, and of what of theirs is relayed. Pure."""

from dataclasses import dataclass

__all__ = ["VisitorFigures"]


@dataclass(frozen=True, slots=True)
class VisitorFigures:
    """Visitors at one moment.

    Attributes:
        present: visitors that send.
        refused: how often one was refused because as many as may were there.
        relayed: streams over which listeners receive what visitors send.
    """

    present: int = 0
    refused: int = 0
    relayed: int = 0
