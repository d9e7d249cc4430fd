"""The activity of a sense, by RoIS_Common and the subscriptions to its events."""

from collections.abc import Callable

from openrois.aio.listeners import Listeners

__all__ = ["Activity"]


class Activity:
    """Whether a sense is active; at first it is not.

    It is active while there is a subscription to one of its events, and from `start` to `stop` even without one. `stop`
    ends it despite present subscriptions: the next `start` or the next subscription begins it again. `suspend` pauses
    it until `resume`, `start` or `stop`, or until neither `start` nor a subscription is left.
    """

    def __init__(self) -> None:
        self.changed: Listeners[bool] = Listeners()
        """Called with `works` when that has changed."""
        self._subscriptions: dict[str, int] = {}
        self._started = False
        self._stopped = False
        self._suspended = False
        self._worked = False

    @property
    def works(self) -> bool:
        """Whether the sense is active now."""
        return self._wanted and not self._stopped and not self._suspended

    @property
    def _wanted(self) -> bool:
        return self._started or any(self._subscriptions.values())

    def while_working(self, begin: Callable[[], Callable[[], None]]) -> None:
        """Call `begin` whenever the sense becomes active, and what it returned when the sense becomes inactive."""
        ends: list[Callable[[], None]] = []
        self.changed.add(lambda works: ends.append(begin()) if works else ends.pop()())

    def start(self) -> None:
        """Activate until `stop`, with or without subscriptions."""
        self._started, self._stopped, self._suspended = True, False, False
        self._notify_change()

    def stop(self) -> None:
        """Deactivate until the next `start` or the next subscription."""
        self._started, self._stopped, self._suspended = False, True, False
        self._notify_change()

    def suspend(self) -> None:
        """Pause, if the sense is wanted at all."""
        self._suspended = self._wanted
        self._notify_change()

    def resume(self) -> None:
        """Go on."""
        self._suspended = False
        self._notify_change()

    def subscribers_changed(self, event_type: str, number: int) -> None:
        """Note the present number of subscriptions to an event."""
        if number > self._subscriptions.get(event_type, 0):
            self._stopped = False
        self._subscriptions[event_type] = number
        self._suspended = self._suspended and self._wanted
        self._notify_change()

    def _notify_change(self) -> None:
        if self.works != self._worked:
            self._worked = self.works
            self.changed.notify_all(self._worked)
