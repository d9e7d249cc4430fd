"""Whichever game engine is connected to a link server: its pictures, what it is told, and whether it hangs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack
from types import TracebackType
from typing import Self

from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import RawAudio
from openrois_streaming.source.supervision import HUNG, LOOK_INTERVAL, SourceWatch

from openrois_avatar.link.encoded_inlet import EngineEncoded
from openrois_avatar.link.inlet import EngineVideo
from openrois_avatar.link.messages import Command, Event, Hello, Idle, LinkError, Pause
from openrois_avatar.link.receivers import tell
from openrois_avatar.link.server import LinkServer


class LinkedEngine(ABC):
    """A game engine that may come and go; what it sends goes on where it went before."""

    _server: LinkServer  # there from entering on

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
        """What the subclass has entered."""
        self._still = False
        """Whether it has paused its pictures."""
        self._idle_at: float | None = None
        """When it last said that it draws nothing, in seconds of the media clock."""
        self._listening: AbstractAsyncContextManager[LinkServer] = LinkServer.listen(
            address,
            secret,
            on_audio=on_audio,
            on_event=self._take,
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
        """The pictures of whichever engine is there; a `MediaSource`."""
        return self._server.video

    @property
    def encoded(self) -> EngineEncoded:
        """Its pictures, where it encodes them itself."""
        return self._server.encoded

    @property
    def hello(self) -> Hello | None:
        """What the engine said of itself; None while it is not there."""
        return None if self._server.engine is None else self._server.engine.hello

    @property
    def last_sign_at(self) -> float | None:
        """When it last gave a picture or, while none are wanted, said that it draws none; None if it has not yet."""
        drawn = self.video.last_at
        if self._idle_at is None or not self._server.demand.sleeping:
            return drawn
        return self._idle_at if drawn is None else max(drawn, self._idle_at)

    def send(self, command: Command) -> None:
        """Send a command to the engine; never waits.

        Raises:
            LinkError: the engine is not there now.
        """
        if self._server.engine is None:
            raise LinkError("the engine is not there now")
        self._server.engine.send_command(command)

    def hear(self, sound: RawAudio) -> None:
        """Let the engine hear a block of sound, if it is there and wants to; never waits."""
        if self._server.engine is not None:
            self._server.engine.send_audio(sound)

    def _greeted(self, hello: Hello) -> None:
        self._still, self._idle_at = False, None
        tell(self._on_hello, hello)

    def _take(self, event: Event) -> None:
        if isinstance(event, Pause):
            self._still = event.on
        elif isinstance(event, Idle):
            self._idle_at = self._clock.now()
        tell(self._on_event, event)

    async def _stall(self, first: float) -> None:
        """Return once the engine has given no sign for a while, was to, and this process was able to take one.

        The first sign may take `first` seconds, and so may the first picture.
        """
        watch = SourceWatch(self._clock.now())
        while watch.quiet_for(self._clock.now(), self.last_sign_at, wanted=not self._still) < (
            first if self.last_sign_at is None else HUNG
        ):
            await self._clock.sleep_until(self._clock.now() + LOOK_INTERVAL)
