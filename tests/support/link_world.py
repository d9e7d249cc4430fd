"""A link server and the engines that connect to it, each made of one asyncio stream."""

import asyncio
from contextlib import suppress
from dataclasses import replace

from openrois_avatar.link.messages import Event, Hello, Welcome
from openrois_avatar.link.protocol import Message, Parser, Sender
from openrois_avatar.link.server import LinkServer
from openrois_streaming.source.source import RawAudio

from tests.support.avatar_link import HELLO, wire


class Engine:
    """An engine made of one asyncio stream."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader, self.writer = reader, writer
        self._parser = Parser(Sender.ADAPTER)
        self._messages: list[Message] = []

    def send(self, *messages: Message) -> None:
        self.writer.write(wire(*messages))

    async def read(self) -> Message | None:
        """The next message, None at the end of the connection."""
        async with asyncio.timeout(60):
            while not self._messages:
                data = await self.reader.read(65536)
                if not data:
                    return None
                self._messages += self._parser.feed(data)
        return self._messages.pop(0)

    async def aclose(self) -> None:
        self.writer.close()
        with suppress(OSError):
            await self.writer.wait_closed()


class World:
    """A server, what it received, and the engines that connect to it."""

    def __init__(self, server: LinkServer, audio: list[RawAudio], events: list[Event]) -> None:
        self.server, self.audio, self.events = server, audio, events
        self.engines: list[Engine] = []

    @property
    def hello(self) -> Hello:
        return replace(HELLO, secret=self.server.secret)

    async def dial(self) -> Engine:
        engine = Engine(*await asyncio.open_unix_connection(self.server.address.removeprefix("unix:")))
        self.engines.append(engine)
        return engine

    async def join(self) -> Engine:
        engine = await self.dial()
        engine.send(self.hello)
        assert isinstance(await engine.read(), Welcome)
        return engine
