"""Gives a body's recogniser the grammar of what can be said, without the words that it does not know."""

import logging
import re
from collections.abc import Awaitable, Callable, Collection
from typing import Final

from openrois.client import BadParameter
from openrois_agents.mind.phrases import Phrases

__all__ = ["expect_phrases"]

_log = logging.getLogger(__name__)

_ATTEMPTS: Final = 8
"""Refusals, each of which names some words; then the grammar has no names at all."""
_WORD: Final = re.compile(r"[a-z']+")


async def expect_phrases(
    set_grammar: Callable[[str], Awaitable[object]], make: Callable[[Collection[str]], Phrases]
) -> Phrases:
    """Set a grammar, and return what can be said with it.

    Args:
        set_grammar: sets the parameter `grammar` of a body's SpeechRecognition.
        make: returns what can be said without some words.

    Raises:
        BadParameter: the recogniser refuses what has no names in it, such as the wake word.
    """
    unknown: frozenset[str] = frozenset()
    for _ in range(_ATTEMPTS):
        phrases = make(unknown)
        try:
            await set_grammar(phrases.grammar)
        except BadParameter as error:
            refused = phrases.names & set(_WORD.findall(str(error)))
            if not refused:
                break
            unknown |= refused
        else:
            return _without_some(phrases)
    phrases = make(unknown | phrases.names)
    await set_grammar(phrases.grammar)
    return _without_some(phrases)


def _without_some(phrases: Phrases) -> Phrases:
    """Say which names cannot be said, and return the phrases."""
    if phrases.left_out:
        _log.warning("the recogniser does not know how these are said: %s", ", ".join(phrases.left_out))
    return phrases
