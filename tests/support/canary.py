"""Secrets of tests that must not leak: everything that a test run prints and logs is searched for them."""

import re
from collections.abc import Iterable
from typing import Final

__all__ = ["CANARY", "leak"]

CANARY: Final = "canary-secret"
"""Stands in every secret of the tests of tokens, relays and figures."""

_LEAKS: Final = {
    "a secret of the tests": re.compile(rf"(?i){CANARY}"),
    "a session description": re.compile(r"\ba=(?:ice-pwd|ice-ufrag|fingerprint):"),
    "a token": re.compile(r"\beyJ[A-Za-z0-9_-]{6,}\.eyJ[A-Za-z0-9_-]{6,}\."),
}


def leak(sections: Iterable[tuple[str, str]]) -> str:
    """Return a sentence on the first secret in named texts; empty where there is none."""
    for name, text in sections:
        for what, pattern in _LEAKS.items():
            if found := pattern.search(text):
                line = text[: found.start()].rpartition("\n")[2][-80:]
                return f"{what} stands in {name!r}, behind {line!r}"
    return ""
