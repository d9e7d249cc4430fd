"""Quotas of unfinished commands: their number, and the bytes that are kept of them until they end. Pure."""

from collections.abc import Sequence
from typing import Final
from weakref import WeakValueDictionary

from openrois.errors import OutOfResources

__all__ = [
    "FIRST_OF_SUBJECT",
    "FIRST_TEXT_OF_SUBJECT",
    "LEFT_TO_OTHERS",
    "MAX_OF_SUBJECT",
    "MAX_TEXT_OF_SUBJECT",
    "MAX_UNFINISHED",
    "MAX_UNFINISHED_TEXT",
    "RESERVED",
    "RESERVED_TEXT",
    "STOP_TEXT",
    "AcceptedTogether",
    "Allowance",
    "CommandQuota",
]

MAX_UNFINISHED: Final = 16_384
"""Commands of all applications, those that are gone included: their commands run on, however long that takes."""

MAX_UNFINISHED_TEXT: Final = 64 * 1024 * 1024
"""Bytes that are kept of them: a command may wait for a day, and its arguments with it."""

MAX_OF_SUBJECT: Final = 3072
"""Commands of all applications of one subject: one that reconnects again and again leaves some to others."""

MAX_TEXT_OF_SUBJECT: Final = 12 * 1024 * 1024
"""Bytes that are kept of them."""

LEFT_TO_OTHERS: Final = 3
"""Times what one subject's commands take that stays free beside them and what is reserved: each subject has up to a
quarter of what the others leave. What ends others need not leave anything."""

RESERVED: Final = 4096
"""Commands that are kept for the first ones of each subject, however many others have filled the rest together."""

RESERVED_TEXT: Final = 16 * 1024 * 1024
"""Bytes that are kept for them."""

FIRST_OF_SUBJECT: Final = 8
"""Commands of a subject that count as its first ones, and may use what is reserved: enough for 512 subjects."""

FIRST_TEXT_OF_SUBJECT: Final = RESERVED_TEXT * FIRST_OF_SUBJECT // RESERVED
"""Bytes that may be kept of them."""

STOP_TEXT: Final = 16 * 1024
"""Bytes that may be kept beyond of each command that may be unfinished beyond: of a `stop`."""


class Allowance:
    """The unfinished commands of one owner, and how many it may have.

    Args:
        owner: its name, for the reason of a refusal.
        most: commands.
        most_text: bytes that are kept of them.
    """

    def __init__(self, owner: str, most: int, most_text: int) -> None:
        self.most = most
        self.most_text = most_text
        self.taken = 0
        self.text = 0
        self._owner = owner

    def check(self, count: int, text: int, beyond: int = 0) -> None:
        """Do nothing where so many more commands fit, or fit `beyond` so many.

        Raises:
            OutOfResources: they are too many, or too much would be kept of them.
        """
        if self.taken + count > self.most + beyond:
            raise OutOfResources(f"{self._owner} has at most {self.most} unfinished commands")
        if self.text + text > self.most_text + beyond * STOP_TEXT:
            raise OutOfResources(f"at most {self.most_text} bytes are kept of the unfinished commands of {self._owner}")


class AcceptedTogether:
    """Commands of one request: each counts until it ends, and what is kept of all of them until the last one has."""

    def __init__(self, count: int, text: int, allowances: Sequence[Allowance]) -> None:
        self._left = count
        self._text = text
        self._allowances = allowances
        for allowance in allowances:
            allowance.taken += count
            allowance.text += text

    def end_one(self) -> None:
        """Give back the share of one of them; called once for each."""
        self._left -= 1
        for allowance in self._allowances:
            allowance.taken -= 1
            if not self._left:
                allowance.text -= self._text


class CommandQuota(Allowance):
    """The unfinished commands of an engine, of all applications, and the share of each subject.

    Args:
        most: commands.
        most_text: bytes that are kept of them.
    """

    def __init__(self, most: int = MAX_UNFINISHED, most_text: int = MAX_UNFINISHED_TEXT) -> None:
        super().__init__("the engine", most, most_text)
        # The commands that count against a share are what keeps it.
        self._shares: WeakValueDictionary[str, Allowance] = WeakValueDictionary()

    def accept_commands(
        self, own: Allowance, count: int, text: int = 0, subject: str | None = None, beyond: int = 0
    ) -> AcceptedTogether:
        """Count commands that are accepted, all or none.

        Args:
            own: what their application may take.
            count: how many they are.
            text: bytes that are kept of them.
            subject: counts against its share; None for a client that may use all there is.
            beyond: how many more than usual may be unfinished: for what ends others.

        Raises:
            OutOfResources: they do not fit; the reason names the limit.
        """
        allowances = [own, self] if subject is None else [own, self._share(subject), self]
        for allowance in allowances:
            allowance.check(count, text, beyond)
        return AcceptedTogether(count, text, allowances)

    def _share(self, subject: str) -> Allowance:
        share = self._shares.get(subject)
        if share is None:
            share = self._shares[subject] = _Share(self)
        return share


class _Share(Allowance):
    """The unfinished commands of one subject."""

    def __init__(self, whole: Allowance) -> None:
        super().__init__("one subject", MAX_OF_SUBJECT, MAX_TEXT_OF_SUBJECT)
        self._whole = whole

    def check(self, count: int, text: int, beyond: int = 0) -> None:
        """Do nothing where so many more commands fit, and enough is left to others."""
        super().check(count, text, beyond)
        if self.taken + count <= FIRST_OF_SUBJECT and self.text + text <= FIRST_TEXT_OF_SUBJECT:
            return
        free = self._whole.most - RESERVED - self._whole.taken - count
        free_text = self._whole.most_text - RESERVED_TEXT - self._whole.text - text
        is_fair = LEFT_TO_OTHERS * (self.taken + count) <= free and LEFT_TO_OTHERS * (self.text + text) <= free_text
        if not is_fair and not beyond:
            raise OutOfResources("unfinished commands of others leave one subject a smaller share than usual")
