"""Looks at the sources of the avatar several times a second and reports what has failed, to whoever works with it."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from openrois_streaming.clock import MediaClock
from openrois_streaming.publish.publisher import Publishing
from openrois_streaming.source.supervision import LOOK_INTERVAL

from openrois.component.component import Component
from openrois_avatar.health import Health, Observed

__all__ = ["Supervised", "seen_of", "supervise"]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Supervised:
    """A source under supervision.

    Attributes:
        health: how it fares.
        observe: what is seen of it now.
        components: those that cannot do their work without it.
    """

    health: Health
    observe: Callable[[], Observed]
    components: Sequence[Component]

    def look(self, now: float) -> None:
        """Judge it, and report what is new."""
        missed = self.health.missed
        trouble = self.health.look(now, self.observe())
        if trouble is not None:
            _log.warning("%s", trouble.description)
            for component in self.components:
                component.report(trouble.error_type, trouble.description)
        elif missed and not self.health.missed:
            _log.info("%s is there again", self.health.what)


def seen_of(publisher: Publishing) -> Observed:
    """What is seen of a publisher: it gives frames only while somebody plays it."""
    wanted = publisher.running_encoders > 0
    return Observed(publisher.last_frame_at, publisher.frames, wanted, publisher.failure, unseen=not wanted)


async def supervise(sources: Sequence[Supervised], clock: MediaClock) -> None:
    """Look at `sources` until cancelled."""
    while True:
        now = clock.now()
        for source in sources:
            source.look(now)
        await clock.sleep_until(now + LOOK_INTERVAL)
