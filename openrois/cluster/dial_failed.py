"""The failure to reach another gateway. Pure."""

from typing import Final

__all__ = ["LOST", "DialFailed"]

LOST: Final = 1006
"""The code of a stream that was lost, or was never there."""


class DialFailed(Exception):
    """There is no stream to another gateway; the text is a sentence.

    Attributes:
        code: with which that gateway refused it (RFC 6455, 7.4); 1006 where it was not reached.
        reason: its words, or those of this gateway.
    """

    def __init__(self, gateway_id: str, code: int, reason: str) -> None:
        way = "is not reached" if code == LOST else f"refuses with {code}"
        super().__init__(f"gateway {gateway_id!r} {way}: {reason or 'it does not say why'}")
        self.code = code
        self.reason = reason
