"""One budget for what waits unread on all connections together, fair to each subject. Pure."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

__all__ = ["MAX_UNREAD", "UnreadAccount", "UnreadBudget"]

MAX_UNREAD: Final = 64 * 1024 * 1024
"""Characters that wait to be sent, on all connections."""


class UnreadAccount:
    """The characters that wait on one connection.

    Args:
        budget: what it counts against.
        subject: whose connection it is.
        cut: ends the connection; its account is empty then.
    """

    def __init__(self, budget: "UnreadBudget", subject: str, cut: Callable[[], None]) -> None:
        self._budget = budget
        self.subject = subject
        self.cut = cut
        self.text = 0
        self.is_open = True

    def add(self, text: int) -> None:
        """Add characters that wait from now on; where that is too much, the fullest connection is cut.

        It is the fullest one of the subject that takes most: a subject that has no more than its share of the budget is
        never that. This connection may be it, and `is_open` says so.
        """
        if self.is_open:
            self.text += text
            self._budget.add(self.subject, text)
            self._budget.keep_within()

    def remove(self, text: int) -> None:
        """Remove characters: they were sent, or dropped."""
        if self.is_open:
            self.text -= text
            self._budget.add(self.subject, -text)

    def close(self) -> None:
        """Remove everything of this connection."""
        self.remove(self.text)
        self.is_open = False


class UnreadBudget:
    """The characters that wait on all connections.

    Args:
        most: characters.

    Attributes:
        total: characters that wait now.
        cuts: how many connections were cut because it was used up.
    """

    def __init__(self, most: int = MAX_UNREAD) -> None:
        self.most = most
        self.total = 0
        self.cuts = 0
        self._of_subject: dict[str, int] = {}
        self._accounts: set[UnreadAccount] = set()

    @contextmanager
    def account(self, subject: str, cut: Callable[[], None]) -> Iterator[UnreadAccount]:
        """Count what waits on one connection while the block runs.

        Args:
            subject: whose connection it is; what is alone in having this name has a share of its own.
            cut: ends the connection.
        """
        account = UnreadAccount(self, subject, cut)
        self._accounts.add(account)
        try:
            yield account
        finally:
            self._accounts.discard(account)
            account.close()

    def add(self, subject: str, text: int) -> None:
        """Count so many characters more, or less, for a subject."""
        self.total += text
        self._of_subject[subject] = self._of_subject.get(subject, 0) + text
        if not self._of_subject[subject]:
            del self._of_subject[subject]

    def keep_within(self) -> None:
        """Cut connections until the rest fits."""
        while self.total > self.most:
            subject = max(self._of_subject, key=self._of_subject.__getitem__)
            fullest = max((each for each in self._accounts if each.subject == subject), key=lambda each: each.text)
            fullest.close()
            self.cuts += 1
            fullest.cut()
