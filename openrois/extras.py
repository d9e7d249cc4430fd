"""Extras: the libraries that a plain installation leaves out, and what to say where one of them is missing."""

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from types import MappingProxyType
from typing import Final

__all__ = ["EXTRAS", "MissingExtra", "install_command", "missing_modules", "name_missing_extra", "needing_extra"]

_GATEWAY: Final = ("aiohttp", "cryptography", "jwt", "prometheus_client", "uvloop")
_STREAMING: Final = ("aioice", "aiortc", "av", "cv2", "ifaddr", "numpy", "pylibsrtp", "uvloop")
_BODY: Final = _STREAMING
_AVATAR: Final = (*_BODY, "aiohttp", "prometheus_client")

EXTRAS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "gateway": _GATEWAY,
        "cluster": (*_GATEWAY, "asyncpg", "nats"),
        "mcp": ("mcp", "mcp_types", "starlette", "uvicorn"),
        "streaming": _STREAMING,
        "livekit": (*_STREAMING, "livekit"),
        "pipecat": (*_STREAMING, "pipecat"),
        "body": _BODY,
        "avatar": _AVATAR,
        "speech": (*_BODY, "aiohttp", "espeakng_loader"),
        "hearing": (*_BODY, "aiohttp", "pocketsphinx"),
        "panda3d": (*_AVATAR, "panda3d"),
        "puppet": (*_AVATAR, "pygame"),
        "robot": (*_AVATAR, "panda3d"),
        "demo": (*_GATEWAY, *_AVATAR, "espeakng_loader", "panda3d", "pocketsphinx", "pygame"),
        "kachaka": (*_AVATAR, "grpc", "kachaka_api"),
        "reachy": (*_AVATAR, "espeakng_loader"),
        "ros2": (*_AVATAR, "cyclonedds"),
    }
)
"""The modules that each extra brings, as `import` names them. The first extra that has a module is the smallest."""

_OF_UNIX: Final = frozenset({"fcntl", "resource", "uvloop"})
"""Modules that no extra can bring to Windows."""


class MissingExtra(ModuleNotFoundError):
    """A library of an extra is not installed; the text names the command that installs it."""


def install_command(extra: str) -> str:
    """Return the command that installs an extra."""
    return f"pip install 'openrois[{extra}]'"


def missing_modules(extra: str) -> tuple[str, ...]:
    """Return the modules of an extra that are not installed, each once; none of them is imported."""
    return tuple(name for name in dict.fromkeys(EXTRAS[extra]) if find_spec(name) is None)


def name_missing_extra(error: ImportError, preferred: str = "") -> str | None:
    """Return what is not installed and the command that installs it, for an import that failed.

    Args:
        error: what the import has raised.
        preferred: an extra to name, where it brings the missing module; otherwise the smallest that does is named.

    Returns:
        One sentence; None where the import has failed for another reason, such as a shared library of the system.
    """
    if not isinstance(error, ModuleNotFoundError) or error.name is None:
        return None
    module = error.name.partition(".")[0]
    if module in _OF_UNIX and sys.platform == "win32":
        return "this runs on Linux and macOS; client, adapter and testing tools run on Windows too"
    having = [extra for extra in EXTRAS if module in EXTRAS[extra]]
    if not having or find_spec(module) is not None:
        return None
    extra = preferred if preferred in having else having[0]
    return f"{module} is not installed: run `{install_command(extra)}`"


@contextmanager
def needing_extra(extra: str) -> Iterator[None]:
    """Import modules of an extra in the block.

    Raises:
        MissingExtra: it is not installed. An import that fails for another reason raises what it has raised.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        sentence = name_missing_extra(error, extra)
        if sentence is None:
            raise
        raise MissingExtra(sentence, name=error.name) from None
