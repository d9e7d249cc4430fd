"""What is wrong with a value that does not fit its model, in one sentence."""

from typing import Final

from pydantic import ValidationError

__all__ = ["problem"]

_MAX_PATH: Final = 120


def problem(error: ValidationError) -> str:
    """Return the first problem: its dotted path, of a long one the end, and what is wrong there."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    path = ".".join(str(part) for part in first["loc"])
    shown = path if len(path) <= _MAX_PATH else f"…{path[-_MAX_PATH:]}"
    return f"{shown}: {first['msg']}" if path else first["msg"]
