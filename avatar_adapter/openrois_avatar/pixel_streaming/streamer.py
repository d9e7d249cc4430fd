"""The adapter as a streamer at a signaling server of Pixel Streaming, and its players there."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from typing import Final, TypeAlias

from openrois_signaling.messages import IceServer
from websockets.exceptions import InvalidHandshake

from openrois.aio.tasks import TaskScope
from openrois.errors import RoISError
from openrois.transport.backoff import Backoff
from openrois.transport.stream import MessageStream, StreamClosed
from openrois.transport.websocket import dial
from openrois_avatar.facades.messages import pixel_streaming as wire
from openrois_avatar.facades.messages.reading import ProtocolError, Said
from openrois_avatar.pixel_streaming.player import Player, Step

__all__ = ["PLAYERS_LIMIT", "MakePlayer", "Streamer"]

_log = logging.getLogger(__name__)

PLAYERS_LIMIT: Final = 32
UNSENT_LIMIT: Final = 1024
"""Messages that may wait to be sent to the signaling server."""
UNREAD_LIMIT: Final = 128
"""Messages of one player that may wait until the earlier ones are handled."""

PROTOCOL_VERSION: Final = "1.3.0"
"""The version of the signaling protocol."""

Say: TypeAlias = Callable[[Said], None]
MakePlayer: TypeAlias = Callable[[str, Say, Callable[[Step], None]], Player]
"""Makes a player of its id and of the functions that send the signaling server a message and queue a step."""


class _Attended:
    """A player and the queue of its steps."""

    def __init__(self, player_id: str, make_player: MakePlayer, say: Say) -> None:
        self.steps: asyncio.Queue[Step] = asyncio.Queue(UNREAD_LIMIT)
        self.player = make_player(player_id, say, self.later)

    def later(self, step: Step) -> None:
        """Queue a step; dropped where too many wait."""
        try:
            self.steps.put_nowait(step)
        except asyncio.QueueFull:
            _log.info("player %s sends too fast: a message is dropped", self.player.player_id)


class Streamer:
    """The adapter's end of connections to one signaling server.

    Args:
        url: of the signaling server, for streamers.
        name: the avatar's id there.
        make_player: makes a player.
    """

    def __init__(self, url: str, name: str, make_player: MakePlayer) -> None:
        self._url = url
        self._name = name
        self._make_player = make_player

    async def run(
        self,
        *,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Serve players until cancelled; a connection that ends is made again.

        Args:
            sleep: waits for some seconds between attempts: 1 s, then half as long again each time, at most 30 s.
            clock: monotonic seconds, to tell a connection that lasted from one that was refused.
        """
        backoff = Backoff()
        while True:
            lasted = 0.0
            try:
                async with dial(self._url) as stream:
                    connected = clock()
                    _log.info("connected to the signaling server %s", self._url)
                    try:
                        await self._serve(stream)
                    except (StreamClosed, ProtocolError) as error:
                        _log.info("the signaling server has disconnected: %s", error)
                    lasted = clock() - connected
            except InvalidHandshake as error:
                _log.warning(
                    "no signaling server for streamers answers at %s, check --pixel-streaming: %s", self._url, error
                )
            except (OSError, TimeoutError) as error:
                _log.info("no signaling server at %s: %s", self._url, error)
            await sleep(backoff.after(lasted))

    async def _serve(self, stream: MessageStream) -> None:
        """Serve until the connection ends, which ends all its players.

        Raises:
            StreamClosed: it has ended.
            ProtocolError: a message is malformed.
        """
        unsent: asyncio.Queue[str] = asyncio.Queue(UNSENT_LIMIT)

        def say(message: Said) -> None:
            try:
                unsent.put_nowait(message.text())
            except asyncio.QueueFull:
                _log.warning("the signaling server does not read: its connection is ended")
                stream.abort()

        async def send() -> None:
            while True:
                try:
                    await stream.send(await unsent.get())
                except StreamClosed:
                    return

        async with TaskScope() as tasks:
            tasks.start(send())
            visit = _Visit(self._name, self._make_player, say, tasks)
            while True:
                visit.handle_message(await stream.receive())


class _Visit:
    """The messages of one connection to a signaling server."""

    def __init__(self, name: str, make_player: MakePlayer, say: Say, tasks: TaskScope) -> None:
        self._name = name
        self._make_player = make_player
        self._say = say
        self._tasks = tasks
        self._attended: dict[str, _Attended] = {}
        self._ice_servers: tuple[IceServer, ...] = ()

    def handle_message(self, text: str) -> None:
        """Handle one message; unknown ones are dropped.

        Raises:
            ProtocolError: it is malformed.
        """
        match wire.SERVER_SAYS.read(text):
            case wire.Config(peer_connection_options=options):
                self._ice_servers = options.ice_servers
            case wire.Identify():
                self._say(wire.EndpointId(id=self._name, protocol_version=PROTOCOL_VERSION))
            case wire.EndpointIdConfirm(committed_id=name):
                _log.info("the avatar's id at the signaling server is %s", name)
            case wire.Ping(time=asked):
                self._say(wire.Pong(time=asked))
            case wire.PlayerConnected() as told:
                self._welcome(told)
            case wire.PlayerDisconnected(player_id=player_id):
                gone = self._attended.pop(player_id, None)
                if gone is not None:
                    gone.player.over = True
                    gone.later(gone.player.follow)
            case wire.Answer(player_id=player_id, sdp=sdp):
                self._pass(player_id, lambda player: player.apply_answer(sdp))
            case wire.IceCandidate(player_id=player_id, candidate=found):
                self._pass(player_id, lambda player: player.add_candidate(found))
            case _:
                pass

    def _welcome(self, told: wire.PlayerConnected) -> None:
        refusal = ""
        if told.sfu or not told.send_offer:
            refusal = "the avatar makes the offers, and serves players only, no SFU"
        elif len(self._attended) >= PLAYERS_LIMIT:
            refusal = f"the avatar has {PLAYERS_LIMIT} players already, which is the limit"
        elif told.player_id in self._attended:
            return
        if refusal:
            self._say(wire.DisconnectPlayer(player_id=told.player_id, reason=refusal))
            return
        attended = self._attended[told.player_id] = _Attended(told.player_id, self._make_player, self._say)
        self._tasks.start(self._attend(attended))

    def _pass(self, player_id: str, step: Callable[[Player], Awaitable[None]]) -> None:
        attended = self._attended.get(player_id)
        if attended is not None:
            attended.later(lambda: step(attended.player))

    async def _attend(self, attended: _Attended) -> None:
        player = attended.player
        try:
            await player.connect(self._ice_servers)
            while not player.over:
                await (await attended.steps.get())()
        except RoISError as error:
            self._say(wire.DisconnectPlayer(player_id=player.player_id, reason=str(error)[:1024]))
        finally:
            if self._attended.get(player.player_id) is attended:
                del self._attended[player.player_id]
            await player.leave()
