"""The sessions of one application at other gateways: opened when it needs them, ended with its connection."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.errors import EngineUnreachable, RoISError
from openrois.federation.assertion import Assertion
from openrois.federation.counts import Counts
from openrois.federation.sub_session import SubSession, UnwritableParams
from openrois.jsonrpc.handler import InvalidParams
from openrois.transport.stream import MessageStream, StreamClosed

__all__ = ["PRINCIPAL", "SubSessions"]

_log = logging.getLogger(__name__)

PRINCIPAL: Final = "openrois.cluster.principal"
"""Notification to another gateway: the application has another principal from now on."""

_APPLICATION_LOST: Final = 1011

_HEARING_TIME: Final = 1.0
"""Seconds that an application waits for another gateway to hear what it says to all of them."""

Dial = Callable[[str, Assertion], Awaitable[MessageStream]]


class SubSessions:
    """The sub-sessions of one application, by gateway.

    Args:
        dial: returns a stream to a gateway; raises `EngineUnreachable`.
        tasks: owns what serves them.
        assertion: returns what is asserted of the application now.
        notify: sends the application a notification.
        seen: sees each notification, with its gateway, and tells whether it goes on.
        on_lost: called when a sub-session has ended, with it and the reason.
        counts: of what is asked over them.
    """

    def __init__(
        self,
        dial: Dial,
        tasks: TaskScope,
        assertion: Callable[[], Assertion],
        notify: Callable[..., None],
        seen: Callable[[str, str, Mapping[str, Any]], bool],
        on_lost: Callable[[SubSession, StreamClosed], None],
        counts: Counts,
    ) -> None:
        self._dial = dial
        self._tasks = tasks
        self._assertion = assertion
        self._notify = notify
        self._seen = seen
        self._on_lost = on_lost
        self._counts = counts
        self._open: dict[str, SubSession] = {}
        self._opening: dict[str, asyncio.Future[SubSession]] = {}
        self._said: dict[str, Mapping[str, Any]] = {}
        self._is_closed = False

    @property
    def open(self) -> tuple[SubSession, ...]:
        """Those that are open."""
        return tuple(self._open.values())

    async def say(self, method: str, params: Mapping[str, Any]) -> None:
        """Say something at the beginning of each sub-session from now on, and now to those that are open.

        Returns when these have heard it, so that the application gets what they notify from its reply on.
        """
        self._said[method] = params
        await asyncio.gather(*(_ask(sub, method, params) for sub in self.open))

    def says(self, method: str) -> bool:
        """Tell whether something is said at the beginning of each sub-session."""
        return method in self._said

    def unsay(self, method: str) -> None:
        """Say it no more."""
        self._said.pop(method, None)

    def send_notification(self, method: str, params: Mapping[str, Any]) -> None:
        """Send a notification over those that are open."""
        for sub in self.open:
            sub.send_notification(method, params)

    async def to(self, gateway_id: str) -> SubSession:
        """Return the sub-session at a gateway, which is opened where there is none.

        Raises:
            EngineUnreachable: the gateway is not reached, or refuses the application.
        """
        if (sub := self._open.get(gateway_id)) is not None:
            return sub
        opening = self._opening.get(gateway_id)
        if opening is None:
            opening = self._opening[gateway_id] = asyncio.get_running_loop().create_future()
            self._tasks.start(self._serve(gateway_id, opening))
        # What gives up waiting does not end what others wait for.
        return await asyncio.shield(opening)

    async def _serve(self, gateway_id: str, opening: "asyncio.Future[SubSession]") -> None:
        sub: SubSession | None = None
        closed = StreamClosed(1006)
        try:
            stream = await self._dial(gateway_id, self._assertion())
            sub = SubSession(gateway_id, stream, self._notify, partial(self._seen, gateway_id), self._counts)
            for method, params in self._said.items():
                sub.post(method, params)
            if self._is_closed:
                raise EngineUnreachable("the application has left")
            self._open[gateway_id] = sub
            _settle(opening, sub)
            closed = await sub.run()
        except Exception as error:
            if not opening.done():
                _settle(opening, error)
            else:
                _log.exception("a session at gateway %s failed", gateway_id)
        finally:
            self._opening.pop(gateway_id, None)
            if not opening.done():
                _settle(opening, EngineUnreachable(f"gateway {gateway_id} is not reached: this gateway stops"))
            if sub is not None:
                is_ours = self._open.pop(gateway_id, None) is sub
                await sub.close()
                if is_ours and not self._is_closed:
                    self._on_lost(sub, closed)

    async def close(self, *, lost: bool) -> None:
        """End all of them.

        Args:
            lost: the connection of the application was lost: what it holds may be kept for a while.
        """
        self._is_closed = True
        subs = self.open
        self._open.clear()
        code, reason = (_APPLICATION_LOST, "the application is lost") if lost else (1000, "")
        await asyncio.gather(*(sub.close(code, reason) for sub in subs))


async def _ask(sub: SubSession, method: str, params: Mapping[str, Any]) -> None:
    with suppress(RoISError, InvalidParams, UnwritableParams):
        await sub.ask(method, params, timeout=_HEARING_TIME, urgent=True)


def _settle(opening: "asyncio.Future[SubSession]", outcome: SubSession | Exception) -> None:
    if opening.done():
        return
    if isinstance(outcome, SubSession):
        opening.set_result(outcome)
    else:
        opening.set_exception(outcome)
        # All that waited may be gone, and then the error stays unread.
        opening.exception()
