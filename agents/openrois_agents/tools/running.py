"""Runs a command for one call of a tool: reports that it runs, and stops it when the call ends before it does."""

import asyncio
import json
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.client import Command, ComponentProxy, ConnectionLost, RoISError, RpcError, Step, TimedOut
from openrois_agents.tools.untrusted import plain_text

__all__ = ["News", "Progress", "Runner"]

_log = logging.getLogger(__name__)

Progress = Callable[[float, str], Awaitable[None]]
"""Reports how many seconds a call has taken so far, and what it does."""

News = tuple[ComponentProxy, str]
"""A component, and an event of it that is reported while a command runs."""

MAX_RUN: Final = 600.0
"""Seconds that a command of a tool may take; then it is stopped."""

_REPORT: Final = 1.0
"""Seconds between two reports that a command runs."""

_STOP: Final = 5.0
"""Seconds for which a `stop` is tried again when there is no connection."""

_RETRY: Final = 0.2

_NEWS: Final = 200
"""Characters of an event that is reported."""


class Runner:
    """Runs commands of one body, of one component one at a time.

    Args:
        tasks: own what has to be finished after a call was cancelled.
        clock: monotonic seconds.
    """

    def __init__(self, tasks: TaskScope, clock: Callable[[], float]) -> None:
        self._tasks = tasks
        self._clock = clock
        self._turns: dict[str, asyncio.Lock] = {}
        self._running: dict[str, ComponentProxy] = {}
        self._stops: dict[str, asyncio.Task[None]] = {}

    async def run(
        self,
        component: ComponentProxy,
        command: str,
        progress: Progress,
        *,
        parameters: dict[str, Any] | None = None,
        arguments: dict[str, Any] | None = None,
        seconds: float = MAX_RUN,
        news: News | None = None,
    ) -> dict[str, Any]:
        """Set parameters and run a command to its end; return its results.

        Where that fails or is cancelled before the command has ended, the component is stopped.

        Args:
            component: runs it; it is bound.
            command: its name.
            progress: is told about once a second that it runs.
            parameters: set before it begins.
            arguments: of the command.
            seconds: that it may take.
            news: a component with an event that is reported while it runs.

        Raises:
            RoISError: it was refused, or it failed.
            TimedOut: it took too long, and was stopped.
        """
        async with self._turns.setdefault(component.component_ref, asyncio.Lock()):
            if (stop := self._stops.pop(component.component_ref, None)) is not None:
                # It would end what is begun now.
                await asyncio.wait({stop})
            if parameters:
                await component.set_parameter(**parameters)
            async with self._stopping(component) as begun:
                running = await component.command(command, **(arguments or {})).execute()
                begun.append(running)
                await self._follow(component.component_ref, running, progress, seconds, news)
                return await running

    @asynccontextmanager
    async def _stopping(self, component: ComponentProxy) -> AsyncIterator[list[Command[Any]]]:
        """Stop the component where the block is left before the command that it began has ended."""
        begun: list[Command[Any]] = []
        self._running[component.component_ref] = component
        try:
            yield begun
        except BaseException as error:
            if not _has_ended(begun, error):
                # A call that is cancelled cannot wait for it: the next one does.
                self._stops[component.component_ref] = self._tasks.start(_stop(component))
            raise
        finally:
            del self._running[component.component_ref]

    async def stop_all(self) -> None:
        """Stop every component that runs a command of these tools."""
        await asyncio.gather(*map(_stop, tuple(self._running.values())))
        if stops := tuple(self._stops.values()):
            await asyncio.wait(stops)

    async def _follow(
        self,
        component_ref: str,
        running: Command[Any],
        progress: Progress,
        seconds: float,
        news: News | None,
    ) -> None:
        """Report until the command has ended."""
        began = self._clock()
        latest = [f"{running.command_type} of {component_ref} runs"]
        async with TaskScope() as tasks:
            ended = tasks.start(running.wait())
            if news is not None:
                tasks.start(_read_news(*news, latest))
            while not ended.done():
                passed = self._clock() - began
                if passed >= seconds:
                    raise TimedOut(f"{running!r} took longer than {seconds:g} s and was stopped")
                with suppress(TimeoutError):
                    # A host that does not read holds nothing up.
                    async with asyncio.timeout(_REPORT):
                        await progress(passed, latest[-1])
                await asyncio.wait({ended}, timeout=min(_REPORT, seconds - passed))


def _has_ended(begun: list[Command[Any]], error: BaseException) -> bool:
    """Tell whether nothing runs any more: the command has ended, or was refused."""
    if begun:
        return begun[0].status is not None
    return isinstance(error, RoISError) and not isinstance(error, TimedOut)


async def _stop(component: ComponentProxy) -> None:
    """Stop a component, also where the connection to the gateway is being made again."""
    try:
        async with asyncio.timeout(_STOP):
            while True:
                try:
                    step: Step[dict[str, Any]] = component.command("stop")
                    await step
                except ConnectionLost:
                    await asyncio.sleep(_RETRY)
                else:
                    return
    except (RoISError, RpcError, TimeoutError) as error:
        _log.warning("%s could not be stopped: %s", component.component_ref, error or "no answer")


async def _read_news(component: ComponentProxy, event: str, latest: list[str]) -> None:
    """Keep the newest occurrence of an event as the text that is reported."""
    with suppress(RoISError, RpcError, ConnectionLost, TimeoutError):
        async with component.event(event) as occurrences:
            async for data in occurrences:
                told = json.dumps(plain_text(data), ensure_ascii=False)
                latest[:] = [f"{event} of {component.component_ref}: {told[:_NEWS]}"]
