"""Whether the parent has taken an engine in: it says so itself, and of one that does not the first questions do."""

from collections.abc import Callable
from typing import Final

__all__ = ["ATTACHED", "QUESTIONS_ALONE", "Attachment"]

ATTACHED: Final = "openrois.attached"
"""Notification of a parent: the engine's profile is acceptable, and applications find its components.

In the extensions of `openrois.hello` it says that this notification will come."""

QUESTIONS_ALONE: Final = 2.0
"""Seconds after which a parent that asked for the profile and says no hello is taken for one of the base wire."""


class Attachment:
    """One connection to a parent.

    Args:
        tell: told True when the engine has been taken in, and False when the connection ends after that.
    """

    def __init__(self, tell: Callable[[bool], None]) -> None:
        self._tell = tell
        self._is_attached = False
        self._is_greeted = False

    def greet(self, extensions: tuple[str, ...]) -> None:
        """Take a hello, whose extensions say whether `ATTACHED` will follow."""
        self._is_greeted = True
        if ATTACHED not in extensions:
            self.confirm()

    def confirm(self) -> None:
        """Note that the parent has taken the engine in."""
        if not self._is_attached:
            self._is_attached = True
            self._tell(True)

    def assume(self, *, was_asked: bool) -> None:
        """Judge a parent after `QUESTIONS_ALONE` seconds by whether it has asked anything."""
        if was_asked and not self._is_greeted:
            self.confirm()

    def end(self) -> None:
        """Note that the connection has ended."""
        if self._is_attached:
            self._is_attached = False
            self._tell(False)
