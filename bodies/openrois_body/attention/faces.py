"""How near the faces of visitors are whose pictures are not analysed: one picture now and then, of one after the other.

So the cost is that of one picture a second, however many visitors there are.
"""

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Final

from openrois_media.visitors.visitor import Visitor
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import RawVideo

from openrois.types.codes import Purpose
from openrois_body.vision.backends import FaceFinder
from openrois_body.vision.view import View

__all__ = ["INTERVAL", "FaceSizes", "face_share"]

INTERVAL: Final = 1.0
"""Seconds between two pictures that are looked at."""

_WITHIN: Final = 1.0
"""Seconds within which a picture has to come: it begins with a key frame that the sender is asked for."""

_ANALYSED: Final = 2.0
"""Seconds after an analysis during which another one counts as coming."""

_RECOGNITION: Final = frozenset({Purpose.RECOGNITION})

_log = logging.getLogger(__name__)


def face_share(finder: FaceFinder, picture: RawVideo) -> float:
    """Return the share of a picture that its largest face has; 0 without any. It blocks."""
    return max((face.box.width * face.box.height for face in finder.find(View(picture), ())), default=0.0)


class FaceSizes:
    """Sizes of the faces of visitors, as far as they consent to recognition.

    Args:
        finder: finds faces; it is not used by anything else.
        clock: paces the looks.
    """

    def __init__(self, finder: FaceFinder, clock: MediaClock) -> None:
        self._finder = finder
        self._clock = clock
        self._shares: dict[str, float] = {}
        self._analysed_at: dict[str, float] = {}
        self._last = ""

    def of(self, visitor_ref: str) -> float:
        """Return the share of the picture that a visitor's face had last; 0 for none, or an unknown one."""
        return self._shares.get(visitor_ref, 0.0)

    def note(self, visitor_ref: str, share: float) -> None:
        """Note what is known from an analysis, which makes a look superfluous."""
        self._shares[visitor_ref], self._analysed_at[visitor_ref] = share, self._clock.now()

    def are_analysed(self, visitor_ref: str) -> bool:
        """Tell whether a visitor's pictures are analysed anyway."""
        return self._clock.now() - self._analysed_at.get(visitor_ref, -_ANALYSED) < _ANALYSED

    def keep_only(self, visitor_refs: frozenset[str]) -> None:
        """Forget the faces of those who have left, or do not consent any more."""
        self._shares = {ref: share for ref, share in self._shares.items() if ref in visitor_refs}
        self._analysed_at = {ref: at for ref, at in self._analysed_at.items() if ref in visitor_refs}

    async def watch_visitors(self, visitors: Callable[[], tuple[Visitor, ...]]) -> None:
        """Look at one visitor after the other until cancelled.

        Args:
            visitors: returns those who are to be looked at now.
        """
        thread = ThreadPoolExecutor(1, "attention")
        try:
            while True:
                await self._clock.sleep_until(self._clock.now() + INTERVAL)
                if (visitor := self._next(visitors())) is not None:
                    await self._look_at(visitor, thread)
        finally:
            thread.shutdown(wait=False, cancel_futures=True)

    def _next(self, visitors: tuple[Visitor, ...]) -> Visitor | None:
        """Return whom to look at: who comes after the one before, in a circle."""
        refs = [each.visitor_ref for each in visitors]
        if not refs:
            return None
        place = refs.index(self._last) + 1 if self._last in refs else 0
        self._last = refs[place % len(refs)]
        return visitors[place % len(refs)]

    async def _look_at(self, visitor: Visitor, thread: ThreadPoolExecutor) -> None:
        try:
            async with asyncio.timeout(_WITHIN), visitor.source("video", _RECOGNITION).open() as pictures:
                picture: RawVideo = await anext(pictures)
            share = await asyncio.get_running_loop().run_in_executor(thread, face_share, self._finder, picture)
        except TimeoutError:
            share = 0.0
        except Exception as error:  # a finder may be third-party code: attention goes on without it
            _log.warning("attention: a face cannot be looked for: %r", error)
            return
        if visitor.consent.holds(_RECOGNITION):
            self._shares[visitor.visitor_ref] = share
