"""Notes that the parent has attached an engine: a parent notifies that, an older one shows it by its first requests."""

from collections.abc import Callable
from typing import Final

__all__ = ["ATTACHED", "QUESTIONS_ALONE", "Attachment"]

ATTACHED: Final = "openrois.attached"
"""Notification of a parent: the engine's profile is acceptable, and applications find its components.

In the extensions of `openrois.hello` it says that this notification will come."""

QUESTIONS_ALONE: Final = 2.0
"""Seconds after which a parent that asked for the profile and sends no hello is taken for one of the base wire."""


class Attachment:
    """One connection to a parent.

    Args:
        tell: called with True when the engine was attached, and with False when the connection ends after that.
    """

    def __init__(self, tell: Callable[[bool], None]) -> None:
        self._tell = tell
        self._is_attached = False
        self._is_greeted = False

    def greet(self, extensions: tuple[str, ...]) -> None:
        """Note the hello, whose extensions say whether `ATTACHED` will follow."""
        self._is_greeted = True
        if ATTACHED not in extensions:
            self.confirm()

    def confirm(self) -> None:
        """Note that the parent has attached the engine."""
        if not self._is_attached:
            self._is_attached = True
            self._tell(True)

    def assume(self, *, was_asked: bool) -> None:
        """Judge a parent after `QUESTIONS_ALONE` seconds by whether it has sent any request."""
        if was_asked and not self._is_greeted:
            self.confirm()

    def connection_ended(self) -> None:
        """Note that the connection has ended."""
        if self._is_attached:
            self._is_attached = False
            self._tell(False)
