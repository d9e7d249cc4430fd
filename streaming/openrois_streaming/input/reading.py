"""Reading the members of an input message: what is wrong is an `InputError` that names it. Pure."""

from collections.abc import Mapping
from typing import Any

__all__ = ["InputError", "array", "integer", "number", "truth"]


class InputError(ValueError):
    """An input message is not what it should be. The text names the member that is wrong."""


def number(value: Any, name: str, low: float, high: float) -> float:
    """Take a value for a number from `low` to `high`; NaN is none."""
    if not isinstance(value, int | float) or isinstance(value, bool) or not low <= value <= high:
        raise InputError(f"{name}: expected a number from {low:g} to {high:g}")
    return float(value)


def integer(value: Any, name: str, low: int, high: int) -> int:
    """Take a value for an integer from `low` to `high`."""
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise InputError(f"{name}: expected an integer from {low} to {high}")
    return value


def truth(body: Mapping[str, Any], name: str) -> bool:
    """Read true or false."""
    value = body.get(name)
    if not isinstance(value, bool):
        raise InputError(f"{name}: expected true or false")
    return value


def array(value: Any, name: str, limit: int) -> list[Any]:
    """Take a value for an array of at most `limit` items."""
    if not isinstance(value, list) or len(value) > limit:
        raise InputError(f"{name}: expected an array of at most {limit} items")
    return value
