"""Values to try a component with: for each type one that fits it, and one that does not."""

from collections.abc import Mapping
from typing import Final

from openrois.types.messages import Argument, Result
from openrois.types.profiles import ParameterProfile

__all__ = ["argument", "misfit", "result", "sample"]

_FITTING: Final[Mapping[str, str]] = {
    **dict.fromkeys(("int", "integer", "long", "short"), "1"),
    **dict.fromkeys(("float", "double"), "0.5"),
    **dict.fromkeys(("bool", "boolean"), "true"),
    "component_status": "READY",
    "stream_status": "STREAMING_RUNNING",
    "datetime": "2026-06-01T12:00:00+00:00",
}


def sample(code: str) -> str:
    """Return a value that fits a `data_type_ref`."""
    lower = code.lower()
    return "[]" if lower.endswith("[]") else _FITTING.get(lower, "text")


def misfit(code: str) -> str | None:
    """Return a value that does not fit a `data_type_ref`, or None where every text does."""
    lower = code.lower()
    if lower.endswith("[]"):
        return "no list"
    # No number, no truth value, no status.
    return "maybe" if lower in _FITTING and lower not in ("stream_status", "datetime") else None


def argument(profile: ParameterProfile, value: str | None = None) -> Argument:
    """Return an argument for a profile, with a value that fits unless another is given."""
    code = profile.data_type_ref.code
    return Argument(name=profile.name, data_type_ref=code, value=sample(code) if value is None else value)


def result(profile: ParameterProfile) -> Result:
    """Return a result that fits a profile."""
    code = profile.data_type_ref.code
    return Result(name=profile.name, data_type_ref=code, value=sample(code))
