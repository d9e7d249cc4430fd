"""The players behind one application: the present one, the one that it replaces, and what is left of one. Pure."""

from collections.abc import Callable, Collection, Iterator

from openrois_signaling.messages import Bye, Downward
from openrois_streaming.errors import UnknownPeer

from openrois_avatar.facades.player import Carried, Player

__all__ = ["Players"]


class Players:
    """At most two players, of which one takes the place of the other.

    Attributes:
        present: the one that offers are made to; None while nothing is to be sent.
        replaced: the one before it, until that has had time to show something.
        parked: the peer connection that the application keeps while no player is behind it; empty for none.

    Args:
        send: sends the application a message.
    """

    def __init__(self, send: Callable[[Downward], None]) -> None:
        self._send = send
        self.present: Player | None = None
        self.replaced: Player | None = None
        self.parked = ""

    def __iter__(self) -> Iterator[Player]:
        """Those that have not ended, the present one first."""
        return iter([player for player in (self.present, self.replaced) if player is not None])

    @property
    def peer_id(self) -> str | None:
        """The peer connection that a new player replaces."""
        return self.present.peer_id if self.present is not None else self.parked or None

    @property
    def answered(self) -> frozenset[Carried]:
        """What is carried by those that both ends have agreed on."""
        return frozenset(each for player in self if player.answered_at is not None for each in player.carried)

    def find(self, peer_id: str) -> Player:
        """The player that the application knows by this id. Raises UnknownPeer."""
        for player in self:
            if player.peer_id == peer_id:
                return player
        raise UnknownPeer("there is no such peer connection")

    def add(self, player: Player) -> None:
        """A new one takes the place of the present one."""
        self.present, self.replaced = player, self.present
        self.parked = ""

    def remove(self, player: Player) -> None:
        """One has ended; the one that it was to replace goes on."""
        if player is self.present:
            self.present = self.replaced
        self.replaced = None

    def drop_replaced(self, suspended: Collection[Carried]) -> None:
        """Let the one go that was replaced.

        Where it carried what is suspended now, the application keeps its end, and with it the last picture: to say bye
        would be to say that these streams are over.
        """
        player, self.replaced = self.replaced, None
        if player is None:
            return
        if set(suspended).isdisjoint(player.carried):
            player.end("it was replaced")
        else:
            player.leave()

    def park(self, suspended: Collection[Carried]) -> None:
        """Nothing is to be sent: the game engine lets its players go, and the application keeps its end."""
        self.drop_replaced(suspended)
        if self.present is not None:
            self.parked = self.present.peer_id
            self.present.leave()
            self.present = None

    def close(self, reason: str) -> None:
        """End them all."""
        for player in self:
            player.end(reason)
        if self.parked:
            self._send(Bye(peer_id=self.parked, reason=reason))
        self.present = self.replaced = None
        self.parked = ""
