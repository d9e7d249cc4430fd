"""Words of visitors that a conversation itself heeds: the wake word, "stop", and goodbye. Pure."""

import re
from dataclasses import dataclass
from typing import Final

from openrois_agents.mind.requests import POLITE_AFTER, POLITE_BEFORE, REQUESTS

__all__ = ["Words", "is_addressed", "is_goodbye", "is_stop"]

_WORD: Final = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)*")


def _sentences(intent: str) -> frozenset[str]:
    return frozenset(sentence for each in REQUESTS if each.intent == intent for sentence in each.sentences)


_STOP: Final = _sentences("stop") | {"halt", "stop stop", "stop stop stop"}
_GOODBYE: Final = _sentences("leave") | {"bye", "good bye"}


@dataclass(frozen=True, slots=True)
class Words:
    """What a body has heard.

    Attributes:
        text: what was understood; untrusted. Empty: words that are none of those that can be understood.
        final: whether it stays so.
        visitor: the visitor's reference; empty where visitors are not told apart.
        body: the body that heard it.
    """

    text: str
    final: bool
    visitor: str
    body: str


def is_addressed(text: str, wake_word: str) -> bool:
    """Tell whether a text has words, and the wake word in front of them where there is one."""
    said, wake = _plain(text), _plain(wake_word)
    return bool(said) and said[: len(wake)] == wake


def is_stop(text: str, wake_word: str) -> bool:
    """Tell whether a text asks to stop, with the wake word or without it: to stop is never wrong."""
    return _bare(text, wake_word) in _STOP


def is_goodbye(text: str, wake_word: str) -> bool:
    """Tell whether a text is a goodbye."""
    return _bare(text, wake_word) in _GOODBYE


def _bare(text: str, wake_word: str) -> str:
    """Return a text without the wake word and words of politeness."""
    said, wake = _plain(text), _plain(wake_word)
    if said[: len(wake)] == wake:
        said = said[len(wake) :]
    bare = " ".join(said)
    for each in POLITE_BEFORE:
        bare = bare.removeprefix(f"{each} ")
    for each in POLITE_AFTER:
        bare = bare.removesuffix(f" {each}")
    return bare


def _plain(text: str) -> list[str]:
    return _WORD.findall(text.lower().replace("\u2019", "'"))
