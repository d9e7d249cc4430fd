"""Supervision of an adapter's sources: reports failures to the components that depend on them."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from openrois_streaming.clock import MediaClock
from openrois_streaming.publish.publisher import Publishing
from openrois_streaming.source.supervision import CHECK_INTERVAL

from openrois.component.component import Component
from openrois_media.health import Health, Observed

__all__ = ["Supervised", "seen_of", "supervise"]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Supervised:
    """Source under supervision.

    Attributes:
        health: judges the source.
        observe: returns an observation of it.
        components: components that depend on it.
    """

    health: Health
    observe: Callable[[], Observed]
    components: Sequence[Component]

    def check_source(self, now: float) -> None:
        """Judge the source, and report a new fault."""
        missed = self.health.missed
        trouble = self.health.judge(now, self.observe())
        if trouble is not None:
            _log.warning("%s", trouble.description)
            for component in self.components:
                component.report(trouble.error_type, trouble.description)
        elif missed and not self.health.missed:
            _log.info("%s has recovered", self.health.what)


def seen_of(publisher: Publishing) -> Observed:
    """Return an observation of a publisher, which gives frames only while a viewer plays it."""
    wanted = publisher.running_encoders > 0
    return Observed(publisher.last_frame_at, publisher.frames, wanted, publisher.failure, unseen=not wanted)


async def supervise(sources: Sequence[Supervised], clock: MediaClock) -> None:
    """Check `sources` until cancelled."""
    while True:
        now = clock.now()
        for source in sources:
            source.check_source(now)
        await clock.sleep_until(now + CHECK_INTERVAL)
