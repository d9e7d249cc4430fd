"""One figure: its name, its meaning, and how it is read where it is kept. Pure."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

__all__ = ["Figure"]

OfT = TypeVar("OfT")


@dataclass(frozen=True, slots=True)
class Figure(Generic[OfT]):
    """One figure: its name, and how it is read; None is left out.

    A counter's name ends in `_total`; the unit stands before that (Prometheus' conventions: base units).
    """

    name: str
    kind: Literal["counter", "gauge"]
    help: str
    read: Callable[[OfT], float | None]
