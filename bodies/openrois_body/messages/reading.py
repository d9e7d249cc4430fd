"""Reading the members of a message: each is checked, and a `LinkError` names a wrong one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

MAX_NAME: Final = 200
"""Longest name, version, secret, identifier or reaction, in characters."""
MAX_TEXT: Final = 4_000
"""Longest reason or log text, in characters."""
INT64: Final = 2**63 - 1


class LinkError(Exception):
    """The peer broke the engine link's protocol, refused this side, or is disconnected; the text says which."""


def text(body: Mapping[str, Any], name: str, limit: int) -> str:
    """Read a text of at most `limit` characters that can be written as UTF-8."""
    value = body.get(name)
    if not isinstance(value, str):
        raise LinkError(f"{name}: expected a string")
    if len(value) > limit:
        raise LinkError(f"{name}: longer than {limit} characters")
    if not value.isascii() and any("\ud800" <= letter <= "\udfff" for letter in value):
        raise LinkError(f"{name}: half of a surrogate pair")
    return value


def integer(body: Mapping[str, Any], name: str, low: int, high: int) -> int:
    """Read an integer from `low` to `high`."""
    value = body.get(name)
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise LinkError(f"{name}: expected an integer from {low} to {high}")
    return value


def real(value: Any, name: str, low: float, high: float) -> float:
    """Read a number from `low` to `high`."""
    if not isinstance(value, int | float) or isinstance(value, bool) or not low <= value <= high:
        raise LinkError(f"{name}: expected a number from {low:g} to {high:g}")
    return float(value)


def truth(body: Mapping[str, Any], name: str) -> bool:
    """Read true or false."""
    value = body.get(name)
    if not isinstance(value, bool):
        raise LinkError(f"{name}: expected true or false")
    return value


def mapping(body: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Read an object."""
    value = body.get(name)
    if not isinstance(value, dict):
        raise LinkError(f"{name}: expected an object")
    return value
