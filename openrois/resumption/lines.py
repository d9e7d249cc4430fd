"""Lines of sessions: tokens by their digests, generations, and what each line holds. Pure."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Final

__all__ = ["MAX_SPENT", "Change", "Freed", "Held", "Holding", "Line", "Redemption", "last_changes"]

MAX_SPENT: Final = 64
"""Used tokens of one line that are kept, to notice when one comes a second time."""


@dataclass(frozen=True, slots=True)
class Redemption:
    """The finding about a token that was shown.

    Attributes:
        line_id: its line; empty where the token is unknown, or another subject's.
        generation: of the line from now on: one more than before.
        is_replayed: the token was used before, or its line revoked: now the line is revoked, and holds nothing.
    """

    line_id: str = ""
    generation: int = 0
    is_replayed: bool = False


@dataclass(frozen=True, slots=True)
class Held:
    """A line holds a component from this epoch on."""

    component_ref: str
    engine_id: str
    line_id: str
    epoch: int


@dataclass(frozen=True, slots=True)
class Freed:
    """No line holds a component any more; `epoch` is the one that is over."""

    component_ref: str
    epoch: int


Change = Held | Freed


@dataclass(frozen=True, slots=True)
class Holding:
    """A component that a line holds, with the subject and the rank of the line."""

    component_ref: str
    engine_id: str
    line_id: str
    epoch: int
    subject: str
    rank: str = ""


@dataclass(frozen=True, slots=True)
class Line:
    """An application's session over all its connections.

    Attributes:
        subject: of its principal.
        generation: how often it was resumed.
        good: the digest of the token that resumes it; None where there is none.
        spent: digests of tokens that it had before, the newest last.
        is_revoked: a token of it was shown a second time.
        rank: of its principal when its last token was issued.
    """

    subject: str
    generation: int
    good: bytes | None = field(default=None, repr=False)
    spent: tuple[bytes, ...] = field(default=(), repr=False)
    is_revoked: bool = False
    rank: str = ""

    def issued(self, generation: int, subject: str, digest: bytes, rank: str) -> "Line | None":
        """Return the line with this digest as its good one; None where it is revoked, or was resumed since."""
        if self.is_revoked or generation < self.generation or digest in self.spent:
            return None
        if digest == self.good:
            return self
        return replace(self._used_up(), subject=subject, generation=generation, good=digest, rank=rank)

    def redeemed(self, digest: bytes) -> "Line":
        """Return the line after one of its tokens was shown; it is revoked where that was used before."""
        used_up = self._used_up()
        if self.good != digest:
            return replace(used_up, is_revoked=True)
        return replace(used_up, generation=self.generation + 1)

    def _used_up(self) -> "Line":
        if self.good is None:
            return self
        return replace(self, good=None, spent=(*self.spent, self.good)[-MAX_SPENT:])


def last_changes(changes: Iterable[Change]) -> dict[str, Change]:
    """Return of each component the change with the greatest epoch; of two with the same, the later."""
    found: dict[str, Change] = {}
    for change in changes:
        former = found.get(change.component_ref)
        if former is None or change.epoch >= former.epoch:
            found[change.component_ref] = change
    return found
