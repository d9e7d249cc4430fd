"""The options of a mind: what answers, the wake word, the limits."""

import argparse
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from openrois_agents.mind.limits import Budget
from openrois_agents.mind.model.chat import ModelSettings
from openrois_agents.mind.model.options import (
    add_limit_options,
    add_model_options,
    budget_choice,
    model_arguments,
    model_choice,
)

__all__ = ["MindChoice", "add_mind_options", "mind_arguments", "mind_choice"]

_WAKE_WORD: Final = re.compile(r"[A-Za-z']{3,20}( [A-Za-z']{1,20}){0,2}")


@dataclass(frozen=True, slots=True)
class MindChoice:
    """A mind.

    Attributes:
        wake_word: in lower case; empty where there is none.
        model: None where rules answer.
        budget: of its conversations.
    """

    wake_word: str
    model: ModelSettings | None
    budget: Budget


def add_mind_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a mind."""
    parser.add_argument(
        "--wake-word",
        default="",
        metavar="WORD",
        help="with which a visitor addresses the mind; without it all that is heard is for it",
    )
    add_model_options(parser)
    add_limit_options(parser)


def mind_choice(chosen: argparse.Namespace) -> MindChoice:
    """Return the mind that the options describe.

    Raises:
        ValueError: they contradict each other; a sentence for a person.
    """
    word = str(chosen.wake_word)
    if word and not _WAKE_WORD.fullmatch(word):
        raise ValueError(f"--wake-word takes one to three English words, as computer, not {word[:40]!r}")
    return MindChoice(word.lower(), model_choice(chosen), budget_choice(chosen))


def mind_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """Return the options for another command line."""
    wake_word = ("--wake-word", chosen.wake_word) if chosen.wake_word else ()
    return (*wake_word, *model_arguments(chosen))
