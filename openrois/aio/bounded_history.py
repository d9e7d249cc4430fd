"""Bounded memory of what an application may ask for later: so many entries, and so much text. Pure."""

from collections import OrderedDict
from collections.abc import Callable, Iterator
from typing import Final, Generic, TypeVar

from openrois.types.messages import Result

__all__ = ["MAX_TEXT", "RESULT_OVERHEAD", "BoundedHistory"]

MAX_TEXT: Final = 16 * 1024 * 1024
"""Characters of all entries together; messages are long enough to fill a memory with few entries."""

RESULT_OVERHEAD: Final = 256
"""Characters that a result counts as beside its text: very many very short ones fill a memory, too."""

Entry = TypeVar("Entry")


class BoundedHistory(Generic[Entry]):
    """Entries by id; of too many, or of too much text, the oldest are forgotten.

    Args:
        most: entries.
        most_text: characters in their keys and results.
    """

    def __init__(self, most: int, most_text: int = MAX_TEXT) -> None:
        self._most = most
        self._most_text = most_text
        self._entries: OrderedDict[str, tuple[Entry, int]] = OrderedDict()
        self._text = 0

    def __len__(self) -> int:
        return len(self._entries)

    def __contains__(self, key: str) -> bool:
        return key in self._entries

    def get(self, key: str) -> Entry | None:
        """Return an entry, or None where it is unknown or forgotten."""
        found = self._entries.get(key)
        return None if found is None else found[0]

    def put(self, key: str, entry: Entry, results: tuple[Result, ...]) -> None:
        """Remember an entry, which weighs as much as its key and `results`; one that is known is replaced."""
        text = len(key)
        for result in results:
            text += len(result.name) + len(result.data_type_ref) + len(result.value) + RESULT_OVERHEAD
        former = self._entries.get(key)
        self._text += text if former is None else text - former[1]
        self._entries[key] = entry, text
        while len(self._entries) > self._most or self._text > self._most_text:
            self._forget_oldest()

    def drop_oldest(self, is_over: Callable[[Entry], bool]) -> None:
        """Forget the oldest entries, up to the first that is not over."""
        while self._entries and is_over(next(iter(self._entries.values()))[0]):
            self._forget_oldest()

    def _forget_oldest(self) -> None:
        _, (_, text) = self._entries.popitem(last=False)
        self._text -= text

    def newest_first(self) -> Iterator[Entry]:
        """Yield the entries, the newest first."""
        for entry, _ in reversed(self._entries.values()):
            yield entry
