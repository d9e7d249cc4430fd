"""The streams of one application from a game engine that does WebRTC itself, over one player at a time. Pure.

The game engine decides once what a player is sent. So a player carries exactly the streams that play; whenever these
change, a new player replaces the last one, which stays until the new one has had time to show a picture. A suspended
stream has no player at all: nothing of it is sent.
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
from openrois_avatar.facades.session_streams import Change, SessionStreams
from openrois_avatar.facades.streamer import Found, Heard, NoRoom, NotOffered, Offered, Streamer

__all__ = ["GATHERING", "HANDOVER", "FacadeSession"]

GATHERING: Final = 0.1
"""Seconds without a further change after which a player is invited, so that two connected streams get one player."""

HANDOVER: Final = 5.0
"""Seconds that a player is kept after its successor was answered."""


class FacadeSession:
    """The streams of one application.

    `tick` has to be called several times a second: all notifications are sent from there, or on a message of the game
    engine, and not from within the methods that handle a request; but `apply_answer` may send bye.

    Args:
        mint: makes a new peer id.
        streamer: returns the game engine, if one is connected.
        send: sends the application a message.
        changed: called with every change of a stream's status.
        clock: monotonic seconds.
        permits: returns whether a candidate of the application may be used; raises InvalidCandidate for a malformed
            one.
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
        self._streams = SessionStreams(changed)
        self._players = Players(send)
        self._made_at = clock()
        self._was_answered = False
        self._lacking: set[MediaKind] = set()
        """The kinds that the game engine has not offered, until it disconnects."""
        self._due_at: float | None = None
        """When the present player has to be compared with the wanted streams; None without a change."""
        self._anew = False
        """Whether a new player is wanted, even for the same streams."""
        self._waiting_since: float | None = None
        """Since when the game engine has no room for a player."""

    @property
    def is_over(self) -> bool:
        """Whether there are neither streams nor peer connections."""
        return self._streams.is_over and self._players.peer_id is None

    def unanswered_for(self) -> float | None:
        """Return the seconds since the application came without an answer; None after its first answer."""
        return None if self._was_answered else self._clock() - self._made_at

    def connect(self, stream_id: str, component_ref: str, kind: MediaKind) -> None:
        """Add a stream; an offer follows.

        Raises:
            NotOffered: the game engine does not offer such streams.
            TooManySections: there is one of this kind already.
            NoRoom: the game engine takes no further player.
        """
        if kind in self._lacking:
            raise NotOffered(f"the game engine sends no {kind}")
        if self._streams.has(kind):
            raise TooManySections(
                f"a {kind} stream is connected already, and the game engine sends one; disconnect it first"
            )
        streamer = self._streamer()
        if streamer is None or (self.is_over and not streamer.has_room):
            raise NoRoom("the game engine takes no further viewer now; try again later")
        self._streams.add(Carried(stream_id, component_ref, kind))
        self._check_later()

    def suspend(self, stream_id: str) -> None:
        """Suspend a stream. Suspending twice is allowed. Raises UnknownStream."""
        self._streams.suspend(stream_id)
        self._check_later()

    def resume(self, stream_id: str) -> None:
        """Resume a stream; an offer follows. Resuming twice is allowed. Raises UnknownStream."""
        self._streams.resume(stream_id)
        self._check_later()

    def disconnect(self, stream_id: str) -> None:
        """End a stream. Raises UnknownStream."""
        self._streams.end_stream(self._streams[stream_id])
        self._check_later()

    def status(self, stream_id: str) -> StreamStatus:
        """Return the status of a stream. Raises UnknownStream."""
        return self._streams[stream_id].status

    def apply_answer(self, answer: Answer) -> None:
        """Apply an answer. Raises UnknownPeer, UnexpectedAnswer, InvalidDescription."""
        player = self._players.find(answer.peer_id)
        try:
            player.apply_answer(answer, self._clock())
        except (InvalidDescription, UnusableDescription) as error:
            self._end_player(player, str(error))
            raise InvalidDescription(str(error)) from error
        self._was_answered = True

    def add_candidate(self, candidate: Candidate) -> None:
        """Handle a candidate. Raises UnknownPeer, StaleGeneration, TooManyCandidates, InvalidCandidate."""
        self._players.find(candidate.peer_id).add_candidate(candidate)

    def restart(self, peer_id: str) -> None:
        """Replace this player by another one; an offer follows. Raises UnknownPeer.

        Nothing changes during a replacement, or where no stream is to play.
        """
        if peer_id == self._players.parked:
            return
        player = self._players.find(peer_id)
        if player is self._players.present and player.is_settled:
            self._anew = True
            self._check_later()

    def end_peer(self, peer_id: str, reason: str) -> None:
        """End a peer connection. Raises UnknownPeer."""
        if peer_id == self._players.parked:
            self.close(reason)
        else:
            self._end_player(self._players.find(peer_id), reason)

    def handle_engine_message(self, heard: Heard) -> None:
        """Handle a message of the game engine; messages about players of other applications are ignored."""
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
            self._streams.end_stream(self._streams[lacking.stream_id])

    def close(self, reason: str) -> None:
        """End everything; `reason` is a sentence for a person."""
        self._players.close(reason)
        self._due_at = None
        self._anew = False
        self._waiting_since = None
        self._lacking.clear()
        self._streams.end_all()
        self._streams.notify_changes()

    def tick(self) -> None:
        """Check deadlines, invite and end players, and send notifications of changes."""
        now = self._clock()
        for player in tuple(self._players):
            if player.expire(now):
                self._end_player(player, "it took too long")
        self._hand_over(now)
        present = self._players.present
        # Two offers at once are not possible; but an offer without wanted streams is not waited for.
        due = self._due_at is not None and now >= self._due_at
        if due and (present is None or present.is_settled or not self._streams.wanted()):
            self._renew(now)
        # The arrival of media cannot be observed here: a stream is running while both ends agree on it.
        self._streams.run(self._players.answered)
        self._streams.notify_changes()

    def _hand_over(self, now: float) -> None:
        """End the replaced player when its successor has had time to show a picture.

        A suspended stream ends it at once.
        """
        present, replaced, suspended = self._players.present, self._players.replaced, self._streams.suspended()
        if replaced is None or present is None or present.answered_at is None:
            return
        if not suspended.isdisjoint(replaced.carried) or now - present.answered_at >= HANDOVER:
            self._players.drop_replaced(suspended)

    def _check_later(self) -> None:
        self._due_at = self._clock() + GATHERING

    def _renew(self, now: float) -> None:
        """Adapt the player to the wanted streams."""
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
        """Invite a new player to replace the present one."""
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
        """End the present player first, for a game engine without room for two players of one application."""
        self._players.park(self._streams.suspended())
        self._anew = True
        self._check_later()
        if self._waiting_since is None:
            self._waiting_since = now
        elif now - self._waiting_since >= PREPARE_TIMEOUT:
            self.close("the game engine takes no further viewer")

    def _end_player(self, player: Player, reason: str) -> None:
        """End a player; the one that it should replace goes on with its streams."""
        player.close(reason)
        was_present = player is self._players.present
        self._players.remove(player)
        if was_present:
            present = self._players.present
            self._streams.end_all(but=() if present is None else present.carried)
