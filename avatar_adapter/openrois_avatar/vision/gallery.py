"""Who is known by face: likenesses with names, in memory only; and when somebody looks like none of them."""

from collections import Counter, deque
from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["MAX_ENROLLED", "Gallery", "Likeness", "Opinion"]

Likeness = NDArray[np.float32]
"""What a face looks like, as a vector: the nearer two are, the more alike the faces."""

MAX_ENROLLED: Final = 100
"""Persons that can be enrolled."""
_OPINIONS: Final = 5
_AGREEING: Final = 3
"""Of so many looks at a person so many have to agree."""


class Gallery:
    """The likenesses of those who are enrolled. They are biometric data: nothing of them leaves this object.

    It is filled in one thread and may be asked in another one.
    """

    def __init__(self) -> None:
        self._enrolled: Mapping[str, NDArray[np.float32]] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Who is enrolled, in alphabetical order."""
        return tuple(sorted(self._enrolled))

    @property
    def is_full(self) -> bool:
        """Whether nobody else can be enrolled."""
        return len(self._enrolled) >= MAX_ENROLLED

    def enrol(self, name: str, likenesses: Iterable[Likeness]) -> None:
        """Remember somebody, in place of whoever had the name."""
        self._enrolled = {**self._enrolled, name: np.stack(list(likenesses))}

    def forget(self, name: str) -> bool:
        """Forget somebody; whether the name was known."""
        known = name in self._enrolled
        self._enrolled = {each: seen for each, seen in self._enrolled.items() if each != name}
        return known

    def who(self, likeness: Likeness, limit: float) -> str | None:
        """Return the name of the nearest who is enrolled, or None where nobody is nearer than `limit`."""
        nearest, name = limit, None
        for each, seen in self._enrolled.items():
            distance = float(np.linalg.norm(seen - likeness, axis=1).min())
            if distance < nearest:
                nearest, name = distance, each
        return name


class Opinion:
    """Who one person is, from several looks: one look alone decides nothing."""

    def __init__(self) -> None:
        self._looks: deque[str | None] = deque(maxlen=_OPINIONS)

    def take(self, name: str | None) -> None:
        """Take what one look says."""
        self._looks.append(name)

    @property
    def name(self) -> str | None:
        """Who it is; None for nobody who is known, and as long as the looks do not agree."""
        if not self._looks:
            return None
        name, votes = Counter(self._looks).most_common(1)[0]
        return name if votes >= _AGREEING else None
