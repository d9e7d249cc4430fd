"""Stops of remote components: one of each is on its way at a time, and requests made meanwhile share the next one."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress
from functools import partial

from openrois.aio.tasks import TaskScope
from openrois.commands.stop import STOP_TIMEOUT
from openrois.types.messages import Result

__all__ = ["SharedStops"]


class _Stop:
    """One `stop`, for all requests made before it was sent."""

    def __init__(self, command_id: str) -> None:
        self.command_id = command_id
        self.sent = asyncio.Event()
        self.answered = asyncio.Event()
        self.ended: asyncio.Future[tuple[Result, ...]] = asyncio.get_running_loop().create_future()
        self.sharers = 0
        self.task: asyncio.Task[None] | None = None

    def let_go(self) -> None:
        """Leave the wait for its end; without any waiter it is cancelled, unless it may still have to be sent."""
        if not self.sharers and self.answered.is_set() and self.task is not None:
            self.task.cancel()


class SharedStops:
    """The stops of the components behind one connection.

    A `stop` is sent however little room there is, so a flood of them could end the connection. Of one component the
    next is therefore sent when the other side has accepted the one before, or has not for `STOP_TIMEOUT`. It need not
    have ended: one that takes long, or for ever, keeps no other from being sent.

    Args:
        run: sends the `stop` of a component at once, if possible under the id that is its second argument, calls the
            third when that is accepted, and returns what it gave when it has ended.
        tasks: owns the stops, which are sent also when their callers are gone.
    """

    def __init__(
        self, run: Callable[[str, str, Callable[[], None]], Awaitable[tuple[Result, ...]]], tasks: TaskScope
    ) -> None:
        self._run = run
        self._tasks = tasks
        self._waiting: dict[str, _Stop] = {}
        self._on_its_way: dict[str, _Stop] = {}

    async def join(self, component_ref: str, command_id: str = "") -> tuple[Result, ...]:
        """Wait for the end of a `stop` that is sent from now on, and return what it gave.

        Args:
            component_ref: which component.
            command_id: what the application calls the command; of several that share one the first counts.

        Raises:
            RoISError: what `run` raised.
        """
        stop = self._waiting.get(component_ref)
        if stop is None:
            stop = _Stop(command_id)
            stop.task = self._tasks.start(self._carry_out(component_ref, stop))
            self._waiting[component_ref] = stop
        stop.sharers += 1
        try:
            return await asyncio.shield(stop.ended)
        finally:
            stop.sharers -= 1
            stop.let_go()

    async def sent(self, component_ref: str) -> None:
        """Wait until the `stop` is sent that waits for it now, if there is one: requests behind it stay behind it."""
        stop = self._waiting.get(component_ref)
        if stop is not None:
            await stop.sent.wait()

    async def _carry_out(self, component_ref: str, stop: _Stop) -> None:
        try:
            before = self._on_its_way.get(component_ref)
            if before is not None:
                with suppress(TimeoutError):
                    async with asyncio.timeout(STOP_TIMEOUT):
                        await before.answered.wait()
            del self._waiting[component_ref]
            self._on_its_way[component_ref] = stop
            stop.sent.set()
            answered = partial(self._answered, component_ref, stop)
            stop.ended.set_result(await self._run(component_ref, stop.command_id, answered))
        except Exception as error:
            stop.ended.set_exception(error)
            # All callers may be gone, and then the error stays unread.
            stop.ended.exception()
        finally:
            stop.ended.cancel()
            stop.sent.set()
            self._answered(component_ref, stop)
            if self._waiting.get(component_ref) is stop:
                del self._waiting[component_ref]

    def _answered(self, component_ref: str, stop: _Stop) -> None:
        stop.answered.set()
        if self._on_its_way.get(component_ref) is stop:
            del self._on_its_way[component_ref]
        stop.let_go()
