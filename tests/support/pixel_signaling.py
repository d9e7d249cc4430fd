"""A signaling server of Pixel Streaming, small: streamers at `/streamer`, players at any other path."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any, Final

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

PATIENCE: Final = 10.0

Message = dict[str, Any]


class PixelSignaling:
    """The server; the messages received from streamers are in `heard`."""

    def __init__(self) -> None:
        self.url = ""
        self.heard: list[Message] = []
        self.pages: dict[str, tuple[str, bytes]] = {}
        """What it serves over HTTP, by path: content type and body."""
        self.streamers: dict[str, ServerConnection] = {}
        self.players: dict[str, ServerConnection] = {}
        self._news = asyncio.Event()
        self._count = 0

    async def until(self, so: Callable[[], object]) -> None:
        async with asyncio.timeout(PATIENCE):
            while not so():
                self._news.clear()
                await self._news.wait()

    async def until_heard(self, kind: str, count: int = 1) -> Message:
        await self.until(lambda: len(self.of(kind)) >= count)
        return self.of(kind)[count - 1]

    def of(self, kind: str) -> list[Message]:
        return [each for each in self.heard if each["type"] == kind]

    async def tell(self, name: str = "avatar", **message: Any) -> None:
        """Send a message to a streamer, unless it is just leaving."""
        with suppress(ConnectionClosed):
            await self.streamers[name].send(json.dumps(message))

    async def serve(self, connection: ServerConnection) -> None:
        assert connection.request is not None
        options = {"type": "config", "peerConnectionOptions": {}, "protocolVersion": "1.3.0"}
        await connection.send(json.dumps(options))
        if connection.request.path == "/streamer":
            await self._streamer(connection)
        else:
            await self._player(connection)

    async def _streamer(self, connection: ServerConnection) -> None:
        name = ""
        await connection.send(json.dumps({"type": "identify"}))
        async for text in connection:
            message = json.loads(text)
            self.heard.append(message)
            match message["type"]:
                case "endpointId":
                    name = message["id"]
                    self.streamers[name] = connection
                    await connection.send(json.dumps({"type": "endpointIdConfirm", "committedId": name}))
                case "disconnectPlayer":
                    if (gone := self.players.get(message["playerId"])) is not None:
                        await gone.close(1011, message.get("reason", "")[:100])
                case _ if "playerId" in message:
                    player = self.players.get(message["playerId"])
                    if player is not None:
                        await player.send(json.dumps(message))
            self._news.set()
        if self.streamers.pop(name, None) is not None:
            for player in tuple(self.players.values()):
                await player.send(json.dumps({"type": "streamerDisconnected"}))
                await player.close(1001 + 10, "the streamer is gone")

    async def _player(self, connection: ServerConnection) -> None:
        self._count += 1
        player_id, name = f"player{self._count}", ""
        self.players[player_id] = connection
        async for text in connection:
            message = json.loads(text)
            match message["type"]:
                case "listStreamers":
                    await connection.send(json.dumps({"type": "streamerList", "ids": list(self.streamers)}))
                case "subscribe":
                    name = message["streamerId"]
                    told = {"playerId": player_id, "dataChannel": True, "sfu": False, "sendOffer": True}
                    await self.tell(name, type="playerConnected", **told)
                case _ if name in self.streamers:
                    await self.tell(name, **message | {"playerId": player_id})
        del self.players[player_id]
        if name in self.streamers:
            await self.tell(name, type="playerDisconnected", playerId=player_id)
        self._news.set()

    def answer(self, _connection: ServerConnection, request: Request) -> Response | None:
        """Answer plain HTTP requests; None for a WebSocket."""
        kind, body = self.pages.get(request.path, ("", b""))
        if "Upgrade" in request.headers:
            return None
        headers = Headers({"Content-Type": kind, "Content-Length": str(len(body))})
        return Response(200 if body else 404, "", headers, body)


@asynccontextmanager
async def pixel_signaling(port: int = 0) -> AsyncIterator[PixelSignaling]:
    """Run a signaling server, at a free port unless one is given."""
    signaling = PixelSignaling()
    async with serve(signaling.serve, "127.0.0.1", port, process_request=signaling.answer) as server:
        signaling.url = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        yield signaling
