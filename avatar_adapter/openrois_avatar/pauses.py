"""Whether a game engine has paused its pictures: nobody is shown what stands still because it is meant to."""

from openrois.aio.listeners import Listeners
from openrois_avatar.link.messages import Event, Pause

__all__ = ["Pauses"]


class Pauses:
    """The pause of the game engine that is connected. `changed` tells its beginning (True) and its end (False)."""

    def __init__(self) -> None:
        self.on = False
        self.changed: Listeners[bool] = Listeners()

    def take(self, event: Event) -> None:
        """Take an event of the game engine."""
        if isinstance(event, Pause):
            self._become(event.on)

    def clear(self) -> None:
        """The game engine is gone: what it wanted does not count any more."""
        self._become(False)

    def _become(self, on: bool) -> None:
        if on is not self.on:
            self.on = on
            self.changed.tell(on)
