"""Enrolled persons: likenesses with names, in memory only, and the identification of a face among them. Pure."""

from collections import Counter, deque
from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["MAX_ENROLLED", "Gallery", "Likeness", "Opinion"]

Likeness = NDArray[np.float32]
"""A face as a vector: the nearer two vectors are, the more alike the faces."""

MAX_ENROLLED: Final = 100
"""Persons that can be enrolled."""
_OPINIONS: Final = 5
_AGREEING: Final = 3
"""Of so many recognitions of a person so many have to agree."""


class Gallery:
    """The likenesses of the enrolled persons. They are biometric data, and do not leave this object.

    It is filled in one thread and may be asked in another one.
    """

    def __init__(self) -> None:
        self._enrolled: Mapping[str, NDArray[np.float32]] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the enrolled persons, in alphabetical order."""
        return tuple(sorted(self._enrolled))

    @property
    def is_full(self) -> bool:
        """Whether no further person can be enrolled."""
        return len(self._enrolled) >= MAX_ENROLLED

    def enrol(self, name: str, likenesses: Iterable[Likeness]) -> None:
        """Enrol a person, replacing another one of the name."""
        self._enrolled = {**self._enrolled, name: np.stack(list(likenesses))}

    def remove_person(self, name: str) -> bool:
        """Forget a person; return whether the name was known."""
        known = name in self._enrolled
        self._enrolled = {each: seen for each, seen in self._enrolled.items() if each != name}
        return known

    def identify(self, likeness: Likeness, limit: float) -> str | None:
        """Return the name of the nearest enrolled person, or None where none is nearer than `limit`."""
        nearest, name = limit, None
        for each, seen in self._enrolled.items():
            distance = float(np.linalg.norm(seen - likeness, axis=1).min())
            if distance < nearest:
                nearest, name = distance, each
        return name


class Opinion:
    """The identity of one person by a vote of several recognitions."""

    def __init__(self) -> None:
        self._looks: deque[str | None] = deque(maxlen=_OPINIONS)

    def add_vote(self, name: str | None) -> None:
        """Add the result of one recognition."""
        self._looks.append(name)

    @property
    def name(self) -> str | None:
        """The name of the person; None for an unknown one, and as long as the votes do not agree."""
        if not self._looks:
            return None
        name, votes = Counter(self._looks).most_common(1)[0]
        return name if votes >= _AGREEING else None
