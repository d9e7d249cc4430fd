"""Work counted in lines of code that are run: it says how time grows with the input, on any machine."""

import sys
from collections.abc import Callable
from types import FrameType, ModuleType

__all__ = ["lines_run"]


def lines_run(function: Callable[[], object], *modules: ModuleType) -> int:
    """Return how many lines of `modules` a call of `function` runs."""
    files = {module.__file__ for module in modules}
    count = 0

    def trace(frame: FrameType, event: str, _argument: object) -> object:
        nonlocal count
        if frame.f_code.co_filename not in files:
            return None
        count += event == "line"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)  # type: ignore[arg-type]
    try:
        function()
    finally:
        sys.settrace(before)
    return count
