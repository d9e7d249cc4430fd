"""The engine that is connected to a link server: its sources, commands to it, and the detection of hangs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack
from types import TracebackType
from typing import Self

from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import RawAudio
from openrois_streaming.source.supervision import CHECK_INTERVAL, HUNG, SourceWatch

from openrois_avatar.link.encoded_source import EngineEncoded
from openrois_avatar.link.messages import Command, Event, Hello, Idle, LinkError, Pause
from openrois_avatar.link.picture_source import EngineVideo
from openrois_avatar.link.receivers import notify
from openrois_avatar.link.server import LinkServer


class LinkedEngine(ABC):
    """A game engine that may disconnect and reconnect while its sources go on."""

    _server: LinkServer  # set on entering

    def __init__(
        self,
        address: str | None,
        secret: str | None,
        *,
        on_audio: Callable[[RawAudio], None] | None,
        on_event: Callable[[Event], None] | None,
        on_hello: Callable[[Hello], None] | None = None,
        on_gone: Callable[[str], None] | None = None,
        clock: MediaClock,
    ) -> None:
        self._clock = clock
        self._on_event = on_event
        self._on_hello = on_hello
        self._stack = AsyncExitStack()
        """The contexts that the subclass has entered."""
        self._still = False
        """Whether the engine has paused its pictures."""
        self._idle_at: float | None = None
        """When its last `idle` came, in seconds of the media clock."""
        self._listening: AbstractAsyncContextManager[LinkServer] = LinkServer.listen(
            address,
            secret,
            on_audio=on_audio,
            on_event=self._handle_event,
            on_hello=self._greeted,
            on_gone=on_gone,
            clock=clock,
        )

    @abstractmethod
    async def __aenter__(self) -> Self: ...

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._stack.aclose()

    @property
    def video(self) -> EngineVideo:
        """The pictures of the connected engine; a `MediaSource`."""
        return self._server.video

    @property
    def encoded(self) -> EngineEncoded:
        """The pictures of an engine that encodes them itself."""
        return self._server.encoded

    @property
    def hello(self) -> Hello | None:
        """The engine's HELLO; None while none is connected."""
        return None if self._server.engine is None else self._server.engine.hello

    @property
    def last_sign_at(self) -> float | None:
        """Time of its last picture or, without demand, of its last `idle`; None before the first."""
        drawn = self.video.last_at
        if self._idle_at is None or not self._server.demand.sleeping:
            return drawn
        return self._idle_at if drawn is None else max(drawn, self._idle_at)

    def send(self, command: Command) -> None:
        """Send a command to the engine; never waits.

        Raises:
            LinkError: no engine is connected.
        """
        if self._server.engine is None:
            raise LinkError("no game engine is connected; try again when it is")
        self._server.engine.send_command(command)

    def send_audio(self, sound: RawAudio) -> None:
        """Send a block of the operator's sound, if an engine is connected that takes sound; never waits."""
        if self._server.engine is not None:
            self._server.engine.send_audio(sound)

    def _greeted(self, hello: Hello) -> None:
        self._still, self._idle_at = False, None
        notify(self._on_hello, hello)

    def _handle_event(self, event: Event) -> None:
        if isinstance(event, Pause):
            self._still = event.on
        elif isinstance(event, Idle):
            self._idle_at = self._clock.now()
        notify(self._on_event, event)

    async def _stall(self, first: float) -> None:
        """Return once the engine hangs: it owes signs of life, sends none, and this process could have received one.

        The first sign may take `first` seconds, and so may the first picture.
        """
        watch = SourceWatch(self._clock.now())
        while watch.quiet_for(self._clock.now(), self.last_sign_at, wanted=not self._still) < (
            first if self.last_sign_at is None else HUNG
        ):
            await self._clock.sleep_until(self._clock.now() + CHECK_INTERVAL)
