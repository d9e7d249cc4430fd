"""One connection of an engine under test: what it says is kept, what it is told is written as it stands."""

import asyncio
import contextlib
import json
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final

from openrois_avatar.check.seen import Seen
from openrois_avatar.link.encoded_inlet import check_encoded
from openrois_avatar.link.messages import Bye, Command, Completed, Event, Hello, LinkError, Pause
from openrois_avatar.link.protocol import (
    HEADER,
    MAGIC,
    VERSION,
    Audio,
    Doorbell,
    Encoded,
    MessageType,
    Parser,
    Sender,
    Video,
    encode,
)
from openrois_avatar.link.ring import Ring

__all__ = ["Line"]

_READ: Final = 1 << 20
_LATER: Final = {"of_a_later_revision": True}
"""A member that no engine knows; it has to be ignored."""


class Line:
    """A connection; `read` runs for as long as it lasts."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.seen = Seen()
        self.opened = time.monotonic()
        self.hello: Hello | None = None
        self.ring: Ring | None = None
        self.fault = ""
        """What broke the protocol, empty while nothing has."""
        self.end = ""
        """Why it is over, empty while it is not."""
        self._reader = reader
        self._writer = writer
        self._changed = asyncio.Event()

    def is_over(self) -> bool:
        """Whether it is."""
        return self.end != ""

    @property
    def paused(self) -> bool:
        """Whether the engine pauses its pictures now."""
        said = [told.event.on for told in self.seen.events if isinstance(told.event, Pause)]
        return bool(said) and said[-1]

    def completed(self, id: str) -> list[str]:
        """The statuses with which something was told to be over."""
        events = (told.event for told in self.seen.events)
        return [event.status for event in events if isinstance(event, Completed) and event.id == id]

    async def until(self, happened: Callable[[], bool], seconds: float) -> bool:
        """Wait until something has happened, or the connection is over, `seconds` at most; whether it has happened."""
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while not happened() and not self.is_over():
                    self._changed.clear()
                    await self._changed.wait()
        return happened()

    async def watch(self, seconds: float) -> None:
        """Let the engine go on for a while."""
        await self.until(lambda: False, seconds)

    def welcome(self) -> None:
        """Answer its greeting, with a ring if it wants one."""
        assert self.hello is not None, "it is welcomed after it has greeted"
        if self.hello.ring:
            with suppress(LinkError):
                self.ring = Ring(self.hello.video)
        place = None if self.ring is None else self.ring.place.to_json()
        self.say(MessageType.WELCOME, {"name": "openrois-avatar-check", "ring": place, "now_ns": time.monotonic_ns()})

    def tell(self, command: Command) -> None:
        """Send a command."""
        self.say(MessageType.COMMAND, command.to_json())

    def hear(self, sound: Audio) -> None:
        """Send a block of the operator's sound."""
        self._writer.write(b"".join(encode(sound)))

    def say(self, kind: MessageType, body: dict[str, Any]) -> None:
        """Send a message, with a member that the engine does not know."""
        payload = json.dumps({**body, **_LATER}).encode()
        self._writer.write(HEADER.pack(MAGIC, kind, VERSION, 0, len(payload), 0) + payload)

    def hang_up(self, reason: str) -> None:
        """Say goodbye and close the connection."""
        if not self.is_over():
            self.say(MessageType.BYE, Bye(reason).to_json())
            self._close(reason)

    async def read(self) -> None:
        """Keep what arrives, until the connection is over."""
        parser = Parser(Sender.ENGINE)
        try:
            while not self.is_over() and (data := await self._reader.read(_READ)):
                now = time.monotonic()
                for message in parser.feed(data):
                    self._take(message, now)
                self._changed.set()
            self._close("the engine closed the connection")
        except LinkError as error:
            self.fault = str(error)
            self.hang_up(self.fault)
        except OSError as error:
            self._close(f"the connection broke: {error}")
        finally:
            self._close("the check is over")
            if self.ring is not None:
                self.ring.release()
            with contextlib.suppress(OSError):
                await self._writer.wait_closed()

    def _take(self, message: object, now: float) -> None:
        match message:
            case Hello():
                self.hello = message
            case Bye():
                self._close(f"the engine said goodbye: {message.reason}")
            case Video() | Encoded() | Doorbell() | Audio():
                self._check(message)
                self.seen.take(message, now)
            case _:
                assert isinstance(message, Event), "the parser lets an engine say nothing else"
                self.seen.take(message, now)

    def _check(self, message: Video | Encoded | Doorbell | Audio) -> None:
        """Raise `LinkError` for what an adapter would not take."""
        encodes = self.hello is not None and self.hello.encodes
        if not isinstance(message, Audio) and isinstance(message, Encoded) is not encodes:
            raise LinkError(f"VIDEO: HELLO announced {'h264' if encodes else 'no h264'}")
        if isinstance(message, Encoded):
            check_encoded(message)
        if isinstance(message, Doorbell):
            if self.ring is None:
                raise LinkError("RING: no ring was given")
            self.ring.picture(message)

    def _close(self, reason: str) -> None:
        self.end = self.end or reason
        self._writer.close()
        self._changed.set()
