"""Values: text in every Result, Parameter and Argument, read by the `data_type_ref` of the profile."""

import json
import math
import re
from contextlib import suppress
from datetime import UTC, datetime
from typing import Any, Final

from openrois.types.codes import ComponentStatus, StreamStatus

__all__ = ["check_value", "date_time", "decode_value", "encode_value", "read_date_time"]

MAX_DIGITS: Final = 20
"""Digits of an integer."""

MAX_DEPTH: Final = 8
"""How deep lists may be nested."""

_INTEGER: Final = re.compile(rf"-?[0-9]{{1,{MAX_DIGITS}}}", re.ASCII)
_NUMBER: Final = re.compile(r"-?[0-9]{1,40}(\.[0-9]{1,40})?([eE][+-]?[0-9]{1,4})?", re.ASCII)
_INTEGERS: Final = {"int", "integer", "long", "short"}
_NUMBERS: Final = {"float", "double"}
_TRUTHS: Final = {"bool", "boolean"}
_INTEGER_LIMIT: Final = 10**MAX_DIGITS
_DATE_TIME: Final = re.compile(r"[0-9W-]{7,10}[T ][0-9:.,]{2,20}(Z|[+-][0-9:.]{2,15})?", re.ASCII)


def check_value(data_type_ref: str, value: str) -> None:
    """Refuse a value that does not fit its type.

    Args:
        data_type_ref: the type's code, in any case: `int`, `double`, `boolean`, `Component_Status`, `T[]`; whatever
            else it names is text and fits.
        value: the text on the wire; of a `T[]` a JSON array.

    Raises:
        ValueError: it does not fit; the message says what was expected.
    """
    code = data_type_ref.lower()
    if code.endswith("[]"):
        _check_list(code, value)
    elif not _fits_scalar(code, value):
        raise ValueError(f"{value[:80]!r} is not of type {data_type_ref}")


def _fits_scalar(code: str, value: str) -> bool:
    if code in _INTEGERS:
        return _INTEGER.fullmatch(value) is not None
    if code in _NUMBERS:
        return _NUMBER.fullmatch(value) is not None and math.isfinite(float(value))
    if code in _TRUTHS:
        return value in ("true", "false")
    if code == "component_status":
        return value in ComponentStatus.__members__
    return True


def _check_list(code: str, value: str) -> None:
    try:
        parsed = json.loads(value)
    except (ValueError, RecursionError):
        raise ValueError(f"{value[:80]!r} is not a JSON array") from None
    _check_items(code, parsed, 0)


def _check_items(code: str, parsed: Any, depth: int) -> None:
    if not isinstance(parsed, list) or depth >= MAX_DEPTH:
        raise ValueError(f"a value of type {code} is a JSON array, nested at most {MAX_DEPTH} deep")
    item_code = code.removesuffix("[]")
    for item in parsed:
        if item_code.endswith("[]"):
            _check_items(item_code, item, depth + 1)
        elif not _fits_item(item_code, item):
            raise ValueError(f"an item of the array is not of type {item_code}")


def _fits_item(code: str, item: Any) -> bool:
    if code in _TRUTHS:
        return isinstance(item, bool)
    if isinstance(item, bool):
        return False
    if code in _INTEGERS:
        return isinstance(item, int) and abs(item) < _INTEGER_LIMIT
    if code in _NUMBERS:
        return (isinstance(item, float) and math.isfinite(item)) or _fits_item("int", item)
    return isinstance(item, str) and _fits_scalar(code, item)


def date_time(epoch_seconds: float) -> str:
    """Write a DateTime value: ISO 8601, UTC, microseconds."""
    return datetime.fromtimestamp(epoch_seconds, UTC).isoformat(timespec="microseconds")


def read_date_time(text: str) -> datetime:
    """Read a DateTime value; one without an offset says nothing of its time zone.

    Raises:
        ValueError: it is not a date and a time of ISO 8601.
    """
    # `fromisoformat` takes more: a date alone as midnight, any character between date and time, any number of digits.
    if _DATE_TIME.fullmatch(text):
        with suppress(ValueError):
            return datetime.fromisoformat(text)
    raise ValueError(f"{text[:80]!r} is no date and time of ISO 8601, such as 2026-06-01T12:00:00+00:00")


def encode_value(data_type_ref: str, value: Any) -> str:
    """Write a Python value as the text of its type.

    Args:
        data_type_ref: the type's code, in any case.
        value: text, number, truth value, enumerator or datetime, or a sequence of them for a `T[]`.

    Raises:
        ValueError: it does not fit the type: it is of another one, no finite number, too large, or no enumerator.
    """
    code, plain = data_type_ref.lower(), _plain(value)
    if code.endswith("[]"):
        _check_items(code, plain, 0)
        return json.dumps(plain, ensure_ascii=False)
    if not _fits_item(code, plain) or not _is_enumerator(code, plain):
        raise ValueError(f"{_shown(value)} is not of type {data_type_ref}")
    return plain if isinstance(plain, str) else json.dumps(plain)


def _plain(value: Any) -> Any:
    if isinstance(value, str):
        return str(value)
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value


def _shown(value: Any) -> str:
    if isinstance(value, int) and abs(value) >= _INTEGER_LIMIT:
        return f"a number of {value.bit_length()} bits"
    return repr(str(value)[:80])


def _is_enumerator(code: str, plain: Any) -> bool:
    """Tell whether we may say it: of a Stream_Status the wire takes any text, but we send what there is."""
    return code != "stream_status" or plain in StreamStatus.__members__


def decode_value(data_type_ref: str, text: str) -> Any:
    """Read the text of a value: what comes back is text, a number, a truth value, or a list of them.

    Raises:
        ValueError: it does not fit its type.
    """
    check_value(data_type_ref, text)
    code = data_type_ref.lower()
    if code.endswith("[]"):
        return json.loads(text)
    if code in _INTEGERS:
        return int(text)
    if code in _NUMBERS:
        return float(text)
    return text == "true" if code in _TRUTHS else text
