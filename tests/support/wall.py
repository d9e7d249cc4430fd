"""A wall clock that tests set: all code of the product in this process reads it instead."""

import gc
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FunctionType
from typing import Any, Final

__all__ = ["WallClock"]

_REAL: Final = time.time
_OURS: Final = ("openrois.", "openrois_")


class WallClock:
    """The real time with an offset.

    Attributes:
        ahead: seconds.
        read: how often it was read.
    """

    def __init__(self) -> None:
        self.ahead = 0.0
        self.read = 0

    def __call__(self) -> float:
        self.read += 1
        return _REAL() + self.ahead

    @contextmanager
    def everywhere(self) -> Iterator[None]:
        """Put it in the place of `time.time` while the block runs: where it is called, and where it is a default."""
        functions = _with_default()
        time.time = self
        for function in functions:
            _put(function, _REAL, self)
        try:
            yield
        finally:
            time.time = _REAL
            for function in functions:
                _put(function, self, _REAL)


def _with_default() -> list[FunctionType]:
    """Return the product's functions that have the wall clock as the default of an argument."""
    return [
        each
        for each in gc.get_objects()
        if type(each) is FunctionType  # `isinstance` asks a weak proxy, which may be of something that is gone
        and (each.__module__ or "").startswith(_OURS)
        and each.__module__ in sys.modules
        and _REAL in (*(each.__defaults__ or ()), *(each.__kwdefaults__ or {}).values())
    ]


def _put(function: FunctionType, former: Callable[[], float], clock: Callable[[], float]) -> None:
    def put(value: Any) -> Any:
        return clock if value is former else value

    if function.__defaults__ is not None:
        function.__defaults__ = tuple(put(value) for value in function.__defaults__)
    if function.__kwdefaults__ is not None:
        function.__kwdefaults__ = {name: put(value) for name, value in function.__kwdefaults__.items()}
