"""Credit for the sound of one speech: how many samples may be sent before more of them have been played. Pure."""

from typing import Final

from openrois_streaming.input.messages import InputError

__all__ = ["AHEAD", "STEP", "CreditReceiver", "CreditSender"]

AHEAD: Final = 1.0
"""Seconds of sound that may be sent before any credit has come, and be ahead of what is played."""
STEP: Final = 0.1
"""Seconds of sound by which credit has to grow before it is told."""


class CreditReceiver:
    """Credit at the body's end.

    Args:
        rate: samples a second.
    """

    def __init__(self, rate: int) -> None:
        self.received = 0
        """Samples that have come."""
        self.granted = round(AHEAD * rate)
        """Samples that may come in all, as the application was told."""
        self._ahead = self.granted
        self._step = round(STEP * rate)

    def receive(self, samples: int) -> None:
        """Count samples that have come.

        Raises:
            InputError: they are more than were granted; they do not count.
        """
        if self.received + samples > self.granted:
            raise InputError(
                f"{self.received + samples} samples were sent where {self.granted} were granted: wait for credit"
            )
        self.received += samples

    def grant(self, played: int) -> int | None:
        """Return the samples to be granted in all when so many have been played; None if that is not worth telling."""
        granted = played + self._ahead
        if granted - self.granted < self._step:
            return None
        self.granted = granted
        return granted


class CreditSender:
    """Credit at the application's end.

    Args:
        rate: samples a second.
    """

    def __init__(self, rate: int) -> None:
        self.sent = 0
        """Samples that were sent."""
        self.played = 0
        """Samples that have been played, as far as was told."""
        self._granted = round(AHEAD * rate)

    @property
    def room(self) -> int:
        """Samples that may be sent now."""
        return self._granted - self.sent

    def send(self, samples: int) -> None:
        """Count samples that are sent; there must be room for them."""
        assert samples <= self.room, "what is sent was granted"
        self.sent += samples

    def granted(self, samples: int, played: int) -> None:
        """Note credit that has come."""
        self._granted = max(self._granted, samples)
        self.played = max(self.played, played)
