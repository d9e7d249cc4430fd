"""Decodability of the frames of a rendition after those that were sent before. Pure."""

from openrois_streaming.encoded import EncodedFrame

REPEAT_REQUEST = 1.0
"""Seconds of media after which a key frame is requested again if none has come."""


class ReferenceChain:
    """Chain of the frames of a rendition that can be decoded after those that were sent before.

    Pictures are predicted from earlier ones, so none is of use after a gap until the next key frame.
    """

    __slots__ = ("_asked", "_next", "_predicted")

    def __init__(self, kind: str) -> None:
        self._predicted = kind == "video"
        self._next: int | None = None
        self._asked: float | None = None

    def admits(self, frame: EncodedFrame) -> bool:
        """Tell whether `frame` can be decoded after the frames that were admitted before."""
        if self._predicted and not frame.keyframe and frame.sequence != self._next:
            self._next = None
            return False
        self._next = frame.sequence + 1
        self._asked = None
        return True

    def should_ask(self, frame: EncodedFrame) -> bool:
        """Tell whether to request a key frame after `frame` was not admitted: once, then every `REPEAT_REQUEST`."""
        due = self._asked is None or frame.captured_at - self._asked >= REPEAT_REQUEST
        if due:
            self._asked = frame.captured_at
        return due
