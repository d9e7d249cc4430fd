"""Avoidance of codecs whose encoders fail again and again. Pure."""

from dataclasses import dataclass
from math import inf
from typing import Final

__all__ = ["AVOIDED_FOR", "FAILURES", "GIVEN_UP_AFTER", "EncoderHealth"]

FAILURES: Final = 3
GIVEN_UP_AFTER: Final = 2.0
"""Failures, and seconds since the first of them, without a frame in between, after which viewers get another codec if
they can decode one."""

AVOIDED_FOR: Final = 60.0
"""Seconds for which a failing codec is not used; the next viewer after that tries it again."""


@dataclass(slots=True)
class _Failing:
    since: float
    last: Exception
    count: int = 1


class EncoderHealth:
    """Health of the encoders of one source, by codec. The caller gives failures and the time."""

    def __init__(self) -> None:
        self._failing: dict[str, _Failing] = {}
        self._avoided_until: dict[str, float] = {}

    def is_usable(self, codec: str, failure: Exception | None, now: float) -> bool:
        """Return whether a viewer may be sent that codec.

        Args:
            codec: a media type.
            failure: of one of its encoders, where no wanted encoder works; the same object for the same failure.
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
