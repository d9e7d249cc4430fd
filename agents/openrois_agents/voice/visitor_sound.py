"""The sound of the visitor whom a body attends to, as what listens to speech wants it."""

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Collection
from contextlib import AsyncExitStack, suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray
from openrois_media import Media, Visitor
from openrois_media.client.readers import Block, StreamReader
from openrois_media.client.stream import News
from openrois_streaming.source.downsample import DOWNSAMPLED_RATES, SPEECH_RATE, Downsampler

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois.client import Client, ComponentProxy, ConnectionLost, RoISError, RpcError, Subscription
from openrois.types.codes import Purpose
from openrois.types.references import engine_of, reference

__all__ = ["MAX_UNHEARD", "VisitorBlock", "VisitorSound"]

MAX_UNHEARD: Final = 50
"""Blocks of 20 ms that wait for a slow agent; the oldest makes room for the newest."""
_SILENCE: Final = 25
"""Blocks of silence behind a visitor's sound."""
_BLOCKS_PER_SECOND: Final = 50
_ASK_AGAIN: Final = 5.0
"""Seconds after which a body is asked again whom it attends to, where it tells nothing: an event may be lost."""
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class VisitorBlock:
    """A block of a visitor's sound, 20 ms long at most.

    Attributes:
        visitor_ref: the visitor; empty for silence.
        samples: int16 of the shape (n,).
    """

    visitor_ref: str
    samples: NDArray[np.int16]


class VisitorSound:
    """Sound of the visitor whom a body attends to: `async for block in sound`, inside its `async with` block.

    It changes to another visitor when the body does, and waits while that one does not consent, or there is none. Where
    the body attends to none it is the first that consents.
    When a visitor withdraws its consent, or is not attended to any more, what waits of its sound is dropped.
    Half a second of silence follows, so that what listens to speech does not join the words of two visitors.

    Args:
        client: an open client.
        media: of this client, open.
        body: its engine id, or any component of it, or its reference.
        purposes: all that the sound is used for, one at least; the visitor has to consent to each.
        rate: samples a second: 8000, 16000, 24000 or 48000.

    Attributes:
        heard_changed: told with the visitor_ref of the visitor that is heard from now on; empty for none.
    """

    def __init__(
        self,
        client: Client,
        media: Media,
        body: str | ComponentProxy,
        *,
        purposes: Collection[Purpose],
        rate: int = SPEECH_RATE,
    ) -> None:
        if rate not in DOWNSAMPLED_RATES:
            raise ValueError(
                f"sound of {rate!r} Hz is not possible: use one of {', '.join(map(str, DOWNSAMPLED_RATES))}"
            )
        self.rate = rate
        self.heard_changed: Listeners[str] = Listeners()
        text = body if isinstance(body, str) else body.component_ref
        self._engine_id = engine_of(text) or text
        self._client = client
        self._media = media
        self._purposes = frozenset(purposes)
        self._blocks: deque[VisitorBlock] = deque(maxlen=MAX_UNHEARD)
        self._heard = ""
        self._left = asyncio.Event()
        self._asks = asyncio.Event()
        self._asks.set()
        self._silence = VisitorBlock("", np.zeros(rate // _BLOCKS_PER_SECOND, np.int16))
        self._closed = False
        self._news = News()
        self._stack = AsyncExitStack()

    async def __aenter__(self) -> Self:
        """Begin to listen.

        Raises:
            ValueError: there is no purpose.
            Unsupported: the body tells no visitors apart.
            RoISError: the engine refuses.
        """
        async with AsyncExitStack() as stack:
            visitors = self._client.component(reference(self._engine_id, "visitors"))
            await self._media.visitors(self._engine_id, purposes=self._purposes)
            attended = await stack.enter_async_context(visitors.event("attended"))
            changes = await stack.enter_async_context(visitors.event("visitor_changed"))
            # They end first.
            tasks = await stack.enter_async_context(TaskScope())
            tasks.start(self._read_events(attended, self._handle_attended))
            tasks.start(self._read_events(changes, self._handle_change))
            tasks.start(self._listen_to_all())
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._closed = True
        self._news.notify()
        await self._stack.aclose()

    @property
    def heard(self) -> str:
        """The visitor_ref of the visitor that is heard now; empty for none."""
        return self._heard

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> VisitorBlock:
        await self._news.until(lambda: self._blocks or self._closed)
        if self._closed:
            raise StopAsyncIteration
        return self._blocks.popleft()

    async def _read_events(self, events: Subscription[Any], handle: Callable[[dict[str, Any]], None]) -> None:
        try:
            async for data in events:
                handle(data)
        except (ConnectionLost, RoISError, RpcError) as error:
            _log.info("%s tells of visitors no more: %s", self._engine_id, error)

    def _handle_attended(self, data: dict[str, Any]) -> None:
        if data["visitor_ref"] != self._heard:
            self._leave()
            self._asks.set()

    def _handle_change(self, data: dict[str, Any]) -> None:
        if data["visitor_ref"] == self._heard and not self._purposes <= set(data["consent"].split()):
            self._leave()
        # Another one may have consented now.
        self._asks.set()

    def _leave(self) -> None:
        """Hear the present visitor no more; what waits of it is dropped."""
        self._left.set()
        if self._heard:
            self._blocks.clear()
            self._blocks.extend([self._silence] * _SILENCE)
            self._news.notify()
            self._heard = ""
            self.heard_changed.notify_all("")

    async def _listen_to_all(self) -> None:
        while True:
            self._asks.clear()
            visitor = await self._choose()
            if visitor is not None:
                await self._listen(visitor)
            with suppress(TimeoutError):
                async with asyncio.timeout(_ASK_AGAIN):
                    await self._asks.wait()

    async def _choose(self) -> Visitor | None:
        """Return the visitor that is to be heard, if there is one that may be."""
        try:
            present = await self._media.visitors(self._engine_id, purposes=self._purposes)
        except (ConnectionLost, RoISError, RpcError, TimeoutError) as error:
            _log.info("%s does not tell its visitors: %s", self._engine_id, error)
            return None
        # A body attends to none that consents neither to `live` nor to `recognition`.
        for each in [each for each in present if each.is_attended] or present:
            if "microphone" in each.devices and self._purposes <= each.consent:
                return each
        return None

    async def _listen(self, visitor: Visitor) -> None:
        """Read the sound of a visitor, until it is left, or its stream is ended."""
        self._left.clear()
        try:
            async with visitor.microphone.blocks() as blocks, TaskScope() as tasks:
                self._heard = visitor.visitor_ref
                self.heard_changed.notify_all(self._heard)
                tasks.start(self._read(visitor.visitor_ref, blocks))
                tasks.start(self._watch(blocks))
                await self._left.wait()
        except (ConnectionLost, RoISError, RpcError, TimeoutError) as error:
            _log.info("%s is not heard: %s", visitor.visitor_ref, error)
        finally:
            self._leave()

    async def _read(self, visitor_ref: str, blocks: StreamReader[Block]) -> None:
        downsampler = Downsampler(self.rate)
        async for block in blocks:
            if self._left.is_set():
                return
            samples = downsampler.add(block.samples)
            if len(samples):
                self._blocks.append(VisitorBlock(visitor_ref, samples))
                self._news.notify()

    async def _watch(self, blocks: StreamReader[Block]) -> None:
        await blocks.disconnected()
        self._leave()
        self._asks.set()
