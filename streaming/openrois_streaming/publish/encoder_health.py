"""Which codecs are not used for a while, because their encoders fail again and again. Pure."""

from dataclasses import dataclass
from math import inf
from typing import Final

__all__ = ["AVOIDED_FOR", "FAILURES", "GIVEN_UP_AFTER", "EncoderHealth"]

FAILURES: Final = 3
GIVEN_UP_AFTER: Final = 2.0
"""Failures, and seconds since the first of them, without a frame in between, after which viewers get another codec if
they can decode one."""

AVOIDED_FOR: Final = 60.0
"""Seconds for which a codec that was given up is not used; the next viewer after that tries it again."""


@dataclass(slots=True)
class _Failing:
    since: float
    last: Exception
    count: int = 1


class EncoderHealth:
    """What is known of the encoders of one source, by codec. The caller says what failed and what time it is."""

    def __init__(self) -> None:
        self._failing: dict[str, _Failing] = {}
        self._avoided_until: dict[str, float] = {}

    def is_usable(self, codec: str, failure: Exception | None, now: float) -> bool:
        """Tell whether a viewer may be sent that codec.

        Args:
            codec: a media type.
            failure: of one of its encoders, where none that is wanted works; the same object as long as it is the same
                failure.
            now: in seconds; never less than before.
        """
        if failure is None:
            self._failing.pop(codec, None)
        else:
            failing = self._failing.setdefault(codec, _Failing(now, failure))
            if failure is not failing.last:
                failing.last, failing.count = failure, failing.count + 1
            if failing.count >= FAILURES and now - failing.since >= GIVEN_UP_AFTER:
                self._avoided_until[codec] = now + AVOIDED_FOR
        return now >= self._avoided_until.get(codec, -inf)
