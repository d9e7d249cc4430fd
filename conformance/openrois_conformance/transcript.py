"""Every frame of a conversation with a gateway, so that a verdict can show it."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

__all__ = ["Frame", "Transcript"]

_LONGEST: Final = 400


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame.

    Attributes:
        at: seconds since the check began.
        who: the name of the connection, such as `application 1`.
        outgoing: whether the suite sent it.
        text: what it held.
    """

    at: float
    who: str
    outgoing: bool
    text: str

    def __str__(self) -> str:
        text = self.text if len(self.text) <= _LONGEST else f"{self.text[:_LONGEST]}... ({len(self.text)} characters)"
        return f"{self.at * 1000:8.1f} ms  {self.who} {'->' if self.outgoing else '<-'} {text}"


@dataclass
class Transcript:
    """The frames of one check, in the order they were sent and received, without secrets."""

    clock: Callable[[], float] = time.monotonic
    frames: list[Frame] = field(default_factory=list)
    began: float = 0.0
    hidden: set[str] = field(default_factory=set)

    def begin(self) -> None:
        """Drop all frames and start the time again."""
        self.frames = []
        self.began = self.clock()

    def hide(self, secret: str) -> None:
        """Replace this text in every frame."""
        self.hidden.add(secret)

    def note(self, who: str, text: str, *, outgoing: bool) -> None:
        """Keep one frame."""
        for secret in self.hidden:
            text = text.replace(secret, "(hidden)")
        self.frames.append(Frame(self.clock() - self.began, who, outgoing, text))
