"""A connection to the engine under test: its messages are recorded, and commands are sent unchecked."""

import asyncio
import contextlib
import json
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final

from openrois_avatar.check.record import Record
from openrois_avatar.link.encoded_source import check_encoded, unannounced
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

__all__ = ["CheckedConnection"]

_READ: Final = 1 << 20
_LATER: Final = {"of_a_later_revision": True}
"""A member that no engine knows; engines have to ignore it."""


class CheckedConnection:
    """A connection to the engine under test; `read` runs for as long as it lasts."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.record = Record()
        self.opened = time.monotonic()
        self.hello: Hello | None = None
        self.ring: Ring | None = None
        self.fault = ""
        """The violation of the protocol; empty without one."""
        self.end = ""
        """Why the connection has ended; empty while it has not."""
        self._reader = reader
        self._writer = writer
        self._changed = asyncio.Event()

    def is_over(self) -> bool:
        """Return whether the connection has ended."""
        return self.end != ""

    @property
    def paused(self) -> bool:
        """Whether the engine pauses its pictures now."""
        said = [told.event.on for told in self.record.events if isinstance(told.event, Pause)]
        return bool(said) and said[-1]

    def completed(self, id: str) -> list[str]:
        """Return the statuses with which the engine completed a command."""
        events = (told.event for told in self.record.events)
        return [event.status for event in events if isinstance(event, Completed) and event.id == id]

    async def until(self, happened: Callable[[], bool], seconds: float) -> bool:
        """Wait until `happened`, or the end of the connection, `seconds` at most; return whether it happened."""
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while not happened() and not self.is_over():
                    self._changed.clear()
                    await self._changed.wait()
        return happened()

    async def watch(self, seconds: float) -> None:
        """Record the engine for some seconds."""
        await self.until(lambda: False, seconds)

    def welcome(self) -> None:
        """Answer HELLO with WELCOME, with a ring if the engine asked for one."""
        assert self.hello is not None, "WELCOME follows HELLO"
        if self.hello.ring:
            with suppress(LinkError):
                self.ring = Ring(self.hello.video)
        place = None if self.ring is None else self.ring.place.to_json()
        self.send_message(
            MessageType.WELCOME, {"name": "openrois-avatar-check", "ring": place, "now_ns": time.monotonic_ns()}
        )

    def send_command(self, command: Command) -> None:
        """Send a command."""
        self.send_message(MessageType.COMMAND, command.to_json())

    def send_sound(self, sound: Audio) -> None:
        """Send a block of the operator's sound."""
        self._writer.write(b"".join(encode(sound)))

    def send_message(self, kind: MessageType, body: dict[str, Any]) -> None:
        """Send a message, with a member that the engine does not know."""
        payload = json.dumps({**body, **_LATER}).encode()
        self._writer.write(HEADER.pack(MAGIC, kind, VERSION, 0, len(payload), 0) + payload)

    def hang_up(self, reason: str) -> None:
        """Say goodbye and close the connection."""
        if not self.is_over():
            self.send_message(MessageType.BYE, Bye(reason).to_json())
            self._close(reason)

    async def read(self) -> None:
        """Record messages until the connection has ended."""
        parser = Parser(Sender.ENGINE)
        try:
            while not self.is_over() and (data := await self._reader.read(_READ)):
                now = time.monotonic()
                for message in parser.feed(data):
                    self._record_message(message, now)
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

    def _record_message(self, message: object, now: float) -> None:
        match message:
            case Hello():
                self.hello = message
            case Bye():
                self._close(f"the engine said goodbye: {message.reason}")
            case Video() | Encoded() | Doorbell() | Audio():
                self._check(message)
                self.record.add_message(message, now)
            case _:
                assert isinstance(message, Event), "the parser accepts nothing else of an engine"
                self.record.add_message(message, now)

    def _check(self, message: Video | Encoded | Doorbell | Audio) -> None:
        """Raise `LinkError` for a message that an adapter refuses."""
        encodes = self.hello is not None and self.hello.encodes
        if not isinstance(message, Audio) and isinstance(message, Encoded) is not encodes:
            raise unannounced(encodes)
        if isinstance(message, Encoded):
            check_encoded(message)
        if isinstance(message, Doorbell):
            if self.ring is None:
                raise LinkError("RING: no ring was given; send VIDEO, or HELLO with `ring`")
            self.ring.picture(message)

    def _close(self, reason: str) -> None:
        self.end = self.end or reason
        self._writer.close()
        self._changed.set()
