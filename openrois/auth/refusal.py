"""Why a token or a connection is refused: for the audit and the log; who is refused learns nothing of it."""

from enum import StrEnum

__all__ = ["Refusal", "TokenRefused"]


class Refusal(StrEnum):
    """The classes of reasons."""

    MISSING = "missing"
    """No token came."""
    MALFORMED = "malformed"
    """It is no token: its size, its parts, its JSON, or it came twice."""
    HEADER = "header"
    """Its header asks for what nobody here does, such as `crit` or a key of its own."""
    ALGORITHM = "algorithm"
    """No key here is for its algorithm."""
    UNKNOWN_KEY = "unknown-key"
    """The key that it names is not known here."""
    KEYS_UNAVAILABLE = "keys-unavailable"
    """The issuer's keys cannot be had."""
    SIGNATURE = "signature"
    """It was not signed with that key."""
    CLAIM = "claim"
    """A claim is missing, or is not what it has to be."""
    EXPIRED = "expired"
    NOT_YET = "not-yet"
    """It was issued in the future, or is good only then."""
    LIFETIME = "lifetime"
    """It lasts longer than tokens may here."""
    ISSUER = "issuer"
    AUDIENCE = "audience"
    """It is for somebody else."""
    REVOKED = "revoked"
    SUBJECT = "subject"
    """A session is renewed by a token of the same subject only."""
    ROLE = "role"
    """It is good, but not for what was asked."""
    ORIGIN = "origin"
    """The page that asks is of another site."""
    HOST = "host"
    """The gateway was called by a name that is not its own."""
    IN_ADDRESS = "token-in-address"
    """A token stood in the address, where logs keep it."""


class TokenRefused(Exception):
    """A token is not good here.

    Attributes:
        reason: the class of the reason.
        subject: who the token was for, where it was genuine; else empty.
    """

    def __init__(self, reason: Refusal, subject: str = "") -> None:
        super().__init__(reason.value)
        self.reason = reason
        self.subject = subject
