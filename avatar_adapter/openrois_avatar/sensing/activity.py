"""Whether a sense has to work: RoIS_Common and the subscriptions to its events decide."""

from collections.abc import Callable

from openrois.aio.listeners import Listeners

__all__ = ["Activity"]


class Activity:
    """Whether a sense has to work; in the beginning it has not.

    It works while somebody subscribes to one of its events, and from `start` to `stop` even if nobody does. `stop` ends
    it for those who subscribe now, too: the next `start` or the next subscription begins it again. `suspend` holds it
    until `resume`, `start` or `stop`, or until nobody wants it any more.
    """

    def __init__(self) -> None:
        self.changed: Listeners[bool] = Listeners()
        """Are told `works` when it is another one."""
        self._subscriptions: dict[str, int] = {}
        self._started = False
        self._stopped = False
        self._suspended = False
        self._worked = False

    @property
    def works(self) -> bool:
        """Whether the sense has to work now."""
        return self._wanted and not self._stopped and not self._suspended

    @property
    def _wanted(self) -> bool:
        return self._started or any(self._subscriptions.values())

    def while_working(self, begin: Callable[[], Callable[[], None]]) -> None:
        """Call `begin` whenever the sense begins to work, and what that returned when it ends."""
        ends: list[Callable[[], None]] = []
        self.changed.add(lambda works: ends.append(begin()) if works else ends.pop()())

    def start(self) -> None:
        """Work until `stop`, whoever subscribes."""
        self._started, self._stopped, self._suspended = True, False, False
        self._tell()

    def stop(self) -> None:
        """Work no more."""
        self._started, self._stopped, self._suspended = False, True, False
        self._tell()

    def suspend(self) -> None:
        """Pause; what nobody wants cannot be paused."""
        self._suspended = self._wanted
        self._tell()

    def resume(self) -> None:
        """Go on."""
        self._suspended = False
        self._tell()

    def subscribers_changed(self, event_type: str, number: int) -> None:
        """Take note of how many subscriptions to an event there are now."""
        if number > self._subscriptions.get(event_type, 0):
            self._stopped = False
        self._subscriptions[event_type] = number
        self._suspended = self._suspended and self._wanted
        self._tell()

    def _tell(self) -> None:
        if self.works != self._worked:
            self._worked = self.works
            self.changed.tell(self._worked)
