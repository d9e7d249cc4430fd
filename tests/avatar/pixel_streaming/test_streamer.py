"""The adapter at a signaling server: its id, the players that it serves, and its reconnection."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any

import pytest
from openrois_avatar.facades.messages import pixel_streaming as wire
from openrois_avatar.facades.messages.reading import Said
from openrois_avatar.pixel_streaming import streamer as streamer_module
from openrois_avatar.pixel_streaming.player import Step
from openrois_avatar.pixel_streaming.streamer import Streamer
from openrois_signaling.messages import IceServer

from openrois.errors import OutOfResources
from tests.support.pixel_signaling import PixelSignaling, pixel_signaling


class Player:
    """Takes note of what becomes of it."""

    made: "list[Player]"

    def __init__(self, player_id: str, say: Callable[[Said], None], later: Callable[[Step], None]) -> None:
        self.player_id = player_id
        self.over = False
        self.log: list[Any] = []
        self.left = asyncio.Event()
        self.say, self.later = say, later
        Player.made.append(self)

    async def connect(self, ice_servers: tuple[IceServer, ...]) -> None:
        if self.player_id == "refused":
            raise OutOfResources("there is no room")
        self.log.append([url for server in ice_servers for url in server.urls])
        self.say(wire.Offer(player_id=self.player_id, sdp="v=0"))

    async def apply_answer(self, sdp: str) -> None:
        self.log.append(sdp)

    async def add_candidate(self, found: wire.RtcCandidate) -> None:
        self.log.append(found.candidate)
        self.say(wire.IceCandidate(player_id=self.player_id, candidate=found))

    async def follow(self) -> None:
        pass

    async def leave(self) -> None:
        self.left.set()


@asynccontextmanager
async def running(signaling: PixelSignaling) -> AsyncIterator[None]:
    Player.made = []

    async def soon(_seconds: float) -> None:
        pass

    streamer = Streamer(f"{signaling.url}/streamer", "avatar", Player)  # type: ignore[arg-type]
    task = asyncio.ensure_future(streamer.run(sleep=soon))
    yield
    task.cancel()
    with suppress(asyncio.CancelledError):
        await task


@pytest.fixture
async def signaling() -> AsyncIterator[PixelSignaling]:
    async with pixel_signaling() as server, running(server):
        await server.until_heard("endpointId")
        yield server


async def connect(signaling: PixelSignaling, player_id: str, **more: bool) -> None:
    told: dict[str, Any] = {"dataChannel": True, "sfu": False, "sendOffer": True, **more}
    await signaling.tell(type="playerConnected", playerId=player_id, **told)


async def left(player: Player) -> None:
    async with asyncio.timeout(60):
        await player.left.wait()


async def test_streamer_sends_its_id_and_answers_pings(signaling: PixelSignaling) -> None:
    assert signaling.of("endpointId") == [{"type": "endpointId", "id": "avatar", "protocolVersion": "1.3.0"}]
    await signaling.tell(type="ping", time=42)
    assert await signaling.until_heard("pong") == {"type": "pong", "time": 42}


async def test_a_player_is_offered_to_and_what_it_says_comes_in_order(signaling: PixelSignaling) -> None:
    servers = [{"urls": ["stun:stun.example.org"]}]
    await signaling.tell(type="config", peerConnectionOptions={"iceServers": servers})
    await signaling.tell(type="unknown")
    await connect(signaling, "ann")
    assert await signaling.until_heard("offer") == {"type": "offer", "playerId": "ann", "sdp": "v=0"}
    await connect(signaling, "ann")
    await signaling.tell(type="answer", playerId="ann", sdp="v=1")
    await signaling.tell(type="answer", playerId="bob", sdp="v=2")
    await signaling.tell(type="iceCandidate", playerId="ann", candidate={"candidate": "c", "sdpMid": "0"})
    await signaling.until_heard("iceCandidate")
    (player,) = Player.made
    assert player.log == [["stun:stun.example.org"], "v=1", "c"]
    await signaling.tell(type="playerDisconnected", playerId="ann")
    await signaling.tell(type="playerDisconnected", playerId="bob")
    await left(player)
    await connect(signaling, "ann")
    await signaling.until_heard("offer", 2)


@pytest.mark.parametrize("more", [{"sfu": True}, {"sendOffer": False}])
async def test_sfu_or_player_that_offers_itself_is_refused(signaling: PixelSignaling, more: dict[str, bool]) -> None:
    await connect(signaling, "ann", **more)
    refusal = await signaling.until_heard("disconnectPlayer")
    assert (refusal["playerId"], refusal["reason"]) == (
        "ann",
        "the avatar makes the offers, and serves players only, no SFU",
    )


async def test_there_is_room_for_so_many(signaling: PixelSignaling, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streamer_module, "PLAYERS_LIMIT", 1)
    await connect(signaling, "ann")
    await connect(signaling, "bob")
    assert (await signaling.until_heard("disconnectPlayer"))[
        "reason"
    ] == "the avatar has 1 players already, which is the limit"


async def test_refused_player_gets_the_reason_and_leaves_its_place(signaling: PixelSignaling) -> None:
    await connect(signaling, "refused")
    assert (await signaling.until_heard("disconnectPlayer"))["reason"] == "there is no room"
    await left(Player.made[0])


async def test_player_with_an_ended_peer_connection_leaves(signaling: PixelSignaling) -> None:
    await connect(signaling, "ann")
    await signaling.until_heard("offer")
    (player,) = Player.made
    player.over = True
    player.later(player.follow)
    await left(player)


async def test_messages_of_a_player_beyond_the_queue_are_dropped(
    signaling: PixelSignaling, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(streamer_module, "UNREAD_LIMIT", 1)
    await connect(signaling, "ann")
    await signaling.until_heard("offer")
    (player,) = Player.made
    with caplog.at_level("INFO"):
        player.later(player.follow)
        player.later(player.follow)
    assert "player ann sends too fast: a message is dropped" in caplog.text


@pytest.mark.parametrize("said", ["no JSON", '{"type": "answer"}'])
async def test_malformed_message_ends_the_connection_which_is_made_again(signaling: PixelSignaling, said: str) -> None:
    await connect(signaling, "ann")
    await signaling.until_heard("offer")
    await signaling.streamers["avatar"].send(said)
    await left(Player.made[0])
    await signaling.until_heard("endpointId", 2)


async def test_a_server_that_does_not_read_is_left(signaling: PixelSignaling, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streamer_module, "UNSENT_LIMIT", 1)
    await signaling.streamers["avatar"].close()
    await signaling.until_heard("endpointId", 2)
    await connect(signaling, "ann")
    await signaling.until_heard("offer")
    (player,) = Player.made
    player.say(wire.Ping(time=1))
    player.say(wire.Ping(time=2))
    await left(player)
    await signaling.until_heard("endpointId", 3)


async def test_where_nothing_or_something_else_answers_it_tries_again(caplog: pytest.LogCaptureFixture) -> None:
    tries: list[float] = []
    enough = asyncio.Event()

    async def sleep(seconds: float) -> None:
        tries.append(seconds)
        if len(tries) == 3:
            enough.set()
            await asyncio.Event().wait()

    async def refuse(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")
        writer.close()

    async with await asyncio.start_server(refuse, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        task = asyncio.ensure_future(Streamer(f"ws://127.0.0.1:{port}", "avatar", Player).run(sleep=sleep))  # type: ignore[arg-type]
        async with asyncio.timeout(60):
            await enough.wait()
        task.cancel()
    assert tries == [1.0, 1.5, 2.25]
    assert "no signaling server for streamers answers at" in caplog.text
