"""Which embedded game engine runs here."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Final

__all__ = ["NoGameEngine", "choose_game_engine"]

Available = Callable[[], tuple[bool, str]]


def _asking(name: str) -> Available:
    def ask() -> tuple[bool, str]:
        answer: tuple[bool, str] = import_module(f"openrois_avatar.engines.{name}").available()
        return answer

    return ask


_AVAILABLE: Final = {name: _asking(name) for name in ("panda3d", "puppet")}


class NoGameEngine(Exception):
    """None of the game engines that were asked for runs here; the text says what to install."""


def choose_game_engine(wanted: str, available: Mapping[str, Available] = _AVAILABLE) -> tuple[str, str]:
    """Return the name of the game engine to run, and a sentence for a person, empty where all is as wanted.

    Args:
        wanted: a name, or `auto` for the best that runs.
        available: tells of each engine, best first, whether it runs here, and if not what to install.

    Raises:
        NoGameEngine: the one that is wanted does not run here, or none does.
    """
    reasons: list[str] = []
    for name in available if wanted == "auto" else (wanted,):
        runs, reason = available[name]()
        if runs:
            return name, f"{reasons[0]} (until then the {name} is shown)" if reasons else ""
        reasons.append(reason)
    raise NoGameEngine("; ".join(reasons))
