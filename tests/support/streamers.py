"""Game engines that do WebRTC themselves, played by our own media plane: colour bars and a tone, a session a player.

They speak the engine's side of its protocol in plain JSON, so that nothing of what is tested is used to test it.
"""

import asyncio
import itertools
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from typing import Any

from openrois_avatar.facades.running import FacadeAvatar, run_facade
from openrois_avatar.options.settings import AvatarSettings
from openrois_signaling.messages import Answer, Candidate, Downward, Offer
from openrois_streaming.clock import SystemClock
from openrois_streaming.publish.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.synthetic import ColourBars, Tone
from websockets.asyncio.client import ClientConnection, connect

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.deployment import until

Message = dict[str, Any]


class FakeStreamer:
    """What both engines have in common.

    Attributes:
        said: what it was told, in order.
        sessions: the players that it has, by the id that its protocol gives them.
    """

    def __init__(self, socket: ClientConnection, tasks: TaskScope) -> None:
        self.said: list[Message] = []
        self.sessions: dict[str, StreamSession] = {}
        self._generations: dict[str, int] = {}
        self._socket = socket
        self._tasks = tasks
        self._clock = SystemClock()
        self._video = VideoPublisher(ColourBars(320, 180, 30.0, clock=self._clock), clock=self._clock, stamp=True)
        self._audio = AudioPublisher(Tone(clock=self._clock), clock=self._clock)
        self._numbers = itertools.count(1)
        self._changed = asyncio.Event()

    async def until(self, condition: Callable[[], object]) -> None:
        """Wait until it holds, which is looked at whenever something was said."""
        async with asyncio.timeout(60):
            while not condition():
                self._changed.clear()
                await self._changed.wait()

    def told(self, name: str) -> list[Message]:
        return [message for message in self.said if message["type"] == name]

    async def run(self) -> None:
        await self.greet()
        async for text in self._socket:
            message = json.loads(text)
            self.said.append(message)
            await self.take(message)
            self._changed.set()

    async def say(self, **members: Any) -> None:
        await self._socket.send(json.dumps(members))

    async def greet(self) -> None:
        """Say what the protocol begins with."""

    async def take(self, message: Message) -> None:
        """Take what the server says."""
        raise NotImplementedError

    async def begin(self, name: str, offer: Callable[[Offer], Awaitable[None]]) -> None:
        """Offer picture and sound to a new player."""

        def send(message: Downward) -> None:
            if isinstance(message, Offer):
                self._generations[name] = message.generation
                self._tasks.start(_as_task(offer(message)))

        session = StreamSession(
            mint=lambda: f"fake/{next(self._numbers)}",
            send=send,
            on_change=lambda _change: None,
            clock=self._clock,
            name=name,
        )
        self.sessions[name] = session
        session.connect(f"{name}/video", "fake/Video", self._video, "video")
        session.connect(f"{name}/audio", "fake/Audio", self._audio, "audio")

    async def answer(self, name: str, sdp: str) -> None:
        session = self.sessions[name]
        await session.apply_answer(Answer(peer_id=session.peer_ids[0], generation=self._generations[name], sdp=sdp))

    async def candidate(self, name: str, candidate: str, mid: str | None, index: int | None) -> None:
        session = self.sessions[name]
        found = Candidate(
            peer_id=session.peer_ids[0],
            generation=self._generations[name],
            candidate=candidate,
            sdp_mid=mid,
            sdp_m_line_index=index,
        )
        await session.add_candidate(found)

    async def end(self, name: str) -> None:
        session = self.sessions.pop(name, None)
        if session is not None:
            await session.close("the player is gone")

    async def crash(self) -> None:
        """Be gone, without a word."""
        self._socket.transport.abort()
        await self._socket.wait_closed()
        await self.aclose()

    async def aclose(self) -> None:
        for name in tuple(self.sessions):
            await self.end(name)


class FakeUnreal(FakeStreamer):
    """An Unreal Pixel Streaming 2 streamer."""

    async def take(self, message: Message) -> None:
        match message:
            case {"type": "identify"}:
                await self.say(type="endpointId", id="FakeUnreal", protocolVersion="1.3.0")
            case {"type": "playerConnected", "playerId": player, "sendOffer": True, "dataChannel": False}:

                async def offer(made: Offer) -> None:
                    await self.say(type="offer", playerId=player, sdp=made.sdp, multiplex=True)

                await self.begin(player, offer)
            case {"type": "answer", "playerId": player, "sdp": sdp}:
                await self.answer(player, sdp)
            case {"type": "iceCandidate", "playerId": player, "candidate": found}:
                await self.candidate(player, found["candidate"], found.get("sdpMid"), found.get("sdpMLineIndex"))
            case {"type": "playerDisconnected", "playerId": player}:
                await self.end(player)


class FakeUnity(FakeStreamer):
    """A Unity Render Streaming sender: it asks for its connections anew whenever one has ended."""

    connections = ("first", "second")

    async def greet(self) -> None:
        for connection in self.connections:
            await self.say(type="connect", connectionId=connection)

    async def take(self, message: Message) -> None:
        match message:
            case {"type": "connect", "connectionId": connection}:

                async def offer(made: Offer) -> None:
                    data = {"connectionId": connection, "sdp": made.sdp, "type": "offer", "polite": False}
                    await self._socket.send(json.dumps({"from": connection, "to": "", "type": "offer", "data": data}))

                await self.begin(connection, offer)
            case {"type": "answer", "from": connection, "data": {"sdp": sdp}}:
                await self.answer(connection, sdp)
            case {"type": "candidate", "from": connection, "data": found}:
                await self.candidate(connection, found["candidate"], found.get("sdpMid"), found.get("sdpMLineIndex"))
            case {"type": "disconnect", "connectionId": connection}:
                await self.end(connection)
                await self.say(type="connect", connectionId=connection)


@asynccontextmanager
async def streaming(kind: type[FakeStreamer], url: str) -> AsyncIterator[FakeStreamer]:
    """A game engine that is connected to the server at `url` for as long as the block runs."""
    async with AsyncExitStack() as stack:
        socket = await stack.enter_async_context(connect(url))
        tasks = await stack.enter_async_context(TaskScope())
        engine = kind(socket, tasks)
        stack.push_async_callback(engine.aclose)
        tasks.start(engine.run())
        yield engine


async def _as_task(work: Awaitable[None]) -> None:
    await work


@dataclass(frozen=True)
class House:
    """A gateway, behind which an adapter awaits a game engine."""

    gateway: Gateway
    avatar: FacadeAvatar


@asynccontextmanager
async def house(engine: str, link: str = "tcp:127.0.0.1:0", **gateway_settings: Any) -> AsyncIterator[House]:
    """Run a gateway and an adapter for a game engine in this process; `link` is where its plug-in is awaited."""
    settings = AvatarSettings(engine=engine, facade="127.0.0.1:0", link=link)
    async with (
        run_gateway(GatewaySettings(port=0, **gateway_settings)) as gateway,
        run_facade(settings) as avatar,
        TaskScope() as tasks,
    ):
        tasks.start(serve_parent(avatar.host, gateway.url.replace("http", "ws") + "adapter"))
        await until(gateway.engine, lambda ids: settings.engine_id in ids)
        yield House(gateway, avatar)
