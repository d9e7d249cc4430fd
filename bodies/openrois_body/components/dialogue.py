"""Dialogue: what a program that answers lets be said, and where it sends what it hears. A component of OpenRoIS."""

from typing import Annotated, Any

from pydantic import Field

from openrois.adapter import Component, event, parameter

__all__ = ["Dialogue"]

Destination = Annotated[str, Field(max_length=256, pattern=r"^(https?://[A-Za-z0-9.:\[\]_-]+)?$")]
Examples = Annotated[tuple[Annotated[str, Field(min_length=1, max_length=80)], ...], Field(max_length=20)]


class Dialogue(Component, authority="OpenRoIS", function="actuation", part="voice"):
    """Shows to every application how the one that holds the voice converses.

    An actuation, so that only the holder of the voice says it. It holds for that application alone: once the voice is
    released, lent or lost, all parameters have their defaults again.
    """

    sent_to: Destination = parameter(
        "", description="where the holder sends words that are heard, as https://host; empty: they stay"
    )
    can_be_said: Examples = parameter((), description="examples of what can be said, to be shown")
    wake_word: Annotated[str, Field(max_length=40)] = parameter(
        "", description="the word that begins each sentence to the body; empty: push to talk"
    )

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Announce what holds from now on."""
        self.changed(**{**self.parameters, **changes})
        return changes

    def holder_lost(self) -> None:
        """Forget what the application has said that held the voice."""
        if self.sent_to or self.can_be_said or self.wake_word:
            self.sent_to, self.can_be_said, self.wake_word = "", (), ""
            self.changed("", (), "")

    @event
    def changed(self, sent_to: str, can_be_said: tuple[str, ...], wake_word: str) -> None:
        """The holder of the voice has set other parameters, or there is none any more.

        Args:
            sent_to: as the parameter
            can_be_said: as the parameter
            wake_word: as the parameter
        """
