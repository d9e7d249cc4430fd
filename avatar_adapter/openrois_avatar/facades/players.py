"""The players of one application: the present one, the one that it replaces, and a parked peer connection. Pure."""

from collections.abc import Callable, Collection, Iterator

from openrois_signaling.messages import Bye, Downward
from openrois_streaming.errors import UnknownPeer

from openrois_avatar.facades.player import Carried, Player

__all__ = ["Players"]


class Players:
    """At most two players, of which one replaces the other.

    Attributes:
        present: the player that carries the streams; None while none is to play.
        replaced: the one before it, until the present one has had time to show a picture.
        parked: the peer connection that the application keeps without a player; empty for none.

    Args:
        send: sends the application a message.
    """

    def __init__(self, send: Callable[[Downward], None]) -> None:
        self._send = send
        self.present: Player | None = None
        self.replaced: Player | None = None
        self.parked = ""

    def __iter__(self) -> Iterator[Player]:
        """Return the players that have not ended, the present one first."""
        return iter([player for player in (self.present, self.replaced) if player is not None])

    @property
    def peer_id(self) -> str | None:
        """The peer connection that a new player replaces."""
        return self.present.peer_id if self.present is not None else self.parked or None

    @property
    def answered(self) -> frozenset[Carried]:
        """The streams of the players that were answered."""
        return frozenset(each for player in self if player.answered_at is not None for each in player.carried)

    def find(self, peer_id: str) -> Player:
        """Return the player with this peer id. Raises UnknownPeer."""
        for player in self:
            if player.peer_id == peer_id:
                return player
        raise UnknownPeer("the peer connection does not exist, or has ended")

    def add(self, player: Player) -> None:
        """Replace the present player by a new one."""
        self.present, self.replaced = player, self.present
        self.parked = ""

    def remove(self, player: Player) -> None:
        """Remove a player that has ended; the one that it should replace goes on."""
        if player is self.present:
            self.present = self.replaced
        self.replaced = None

    def drop_replaced(self, suspended: Collection[Carried]) -> None:
        """End the replaced player.

        Where it carried streams that are suspended now, the application keeps its peer connection, and with it the last
        picture: a bye would mean that these streams have ended.
        """
        player, self.replaced = self.replaced, None
        if player is None:
            return
        if set(suspended).isdisjoint(player.carried):
            player.close("it was replaced")
        else:
            player.leave()

    def park(self, suspended: Collection[Carried]) -> None:
        """End all players for the game engine; the application keeps its peer connection."""
        self.drop_replaced(suspended)
        if self.present is not None:
            self.parked = self.present.peer_id
            self.present.leave()
            self.present = None

    def close(self, reason: str) -> None:
        """End all players."""
        for player in self:
            player.close(reason)
        if self.parked:
            self._send(Bye(peer_id=self.parked, reason=reason))
        self.present = self.replaced = None
        self.parked = ""
