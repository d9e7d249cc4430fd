"""A voice agent as a process of its own, which ends in time whatever the libraries in it do."""

import asyncio
import faulthandler
import os
import signal
import threading
from collections.abc import Coroutine
from functools import partial
from types import FrameType
from typing import Any, Final

__all__ = ["run_agent"]

_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)
_SAYS_WHERE: Final = 1.0
"""Seconds that the process has to say where it hangs, before the system ends it."""


def run_agent(work: Coroutine[Any, Any, None], *, within: float = 15.0) -> None:
    """Run an agent until it ends, or SIGINT or SIGTERM cancels it; the last call of a program.

    The process is over in time then, also where a task does not let itself be cancelled, a thread does not return, or
    a library waits or computes on in C: it writes to standard error where it hangs, and has exit status 1. A second
    signal ends it at once. Signals count also where the process was started with SIGINT ignored, as in the background
    of a script. While a library holds the interpreter, so that no thread of Python runs, only SIGQUIT or SIGKILL ends
    the process. A library that has signal handlers of its own, or adds some to the event loop, takes this away.

    Args:
        work: the agent; what it raises is raised here.
        within: seconds that the end of the process may take.
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    try:
        asyncio.run(_until_stopped(work, within))
    finally:
        # Threads, and what libraries do at the end of a process, may hang, too.
        _end_within(within)
        _let_signals_end_it()


async def _until_stopped(work: Coroutine[Any, Any, None], within: float) -> None:
    loop = asyncio.get_running_loop()
    running = asyncio.ensure_future(work)

    def stop(number: int, frame: FrameType | None) -> None:
        # This is no handler of the event loop, which may not come to run it.
        _end_within(within)
        _let_signals_end_it()
        loop.call_soon_threadsafe(running.cancel)

    _end_without_handlers(within)
    for name in _SIGNALS:
        signal.signal(name, stop)
    await asyncio.wait({running})
    if not running.cancelled():
        running.result()


def _end_without_handlers(within: float) -> None:
    """Let a thread end the process, too: while the main thread is in C no handler runs, and signals are only noted."""
    noted, note = os.pipe()
    os.set_blocking(note, False)
    signal.set_wakeup_fd(note, warn_on_full_buffer=False)
    # A process that is forked would note its signals here.
    os.register_at_fork(after_in_child=partial(signal.set_wakeup_fd, -1))
    threading.Thread(target=_end_when_noted, args=(noted, within), name="ends the agent", daemon=True).start()


def _end_when_noted(noted: int, within: float) -> None:
    is_ending = False
    while True:
        for number in os.read(noted, 64):
            if number in _SIGNALS:
                if is_ending:
                    # As a shell has it of a process that a signal has ended.
                    os._exit(128 + number)
                is_ending = True
                _end_within(within)


def _let_signals_end_it() -> None:
    for name in _SIGNALS:
        signal.signal(name, signal.SIG_DFL)


def _end_within(seconds: float) -> None:
    """End the process by force, unless it is over before; what was set first counts."""
    if signal.getitimer(signal.ITIMER_REAL)[0] == 0.0:
        # Neither needs the interpreter, which a library may hold.
        faulthandler.dump_traceback_later(seconds, exit=True)
        signal.setitimer(signal.ITIMER_REAL, seconds + _SAYS_WHERE)
