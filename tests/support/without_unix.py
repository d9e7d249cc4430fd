"""A pytest plugin that takes away what Unix has and Windows has not: `-p tests.support.without_unix`.

It is no Windows: paths, processes and the event loop are this machine's. What it shows is that nothing is imported or
called that would not be there.
"""

import asyncio
import signal
import socket
import sys
from typing import Any, Final, NoReturn

__all__ = ["ABSENT"]

ABSENT: Final = ("fcntl", "grp", "pwd", "resource", "syslog", "termios", "uvloop")
"""Modules that cannot be imported."""


def _socketpair(family: int = socket.AF_INET, kind: int = socket.SOCK_STREAM, proto: int = 0) -> Any:
    """Connect two sockets of the internet's family, as Python does where there are no others."""
    with socket.socket(family, kind, proto) as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        near = socket.socket(family, kind, proto)
        near.connect(listening.getsockname())
        far, _ = listening.accept()
        return near, far


def _no_signals(_loop: object, _signal: int, *_arguments: object) -> NoReturn:
    raise NotImplementedError


sys.modules.update(dict.fromkeys(ABSENT))  # type: ignore[arg-type]
for each in ("AF_UNIX", "SO_REUSEPORT"):
    delattr(socket, each)
for each in ("SIGHUP", "SIGKILL", "SIGUSR1"):
    delattr(signal, each)
setattr(socket, "socketpair", _socketpair)  # noqa: B010 - the types of the standard library know another one
for each in ("add_signal_handler", "remove_signal_handler"):
    setattr(asyncio.SelectorEventLoop, each, _no_signals)
