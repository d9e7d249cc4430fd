"""Reasons of refused tokens and connections: for the audit trail and the log, never for the client. Pure."""

from enum import StrEnum

__all__ = ["Refusal", "TokenRefused"]


class Refusal(StrEnum):
    """The classes of reasons."""

    MISSING = "missing"
    """No token came."""
    MALFORMED = "malformed"
    """It is no token: its size, its parts, its JSON, or it came twice."""
    HEADER = "header"
    """Its header asks for what is not supported here, such as `crit` or a key of its own."""
    ALGORITHM = "algorithm"
    """No key here is for its algorithm."""
    UNKNOWN_KEY = "unknown-key"
    """The key that it names is not known here."""
    KEYS_UNAVAILABLE = "keys-unavailable"
    """The issuer's keys cannot be fetched."""
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
    """Its audience is another one."""
    REVOKED = "revoked"
    SUBJECT = "subject"
    """A session is renewed by a token of the same subject only."""
    RANK = "rank"
    """Its rank is none of those that the gateway knows."""
    ROLE = "role"
    """It is good, but not for what was asked."""
    ORIGIN = "origin"
    """The page that asks is of another site."""
    HOST = "host"
    """The gateway was called by a name that is not its own."""
    IN_ADDRESS = "token-in-address"
    """A token was part of the URL, where logs keep it."""


class TokenRefused(Exception):
    """A token was refused.

    Attributes:
        reason: the class of the reason.
        subject: the token's subject, where it was genuine; else empty.
    """

    def __init__(self, reason: Refusal, subject: str = "") -> None:
        super().__init__(reason.value)
        self.reason = reason
        self.subject = subject
