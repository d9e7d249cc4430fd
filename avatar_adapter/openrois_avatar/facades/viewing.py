"""What one application sees of a game engine that does WebRTC itself: its streams, over one player at a time. Pure.

The game engine decides by itself what a player is sent, and never asks again. So a player carries exactly the streams
that are to play; whenever these are others, a new player takes the place of the one before, which stays until the new
one has had time to show something. A suspended stream has no player at all: nothing of it is sent.
"""

import secrets
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from openrois_signaling.messages import Answer, Bye, Candidate, Downward, IceServer, MediaKind
from openrois_signaling.negotiation import PREPARE_TIMEOUT, Negotiation
from openrois_streaming.errors import InvalidDescription, TooManySections, UnknownPeer, UnknownStream

from openrois.types.codes import StreamStatus
from openrois_avatar.facades.player import Carried, Player
from openrois_avatar.facades.sections import UnusableDescription
from openrois_avatar.facades.streamer import Found, Heard, NoRoom, NotOffered, Offered, Streamer

__all__ = ["HANDOVER", "Change", "Viewing"]

HANDOVER: Final = 5.0
"""Seconds that a player is kept after the one that replaces it was answered."""

_NOT_CONNECTED, _RUNNING = StreamStatus.STREAMING_NOT_CONNECTED, StreamStatus.STREAMING_RUNNING
_SUSPENDED, _RESUMED = StreamStatus.STREAMING_SUSPENDED, StreamStatus.STREAMING_RESUMED


@dataclass(frozen=True, slots=True)
class Change:
    """A stream has another status, or an event of that name has happened to it."""

    stream_id: str
    component_ref: str
    status: StreamStatus


@dataclass(slots=True, eq=False)
class _Viewed:
    """A stream of the application, and what was told of it last."""

    what: Carried
    suspended: bool = False
    status: StreamStatus = _NOT_CONNECTED
    told: StreamStatus = _NOT_CONNECTED


