"""A virtual display for a program that draws: Xvfb, which ends when this process does."""

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
"""Seconds that the server has to report its display."""
_FIRST: Final = 1000
_NUMBERS: Final = 50_000
_TRIES: Final = 3
"""The range of display numbers, and the number of attempts."""
_COOKIE: Final = b"MIT-MAGIC-COOKIE-1"
_FAMILY_WILD: Final = 0xFFFF
_PR_SET_PDEATHSIG: Final = 1


class NoScreen(Exception):
    """The display server did not start; the text has its output."""


def virtual_screen(width: int, height: int) -> Mapping[str, str]:
    """Start a display server for this process and the program that replaces it (`os.exec*`).

    The server listens on no network and accepts only clients with its key, which is in memory that the program
    inherits; no file is left behind. The kernel ends it together with this process, so this has to be called from the
    main thread. Linux only.

    Returns:
        The environment variables of the display.

    Raises:
        NoScreen: the server did not start.
    """
    key, said = _memory("key", _authority()), _memory("said")
    for _ in range(_TRIES):
        # Not the first free number, as servers choose: its last owner may still be removing its socket.
        number = _FIRST + secrets.randbelow(_NUMBERS)
        if _starts(number, f"{width}x{height}x24", key, said):
            os.set_inheritable(key, True)
            return {"DISPLAY": f":{number}", "XAUTHORITY": f"/proc/self/fd/{key}"}
    raise NoScreen(f"{SERVER} did not start: {_last_line(said)}")


def _starts(number: int, screen: str, key: int, said: int) -> bool:
    """Start the server as this display, and return whether it is ready, or has ended."""
    ready, telling = os.pipe()
    parent, libc = os.getpid(), ctypes.CDLL(None)

    def die_with_parent() -> None:  # there are no other threads, so code between fork and exec is safe
        libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != parent:
            os._exit(1)

    options = f":{number} -displayfd {telling} -auth /proc/self/fd/{key} -screen 0 {screen} -nolisten tcp"
    try:
        server = subprocess.Popen(  # noqa: S603 - a program of this machine
            [SERVER, *options.split()],
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
    started = _line(ready) != b""
    os.close(ready)
    if not started:
        server.kill()
        server.wait()
    return started


def _line(pipe: int) -> bytes:
    """Read a line of a pipe: empty if it does not come in time."""
    line = b""
    while not line.endswith(b"\n"):
        readable, _, _ = select.select([pipe], [], [], START_TIMEOUT)
        data = os.read(pipe, 16) if readable else b""
        if not data:
            return b""
        line += data
    return line


def _authority() -> bytes:
    """Return a key for every display, in the form of an Xauthority file."""
    parts = (b"", b"", _COOKIE, secrets.token_bytes(16))  # address, number, name, key
    return struct.pack(">H", _FAMILY_WILD) + b"".join(struct.pack(">H", len(part)) + part for part in parts)


def _memory(name: str, content: bytes = b"") -> int:
    """Return the descriptor of a file in memory."""
    descriptor = os.memfd_create(name)
    os.write(descriptor, content)
    return descriptor


def _last_line(descriptor: int) -> str:
    lines = os.pread(descriptor, 10_000, 0).decode(errors="replace").split("\n")
    return next((line for line in reversed(lines) if line.strip()), "it printed nothing")
