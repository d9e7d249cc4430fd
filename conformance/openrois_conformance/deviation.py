"""Deviation of a gateway from a requirement."""

import json
from typing import Any, Final

__all__ = ["Deviation", "expect", "shown"]

_LONGEST: Final = 240


class Deviation(Exception):
    """The gateway did something else than is required.

    Attributes:
        expected: what it should have done.
        came: what it did.
    """

    def __init__(self, expected: str, came: str) -> None:
        super().__init__(f"expected {expected}; came {came}")
        self.expected = expected
        self.came = came


def shown(value: Any) -> str:
    """Return a JSON value as short text."""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False, default=_plain)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}... ({len(text)} characters)"


def _plain(value: Any) -> Any:
    return sorted(value) if isinstance(value, set | frozenset) else str(value)


def expect(what: str, came: Any, *wanted: Any) -> None:
    """Raise `Deviation` unless the value is one of the wanted ones, of the same type.

    Args:
        what: the name of the value, such as `the return_code of bind`.
        came: what it is.
        wanted: what it may be.
    """
    if not any(came == value and type(came) is type(value) for value in wanted):
        raise Deviation(f"{what} to be {' or '.join(shown(value) for value in wanted)}", shown(came))
