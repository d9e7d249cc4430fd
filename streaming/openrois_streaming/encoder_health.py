"""Which codecs are not offered for a while, because their encoders fail again and again. Pure."""

from math import inf
from typing import Final

__all__ = ["AVOIDED_FOR", "GIVEN_UP_AFTER", "EncoderHealth"]

GIVEN_UP_AFTER: Final = 2.0
"""Seconds without a frame, with three failures, after which viewers get another codec if they can decode one."""

AVOIDED_FOR: Final = 60.0
"""Seconds for which a codec that was given up is not used; the next viewer after that tries it again."""


class EncoderHealth:
    """What is known of the encoders of one source, by codec. The caller says what fails and what time it is."""

    def __init__(self) -> None:
        self._failing_since: dict[str, float] = {}
        self._avoided_until: dict[str, float] = {}

    def is_usable(self, codec: str, *, is_failing: bool, now: float) -> bool:
        """Tell whether a viewer may be sent that codec.

        Args:
            codec: a media type.
            is_failing: whether all of its encoders that are wanted have failed and none has put out a frame since.
            now: in seconds; never less than before.
        """
        if not is_failing:
            self._failing_since.pop(codec, None)
        elif now - self._failing_since.setdefault(codec, now) >= GIVEN_UP_AFTER:
            self._avoided_until[codec] = now + AVOIDED_FOR
        return now >= self._avoided_until.get(codec, -inf)
