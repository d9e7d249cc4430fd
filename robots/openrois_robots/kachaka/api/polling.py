"""Long polls of one state of the robot: each answer has a cursor, and the next one comes when the state has changed."""

from typing import Any, Final

from openrois_streaming.clock import MediaClock

from openrois_robots.kachaka.api.calls import KachakaApi, RobotSilent, get_request

__all__ = ["Poll"]

_PAUSE: Final = 0.1
"""Seconds until the next request, where an answer has brought no other cursor: a robot that does not wait for changes
would be asked without an end."""


class Poll:
    """The changes of one state.

    Args:
        api: of the robot.
        method: that returns the state.
        clock: the media clock.
        wait: seconds that a request waits for a change. Then the state is asked for without a cursor: a robot that was
            restarted may count from the beginning again, and the old cursor would be waited for for ever.
    """

    def __init__(self, api: KachakaApi, method: str, clock: MediaClock, wait: float = 1.0) -> None:
        self._api = api
        self._method = method
        self._clock = clock
        self._wait = wait
        self._cursor = 0
        self._known: int | None = None

    def restart(self) -> None:
        """Ask for the present state next."""
        self._cursor, self._known = 0, None

    async def next(self) -> Any:
        """Return the next state that has a cursor of its own: the present one at first.

        Raises:
            RobotSilent: the robot does not even answer with the present state.
            RoISError: the call failed, as `KachakaApi.call` says.
        """
        while True:
            try:
                response = await self._api.call(self._method, get_request(self._cursor), deadline=self._deadline)
            except RobotSilent:
                if not self._cursor:
                    raise
                self._cursor = 0
                continue
            cursor = response.metadata.cursor
            self._cursor = cursor
            if cursor != self._known:
                self._known = cursor
                return response
            await self._clock.sleep_until(self._clock.now() + _PAUSE)
            if not cursor:
                # Without a cursor the robot does not tell whether it is news.
                return response

    @property
    def _deadline(self) -> float:
        return self._wait if self._cursor else max(1.0, self._wait)
