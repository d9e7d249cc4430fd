"""What one application sees of a game engine that does WebRTC itself: its streams, over one player at a time. Pure.

The game engine decides by itself what a player is sent, and never asks again. So a player carries exactly the streams
that are to play; whenever these are others, a new player takes the place of the one before, which stays until the new
one has had time to show something. A suspended stream has no player at all: nothing of it is sent.
"""

import secrets
from collections.abc import Callable
from typing import Final

from openrois_signaling.messages import Answer, Candidate, Downward, IceServer, MediaKind
from openrois_signaling.negotiation import PREPARE_TIMEOUT, Negotiation
from openrois_streaming.errors import InvalidDescription, TooManySections

from openrois.types.codes import StreamStatus
from openrois_avatar.facades.player import Carried, Player
from openrois_avatar.facades.players import Players
from openrois_avatar.facades.sections import UnusableDescription
from openrois_avatar.facades.streamer import Found, Heard, NoRoom, NotOffered, Offered, Streamer
from openrois_avatar.facades.viewed import Change, ViewedStreams

__all__ = ["GATHERING", "HANDOVER", "Viewing"]

GATHERING: Final = 0.1
"""Seconds without a further change after which another player is invited: who connects two streams gets one player."""

HANDOVER: Final = 5.0
"""Seconds that a player is kept after the one that replaces it was answered."""


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
        permits: tells whether a candidate of the application may be used, and raises InvalidCandidate for one that
            cannot be read.
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
        self._clock = clock
        self._permits = permits
        self._streams = ViewedStreams(changed)
        self._players = Players(send)
        self._made_at = clock()
        self._was_answered = False
        self._lacking: set[MediaKind] = set()
        """What the game engine has not offered, as long as it is the same one."""
        self._due_at: float | None = None
        """When it has to be seen whether the present player is the one that is wanted; None: there is no reason to."""
        self._anew = False
        """Another player is wanted, whatever it carries."""
        self._waiting_since: float | None = None
        """Since when a place for a player is awaited."""

    @property
    def is_over(self) -> bool:
        """Whether there are neither streams nor peer connections."""
        return self._streams.is_over and self._players.peer_id is None

    def unanswered_for(self) -> float | None:
        """Seconds since the application came, where it has answered no offer; None where it has answered one."""
        return None if self._was_answered else self._clock() - self._made_at

    def connect(self, stream_id: str, component_ref: str, kind: MediaKind) -> None:
        """Add a stream; an offer follows.

        Raises:
            NotOffered: the game engine has not offered it.
            TooManySections: there is one of this kind already.
            NoRoom: the game engine takes no further player.
        """
        if kind in self._lacking:
            raise NotOffered(f"the game engine sends no {kind}")
        if self._streams.has(kind):
            raise TooManySections(f"there is a {kind} stream already, and the game engine sends one")
        streamer = self._streamer()
        if streamer is None or (self.is_over and not streamer.has_room):
            raise NoRoom("the game engine takes no further viewer now")
        self._streams.add(Carried(stream_id, component_ref, kind))
        self._look_later()

    def suspend(self, stream_id: str) -> None:
        """Have nothing of it sent. Suspending twice is fine. Raises UnknownStream."""
        self._streams.suspend(stream_id)
        self._look_later()

    def resume(self, stream_id: str) -> None:
        """Have it sent again; an offer follows. Resuming twice is fine. Raises UnknownStream."""
        self._streams.resume(stream_id)
        self._look_later()

    def disconnect(self, stream_id: str) -> None:
        """End a stream. Raises UnknownStream."""
        self._streams.end(self._streams[stream_id])
        self._look_later()

    def status(self, stream_id: str) -> StreamStatus:
        """The status of a stream now. Raises UnknownStream."""
        return self._streams[stream_id].status

    def answer(self, answer: Answer) -> None:
        """Take an answer. Raises UnknownPeer, UnexpectedAnswer, InvalidDescription."""
        player = self._players.find(answer.peer_id)
        try:
            player.answer(answer, self._clock())
        except (InvalidDescription, UnusableDescription) as error:
            self._end_player(player, str(error))
            raise InvalidDescription(str(error)) from error
        self._was_answered = True

    def candidate(self, candidate: Candidate) -> None:
        """Take a candidate. Raises UnknownPeer, StaleGeneration, TooManyCandidates, InvalidCandidate."""
        self._players.find(candidate.peer_id).candidate(candidate)

    def restart(self, peer_id: str) -> None:
        """Have another player take the place of this one; an offer follows. Raises UnknownPeer.

        Nothing changes while one is being replaced already, or where nothing is to be sent.
        """
        if peer_id == self._players.parked:
            return
        player = self._players.find(peer_id)
        if player is self._players.present and player.is_settled:
            self._anew = True
            self._look_later()

    def end_peer(self, peer_id: str, reason: str) -> None:
        """End a peer connection. Raises UnknownPeer."""
        if peer_id == self._players.parked:
            self.close(reason)
        else:
            self._end_player(self._players.find(peer_id), reason)

    def hear(self, heard: Heard) -> None:
        """Take what the game engine says; what is about the players of others is passed over."""
        player = next((each for each in self._players if each.player_id == heard.player_id), None)
        if player is None:
            return
        if isinstance(heard, Offered):
            self._offered(player, heard.sdp)
        elif isinstance(heard, Found):
            player.found(heard)
        else:
            self._end_player(player, heard.reason)

    def _offered(self, player: Player, sdp: str) -> None:
        wanted = player.carried or self._streams.wanted()
        try:
            player.offered(sdp, wanted, self._clock())
        except UnusableDescription as error:
            self._end_player(player, str(error))
            return
        for lacking in set(wanted).difference(player.carried):
            self._lacking.add(lacking.kind)
            self._streams.end(self._streams[lacking.stream_id])

    def close(self, reason: str) -> None:
        """End everything; `reason` is a sentence for a person."""
        self._players.close(reason)
        self._due_at = None
        self._anew = False
        self._waiting_since = None
        self._lacking.clear()
        self._streams.end_all()
        self._streams.tell()

    def tick(self) -> None:
        """Look at deadlines, let players come and go, and tell what changed."""
        now = self._clock()
        for player in tuple(self._players):
            if player.expire(now):
                self._end_player(player, "it took too long")
        self._hand_over(now)
        present = self._players.present
        # Two offers at once would be one too many; but what nobody wants any more is not waited for.
        due = self._due_at is not None and now >= self._due_at
        if due and (present is None or present.is_settled or not self._streams.wanted()):
            self._renew(now)
        # That media arrives cannot be seen from here: a stream runs when both ends agreed on it and neither took that
        # back.
        self._streams.run(self._players.answered)
        self._streams.tell()

    def _hand_over(self, now: float) -> None:
        """Let a player go when the one that replaces it has had time to show something.

        What is suspended is not sent a moment longer than the rest needs.
        """
        present, replaced, suspended = self._players.present, self._players.replaced, self._streams.suspended()
        if replaced is None or present is None or present.answered_at is None:
            return
        if not suspended.isdisjoint(replaced.carried) or now - present.answered_at >= HANDOVER:
            self._players.drop_replaced(suspended)

    def _look_later(self) -> None:
        self._due_at = self._clock() + GATHERING

    def _renew(self, now: float) -> None:
        """Have the player that is wanted now."""
        self._due_at = None
        wanted, present = self._streams.wanted(), self._players.present
        if not self._streams:
            self.close("no stream is left to play")
        elif not wanted:
            self._anew = False
            self._waiting_since = None
            self._players.park(self._streams.suspended())
        elif present is None or self._anew or set(present.carried) != set(wanted):
            self._replace(now)

    def _replace(self, now: float) -> None:
        """Invite a new player in the place of the present one."""
        streamer = self._streamer()
        if streamer is None:
            self.close("the game engine is gone")
            return
        self._players.drop_replaced(self._streams.suspended())
        if not streamer.has_room:
            self._await_room(now)
            return
        player_id = secrets.token_hex(16)
        negotiation = Negotiation(self._mint(), self._players.peer_id)
        player = Player(player_id, negotiation, streamer, self._send, self._permits)
        self._players.add(player)
        self._waiting_since = None
        self._anew = False
        player.begin(now)
        streamer.invite(player_id, self.ice_servers)

    def _await_room(self, now: float) -> None:
        """A game engine that has no place for two players of one application may have one when the first has gone."""
        self._players.park(self._streams.suspended())
        self._anew = True
        self._look_later()
        if self._waiting_since is None:
            self._waiting_since = now
        elif now - self._waiting_since >= PREPARE_TIMEOUT:
            self.close("the game engine takes no further viewer")

    def _end_player(self, player: Player, reason: str) -> None:
        """A player has ended, or does so now; the one that it was to replace goes on with what it carries."""
        player.end(reason)
        was_present = player is self._players.present
        self._players.remove(player)
        if was_present:
            present = self._players.present
            self._streams.end_all(but=() if present is None else present.carried)
