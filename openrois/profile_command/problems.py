"""What is wrong with a value that does not fit its model, in one sentence."""

from pydantic import ValidationError

__all__ = ["problem"]


def problem(error: ValidationError) -> str:
    """Return the first problem: its dotted path and what is wrong there."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    path = ".".join(str(part) for part in first["loc"])
    return f"{path}: {first['msg']}" if path else first["msg"]
