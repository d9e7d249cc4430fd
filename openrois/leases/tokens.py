"""Resume tokens: proof that a new session goes on where a lost one ended. Each is good once, for one subject. Pure."""

import secrets
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Final

__all__ = ["Redeemed", "ResumeTokens", "new_token"]

_SPENT: Final = 64
"""Used tokens of one line of sessions that are kept, to notice when one comes a second time."""

_TOKEN_BYTES: Final = 32


def new_token() -> str:
    """Return 256 random bits as text."""
    return secrets.token_urlsafe(_TOKEN_BYTES)


@dataclass(eq=False, slots=True)
class _Line:
    """Sessions of which each goes on where the one before ended."""

    holder: object
    subject: str
    valid: bytes | None = None
    spent: deque[bytes] = field(default_factory=deque)


@dataclass(frozen=True, slots=True)
class Redeemed:
    """The finding about a token that was shown.

    Attributes:
        holder: its session; None where it is unknown, or another subject's.
        replayed: it was used before: from now on none that its line has been given is good.
    """

    holder: object | None = None
    replayed: bool = False


class ResumeTokens:
    """The tokens of all sessions; only digests of them are kept.

    Args:
        mint: makes one.
    """

    def __init__(self, mint: Callable[[], str] = new_token) -> None:
        self._mint = mint
        self._lines: dict[object, _Line] = {}
        self._known: dict[bytes, _Line] = {}

    def issue(self, holder: object, subject: str) -> str:
        """Return a token for a session; the one that it had before counts as used."""
        line = self._lines.get(holder)
        if line is None:
            line = self._lines[holder] = _Line(holder, subject)
        self._spend(line)
        token = self._mint()
        line.subject, line.valid = subject, _digest(token)
        self._known[line.valid] = line
        return token

    def has_one(self, holder: object) -> bool:
        """Tell whether a session has a token that is good."""
        line = self._lines.get(holder)
        return line is not None and line.valid is not None

    def knows(self, holder: object) -> bool:
        """Tell whether a session has had a token, and has not left."""
        return holder in self._lines

    def find(self, token: str, subject: str) -> Redeemed:
        """Return whose token this is, and whether it comes a second time: then its line is over."""
        digest = _digest(token)
        line = self._known.get(digest)
        if line is None or line.subject != subject:
            return Redeemed()
        if line.valid == digest:
            return Redeemed(line.holder)
        self._spend(line)
        return Redeemed(line.holder, replayed=True)

    def succeed(self, former: object, successor: object) -> None:
        """Use up the token of a session, and let its line go on with another session."""
        line = self._lines.pop(former)
        self.forget_holder(successor)
        self._spend(line)
        line.holder = successor
        self._lines[successor] = line

    def forget_holder(self, holder: object) -> None:
        """Drop the line of a session: it cannot be resumed any more."""
        line = self._lines.pop(holder, None)
        if line is not None:
            self._spend(line)
            for digest in line.spent:
                del self._known[digest]

    def _spend(self, line: _Line) -> None:
        if line.valid is None:
            return
        line.spent.append(line.valid)
        line.valid = None
        if len(line.spent) > _SPENT:
            del self._known[line.spent.popleft()]


def _digest(token: str) -> bytes:
    return sha256(token.encode(errors="surrogatepass")).digest()
