"""Loans: parts that were taken for a time from a holder of lower rank, which has them back afterwards. Pure."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

__all__ = ["Lender", "Loan", "Loans"]


@dataclass(frozen=True, slots=True)
class Loan:
    """The terms on which a holder has a part that is another session's.

    Attributes:
        until: monotonic seconds at which it goes back.
        for_one: whether it goes back as soon as what the borrower has begun there has ended.
    """

    until: float
    for_one: bool = False


@dataclass(eq=False, slots=True)
class Lender:
    """The place of a session from which a part was taken for a time.

    Attributes:
        holder: the session.
        epochs: what comes back to it, and in which epoch each component was taken from it.
        named: those of them that it has named; without one the others do not come back either.
        loan: the terms on which it had the part itself; None where it was its own.
    """

    holder: object
    epochs: dict[str, int]
    named: tuple[str, ...]
    loan: Loan | None


class Loans:
    """The lenders of each part, in their order, and the loan of its holder. A part that is not lent has neither."""

    def __init__(self) -> None:
        self._lenders: dict[str, list[Lender]] = {}
        self._loans: dict[str, Loan] = {}

    def count(self) -> int:
        """Return how many parts are lent."""
        return len(self._loans)

    def of(self, part: str) -> Loan | None:
        """Return the loan of the part's holder; None where that holds it in its own right."""
        return self._loans.get(part)

    def lenders(self, part: str) -> tuple[Lender, ...]:
        """Return the lenders of a part; it comes back to the last one first."""
        return tuple(self._lenders.get(part, ()))

    def find(self, part: str, holder: object) -> Lender | None:
        """Return the place of a session among the lenders of a part."""
        return next((lender for lender in self.lenders(part) if lender.holder is holder), None)

    def all(self) -> list[tuple[str, Lender]]:
        """Return every place of a lender, and its part."""
        return [(part, lender) for part, lenders in self._lenders.items() for lender in lenders]

    def of_lender(self, holder: object) -> Iterator[tuple[str, Lender]]:
        """Yield the parts in which a session has a place as a lender."""
        yield from ((part, lender) for part, lender in self.all() if lender.holder is holder)

    def lend(self, part: str, lender: Lender, loan: Loan) -> None:
        """Note that a part was taken for a time from its holder."""
        self._lenders.setdefault(part, []).append(lender)
        self._loans[part] = loan

    def extend(self, part: str, loan: Loan) -> None:
        """Give the holder of a part other terms."""
        self._loans[part] = loan

    def remove(self, part: str, lender: Lender) -> None:
        """Remove the place of a lender; the loan of the holder lasts as long as before."""
        lenders = self._lenders[part]
        lenders.remove(lender)
        if not lenders:
            del self._lenders[part]

    def take_back(self, part: str) -> Lender | None:
        """End the loan of a part's holder, and return the lender that has it next, on its own terms."""
        self._loans.pop(part, None)
        lenders = self._lenders.get(part)
        if not lenders:
            return None
        lender = lenders[-1]
        self.remove(part, lender)
        if lender.loan is not None:
            self._loans[part] = lender.loan
        return lender

    def end_all_of(self, part: str) -> tuple[Lender, ...]:
        """End all that there is of loans of a part, and return those that had places."""
        self._loans.pop(part, None)
        return tuple(self._lenders.pop(part, ()))

    def give_up(self, lender: Lender, component_refs: Collection[str]) -> None:
        """Take components out of what comes back to a lender."""
        lender.named = tuple(ref for ref in lender.named if ref not in component_refs)
        left = lender.epochs if lender.named else {}
        lender.epochs = {ref: epoch for ref, epoch in left.items() if ref not in component_refs}

    def due(self, now: float) -> tuple[list[tuple[str, Lender]], list[str]]:
        """Return the lenders whose own loans are over, and the parts whose holders' are."""
        places = self.all()
        over = [(part, lender) for part, lender in places if lender.loan is not None and lender.loan.until <= now]
        return over, [part for part, loan in self._loans.items() if loan.until <= now]

    def deadlines(self) -> Iterator[float]:
        """Yield when something of it is due."""
        yield from (loan.until for loan in self._loans.values())
        yield from (lender.loan.until for _, lender in self.all() if lender.loan is not None)
