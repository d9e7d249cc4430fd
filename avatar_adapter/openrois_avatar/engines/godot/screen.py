"""A display of its own for a program that draws: Xvfb, which ends when this process does."""

import ctypes
import os
import secrets
import select
import signal
import struct
import subprocess
from collections.abc import Mapping
from typing import Final

__all__ = ["SERVER", "NoScreen", "virtual_screen"]

SERVER: Final = "Xvfb"
START_TIMEOUT: Final = 10.0
"""Seconds that the server has to say which display it is."""
_COOKIE: Final = b"MIT-MAGIC-COOKIE-1"
_FAMILY_WILD: Final = 0xFFFF
_PR_SET_PDEATHSIG: Final = 1


class NoScreen(Exception):
    """The server did not start; the text has what it said."""


def virtual_screen(width: int, height: int) -> Mapping[str, str]:
    """Start a display server for this process and whatever program takes its place (`os.exec*`).

    The server takes a number that nobody uses, listens on no network, and lets in only who has the key, which is in
    memory that the same program inherits; no file is left behind. The kernel ends it together with this process, so it
    has to be called from the main thread. Linux only.

    Returns:
        The variables with which a program finds the display.

    Raises:
        NoScreen: it did not start.
    """
    key = _memory("key", _authority())
    said = _memory("said")
    number, telling = os.pipe()
    parent = os.getpid()
    libc = ctypes.CDLL(None)

    def die_with_parent() -> None:  # there are no other threads, so code between fork and exec is safe
        libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != parent:
            os._exit(1)

    arguments = (f"-displayfd {telling} -auth /proc/self/fd/{key} -screen 0 {width}x{height}x24 -nolisten tcp").split()
    try:
        subprocess.Popen(  # noqa: S603 - a program of this machine
            [SERVER, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=said,
            pass_fds=(key, telling),
            preexec_fn=die_with_parent,
        )
    except OSError as error:
        raise NoScreen(f"{SERVER} cannot be started: {error}") from error
    finally:
        os.close(telling)
    readable, _, _ = select.select([number], [], [], START_TIMEOUT)
    display = os.read(number, 16).decode().strip() if readable else ""
    if not display:
        raise NoScreen(f"{SERVER} did not start: {_text(said)}")
    os.set_inheritable(key, True)
    return {"DISPLAY": f":{display}", "XAUTHORITY": f"/proc/self/fd/{key}"}


def _authority() -> bytes:
    """A key that opens every display, in the form of an Xauthority file."""
    parts = (b"", b"", _COOKIE, secrets.token_bytes(16))  # address, number, name, key
    return struct.pack(">H", _FAMILY_WILD) + b"".join(struct.pack(">H", len(part)) + part for part in parts)


def _memory(name: str, content: bytes = b"") -> int:
    """A file in memory, by its descriptor."""
    descriptor = os.memfd_create(name)
    os.write(descriptor, content)
    return descriptor


def _text(descriptor: int) -> str:
    return os.pread(descriptor, 1000, 0).decode(errors="replace").strip()