class Viewing:
    """The streams of one application.

    It has to be looked at several times a second (`tick`): everything that is told is told from there, or when the game
    engine has said something, and not from within the methods that answer a request; but `answer` may say bye.

    Args:
        mint: makes a new peer id.
        streamer: the game engine, if one is there now.
        send: sends the application a message.
        changed: is told every change of a stream's status.
        clock: monotonic seconds.
        permits: tells whether a candidate of the application may be used.
    """

    def __init__(
        self,
        mint: Callable[[], str],
        streamer: Callable[[], Streamer | None],
        send: Callable[[Downward], None],
        changed: Callable[[Change], None],
        clock: Callable[[], float],
        permits: Callable[[str], bool],
    ) -> None:
        self.ice_servers: tuple[IceServer, ...] = ()
        self._mint = mint
        self._streamer = streamer
        self._send = send
        self._changed = changed
        self._clock = clock
        self._permits = permits
        self._streams: dict[str, _Viewed] = {}
        self._ended: list[_Viewed] = []
        """Of whose end nothing was told yet."""
        self._present: Player | None = None
        self._replaced: Player | None = None
        self._parked = ""
        """The peer connection that the application keeps while no player is behind it."""
        self._lacking: set[MediaKind] = set()
        """What the game engine has not offered, as long as it is the same one."""
        self._due = False
        """The present player may not be the one that is wanted."""
        self._anew = False
        """Another player is wanted, whatever it carries."""
        self._waiting_since: float | None = None
        """Since when a place for a player is awaited."""

    @property
    def is_over(self) -> bool:
        """Whether there are neither streams nor peer connections."""
        return not (self._streams or self._ended or self._parked or self._players())

    def has_stream(self, stream_id: str) -> bool:
        """Whether the stream is one of the application's, and has not ended."""
        return stream_id in self._streams

    def connect(self, stream_id: str, component_ref: str, kind: MediaKind) -> None:
        """Add a stream; an offer follows.

        Raises:
            NotOffered: the game engine has not offered it.
            TooManySections: there is one of this kind already.
            NoRoom: the game engine takes no further player.
        """
        if kind in self._lacking:
            raise NotOffered(f"the game engine sends no {kind}")
        if any(stream.what.kind == kind for stream in self._streams.values()):
            raise TooManySections(f"there is a {kind} stream already, and the game engine sends one")
        streamer = self._streamer()
        if streamer is None or not (self._players() or self._streams or streamer.has_room):
            raise NoRoom("the game engine takes no further viewer now")
        self._streams[stream_id] = _Viewed(Carried(stream_id, component_ref, kind))
        self._due = True

    def suspend(self, stream_id: str) -> None:
        """Have nothing of it sent. Suspending twice is fine. Raises UnknownStream."""
        stream = self._stream(stream_id)
        stream.suspended = self._due = True
        stream.status = _SUSPENDED

    def resume(self, stream_id: str) -> None:
        """Have it sent again; an offer follows. Resuming twice is fine. Raises UnknownStream."""
        self._stream(stream_id).suspended = False
        self._due = True

    def disconnect(self, stream_id: str) -> None:
        """End a stream. Raises UnknownStream."""
        self._end_stream(self._stream(stream_id))
        self._due = True

    def status(self, stream_id: str) -> StreamStatus:
        """The status of a stream now. Raises UnknownStream."""
        return self._stream(stream_id).status

    def answer(self, answer: Answer) -> None:
        """Take an answer. Raises UnknownPeer, StaleGeneration, InvalidDescription."""
        player = self._player(answer.peer_id)
        try:
            player.answer(answer, self._clock())
        except (InvalidDescription, UnusableDescription) as error:
            self._end_player(player, str(error))
            raise InvalidDescription(str(error)) from error

    def candidate(self, candidate: Candidate) -> None:
        """Take a candidate. Raises UnknownPeer, StaleGeneration, TooManyCandidates, InvalidCandidate."""
        self._player(candidate.peer_id).candidate(candidate)

    def restart(self, peer_id: str) -> None:
        """Have another player take the place of this one; an offer follows. Raises UnknownPeer.

        Nothing changes while one is being replaced already, or where nothing is to be sent.
        """
        if peer_id == self._parked:
            return
        player = self._player(peer_id)
        if player is self._present and player.is_settled:
            self._anew = self._due = True

    def end_peer(self, peer_id: str, reason: str) -> None:
        """End a peer connection. Raises UnknownPeer."""
        if peer_id == self._parked:
            self.close(reason)
        else:
            self._end_player(self._player(peer_id), reason)

    def hear(self, heard: Heard) -> None:
        """Take what the game engine says; what is about the players of others is passed over."""
        player = next((each for each in self._players() if each.player_id == heard.player_id), None)
        if player is None:
            return
        if isinstance(heard, Offered):
            self._offered(player, heard.sdp)
        elif isinstance(heard, Found):
            player.found(heard)
        else:
            self._end_player(player, heard.reason)

    def _offered(self, player: Player, sdp: str) -> None:
        wanted = player.carried or self._wanted()
        try:
            player.offered(sdp, wanted, self._clock())
        except UnusableDescription as error:
            self._end_player(player, str(error))
            return
        for lacking in set(wanted).difference(player.carried):
            self._lacking.add(lacking.kind)
            self._end_stream(self._streams[lacking.stream_id])

    def close(self, reason: str) -> None:
        """End everything; `reason` is a sentence for a person."""
        for player in self._players():
            player.end(reason)
        if self._parked:
            self._send(Bye(peer_id=self._parked, reason=reason))
        self._present = self._replaced = None
        self._parked = ""
        self._due = self._anew = False
        self._waiting_since = None
        self._lacking.clear()
        for stream in tuple(self._streams.values()):
            self._end_stream(stream)
        self._tell()

    def tick(self) -> None:
        """Look at deadlines, let players come and go, and tell what changed."""
        now = self._clock()
        for player in self._players():
            if player.expire(now):
                self._gone(player)
        self._hand_over(now)
        if self._due and (self._present is None or self._present.is_settled):
            self._renew(now)
        self._judge()
        self._tell()

    def _hand_over(self, now: float) -> None:
        """Let a player go when the one that replaces it has had time to show something.

        What is suspended is not sent a moment longer than the rest needs.
        """
        if self._replaced is None or self._present is None or self._present.answered_at is None:
            return
        if self._holds_suspended(self._replaced) or now - self._present.answered_at >= HANDOVER:
            self._drop_replaced()

    def _drop_replaced(self) -> None:
        """Let the player go that was replaced.

        Where it carried what is suspended now, the application keeps its end, and with it the last picture: to say bye
        would be to say that these streams are over.
        """
        player, self._replaced = self._replaced, None
        if player is None:
            return
        if self._holds_suspended(player):
            player.leave()
        else:
            player.end("it was replaced")

    def _holds_suspended(self, player: Player) -> bool:
        suspended = {stream.what for stream in self._streams.values() if stream.suspended}
        return not suspended.isdisjoint(player.carried)

    def _wanted(self) -> tuple[Carried, ...]:
        return tuple(stream.what for stream in self._streams.values() if not stream.suspended)

    def _renew(self, now: float) -> None:
        """Have the player that is wanted now."""
        wanted, present = self._wanted(), self._present
        if not self._streams:
            self.close("no stream is left to play")
        elif not wanted:
            self._park()
        elif present is None or self._anew or set(present.carried) != set(wanted):
            self._replace(now)
        else:
            self._due = False

    def _park(self) -> None:
        """Nothing is to be sent: the game engine lets the player go, and the application keeps its end of it."""
        self._due = self._anew = False
        self._waiting_since = None
        self._drop_replaced()
        if self._present is not None:
            self._parked, present = self._present.peer_id, self._present
            self._present = None
            present.leave()

    def _replace(self, now: float) -> None:
        """Invite a new player in the place of the present one."""
        streamer = self._streamer()
        if streamer is None:
            self.close("the game engine is gone")
            return
        self._drop_replaced()
        if not streamer.has_room:
            self._await_room(now)
            return
        before = self._present.peer_id if self._present is not None else self._parked or None
        player_id = secrets.token_hex(16)
        player = Player(player_id, Negotiation(self._mint(), before), streamer, self._send, self._permits)
        self._replaced, self._present = self._present, player
        self._parked, self._waiting_since = "", None
        self._due = self._anew = False
        player.begin(now)
        streamer.invite(player_id, self.ice_servers)

    def _await_room(self, now: float) -> None:
        """A game engine that has no place for two players of one application may have one when the first has gone."""
        self._anew = True
        if self._present is not None:
            self._park()
            self._due = self._anew = True
        if self._waiting_since is None:
            self._waiting_since = now
        elif now - self._waiting_since >= PREPARE_TIMEOUT:
            self.close("the game engine takes no further viewer")

    def _judge(self) -> None:
        """Say of each stream what it does.

        That media arrives cannot be seen from here. A stream runs when both ends agreed on it and neither took it back.
        """
        carried = {
            each.stream_id for player in self._players() if player.answered_at is not None for each in player.carried
        }
        for stream in self._streams.values():
            if not stream.suspended and stream.what.stream_id in carried:
                stream.status = _RUNNING

    def _tell(self) -> None:
        ended, self._ended = self._ended, []
        for stream in (*ended, *self._streams.values()):
            if stream.status is not stream.told or stream in ended:
                if stream.told is _SUSPENDED and stream.status is _RUNNING:
                    self._changed(Change(stream.what.stream_id, stream.what.component_ref, _RESUMED))
                stream.told = stream.status
                self._changed(Change(stream.what.stream_id, stream.what.component_ref, stream.status))

    def _stream(self, stream_id: str) -> _Viewed:
        try:
            return self._streams[stream_id]
        except KeyError:
            raise UnknownStream("there is no such stream") from None

    def _player(self, peer_id: str) -> Player:
        for player in self._players():
            if player.peer_id == peer_id:
                return player
        raise UnknownPeer("there is no such peer connection")

    def _players(self) -> tuple[Player, ...]:
        """Those that have not ended, the present one first."""
        return tuple(player for player in (self._present, self._replaced) if player is not None)

    def _end_stream(self, stream: _Viewed) -> None:
        del self._streams[stream.what.stream_id]
        stream.status = _NOT_CONNECTED
        self._ended.append(stream)

    def _end_player(self, player: Player, reason: str) -> None:
        player.end(reason)
        self._gone(player)

    def _gone(self, player: Player) -> None:
        """A player has ended; the one that it was to replace goes on with what it carries."""
        if player is self._replaced:
            self._replaced = None
            return
        self._present, self._replaced = self._replaced, None
        left = set() if self._present is None else set(self._present.carried)
        for stream in tuple(self._streams.values()):
            if stream.what not in left:
                self._end_stream(stream)
