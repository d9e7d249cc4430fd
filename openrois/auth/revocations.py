"""Revoked tokens and subjects, as a text of lines: `sub NAME` or `jti ID`. Pure."""

from dataclasses import dataclass
from typing import Final

from openrois.auth.principal import Principal

__all__ = ["NOTHING_REVOKED", "Revocations", "parse_revocations"]

MAX_REVOCATIONS: Final = 100_000
"""Lines that count."""


@dataclass(frozen=True, slots=True)
class Revocations:
    """The revoked subjects and tokens.

    Attributes:
        subjects: none of their tokens is accepted.
        token_ids: no token with one of these ids (`jti`) holds.
    """

    subjects: frozenset[str] = frozenset()
    token_ids: frozenset[str] = frozenset()

    def covers(self, principal: Principal) -> bool:
        """Tell whether the principal, or the token that made it one, is revoked."""
        return principal.subject in self.subjects or principal.token_id in self.token_ids


NOTHING_REVOKED: Final = Revocations()


def parse_revocations(text: str) -> Revocations:
    """Read a text of lines `sub NAME` and `jti ID`; empty lines and comments (`#`) are skipped.

    Raises:
        ValueError: a line says something else; the message tells which.
    """
    found: dict[str, set[str]] = {"sub": set(), "jti": set()}
    count = 0
    for number, line in enumerate(text.splitlines(), 1):
        kind, _, value = line.strip().partition(" ")
        if not kind or kind.startswith("#"):
            continue
        if kind not in found or not value.strip():
            raise ValueError(f"line {number} is neither `sub NAME` nor `jti ID`")
        count += 1
        if count > MAX_REVOCATIONS:
            raise ValueError(f"there are more than {MAX_REVOCATIONS} lines")
        found[kind].add(value.strip())
    return Revocations(frozenset(found["sub"]), frozenset(found["jti"]))
