"""Which frames of a rendition can be decoded after what was sent before. Pure."""

from openrois_streaming.encoded import EncodedFrame

REPEAT_REQUEST = 1.0
"""Seconds of media after which a key frame is asked for again when none has come."""


class ReferenceChain:
    """Which frames of a rendition can be decoded after what was sent before.

    Pictures are predicted from the ones before them, so nothing is of use after a gap until the next key frame.
    """

    __slots__ = ("_asked", "_next", "_predicted")

    def __init__(self, kind: str) -> None:
        self._predicted = kind == "video"
        self._next: int | None = None
        self._asked: float | None = None

    def admits(self, frame: EncodedFrame) -> bool:
        """Whether `frame` can be decoded by somebody who decoded what was admitted before."""
        if self._predicted and not frame.keyframe and frame.sequence != self._next:
            self._next = None
            return False
        self._next = frame.sequence + 1
        self._asked = None
        return True

    def should_ask(self, frame: EncodedFrame) -> bool:
        """After `frame` was not admitted: whether to ask for a key frame now. Once, and then once in a while."""
        due = self._asked is None or frame.captured_at - self._asked >= REPEAT_REQUEST
        if due:
            self._asked = frame.captured_at
        return due
