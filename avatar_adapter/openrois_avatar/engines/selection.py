"""The choice of the embedded game engine."""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Final

__all__ = ["NoGameEngine", "choose_game_engine", "link_address"]

Available = Callable[[], tuple[bool, str]]


def _asking(name: str) -> Available:
    def ask() -> tuple[bool, str]:
        answer: tuple[bool, str] = import_module(f"openrois_avatar.engines.{name}").available()
        return answer

    return ask


_AVAILABLE: Final = {name: _asking(name) for name in ("panda3d", "puppet", "godot")}
_AUTOMATIC: Final = ("panda3d", "puppet")
"""The engines for `auto`, best first."""
_TCP_ONLY: Final = ("godot",)
"""Engines that cannot open a Unix socket."""


class NoGameEngine(Exception):
    """The wanted game engine, or none, runs here; the text says what to install."""


def choose_game_engine(
    wanted: str, available: Mapping[str, Available] = _AVAILABLE, automatic: Sequence[str] = _AUTOMATIC
) -> tuple[str, str]:
    """Return the name of the game engine to run, and a warning for a person, or an empty text.

    Args:
        wanted: a name, or `auto` for the best that runs.
        available: returns for each engine whether it runs here, and if not what to install.
        automatic: the names that `auto` chooses from, best first.

    Raises:
        NoGameEngine: the wanted engine does not run here, or none does.
    """
    reasons: list[str] = []
    for name in automatic if wanted == "auto" else (wanted,):
        runs, reason = available[name]()
        if runs:
            return name, f"{reasons[0]} (until then the {name} is shown)" if reasons else ""
        reasons.append(reason)
    raise NoGameEngine("; ".join(reasons))


def link_address(name: str) -> str | None:
    """Return the link's address for this engine: None for a private Unix socket, else a free port of this machine."""
    return "tcp:127.0.0.1:0" if name in _TCP_ONLY else None
