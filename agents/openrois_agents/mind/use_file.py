"""The file in which what a day has used survives a restart of the process."""

import json
import logging
import math
from datetime import date
from pathlib import Path
from typing import Any, Final

from openrois_agents.mind.limits import Used

__all__ = ["UseFile"]

_log = logging.getLogger(__name__)

_MAX_FILE: Final = 4_096
_GREATEST: Final = 10**12


class UseFile:
    """A small file that is replaced at each change; where that fails, the day's use is in memory alone.

    Args:
        path: of the file; its folder is there.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._fails = False

    def read(self) -> Used | None:
        """Return what was used; None where there is no file yet, or it is no such file."""
        try:
            with self._path.open("rb") as file:
                return _read_used(file.read(_MAX_FILE))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            _log.warning("%s does not say what the day has used, which is counted from 0: %s", self._path, error)
            return None

    def write(self, used: Used) -> None:
        """Replace the file; a failure is logged once."""
        told = {"day": used.day.isoformat(), "turns": used.turns, "tokens": used.tokens, "sound": used.sound}
        written = self._path.with_name(f"{self._path.name}.new")
        try:
            written.write_text(json.dumps(told), encoding="utf-8")
            written.replace(self._path)
        except OSError as error:
            if not self._fails:
                _log.warning("what the day has used cannot be kept in %s: %s", self._path, error.strerror)
            self._fails = True
        else:
            self._fails = False


def _read_used(text: bytes) -> Used:
    """Read a file.

    Raises:
        ValueError: it is none.
    """
    told = json.loads(text)
    if not isinstance(told, dict):
        raise ValueError("it is no JSON object")
    day = date.fromisoformat(str(told.get("day")))
    return Used(day, int(_number(told, "turns")), int(_number(told, "tokens")), _number(told, "sound"))


def _number(told: dict[str, Any], name: str) -> float:
    value = told.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{name} is no number")
    if not 0 <= value <= _GREATEST:
        raise ValueError(f"{name} is no number of what was used")
    return float(value)
