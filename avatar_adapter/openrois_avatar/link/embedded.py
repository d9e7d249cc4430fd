"""An embedded game engine: a child process that is restarted when it dies, and ended with the adapter."""

from __future__ import annotations

import asyncio
import logging
from asyncio.subprocess import Process
from collections.abc import Callable, Coroutine
from contextlib import AsyncExitStack, suppress
from typing import Any, Final, NoReturn, Self

from openrois_body.processes.child import Output, child_process, ended_within
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.source.source import RawAudio

from openrois.transport.backoff import Backoff
from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE
from openrois_avatar.link.connection import EngineConnection
from openrois_avatar.link.linked_engine import LinkedEngine
from openrois_avatar.link.messages import Event, Hello, LinkError, Quit
from openrois_avatar.link.receivers import notify

START_TIMEOUT: Final = 20.0
"""Seconds from the start of the process to its HELLO; Panda3D on a cold disk needs a few."""
QUIT_TIMEOUT: Final = 0.8
"""Seconds that an engine has to exit after `Quit`; then come SIGTERM and, 0.5 s later, SIGKILL."""
FIRST_DELAY: Final = 0.5
LONGEST_DELAY: Final = 10.0
"""Seconds before a new start; the delay doubles from the first to the longest."""

_log = logging.getLogger(__name__)


class EmbeddedEngine(LinkedEngine):
    """`python -m module` as a game engine on the engine link, for as long as the context lasts.

    When it dies or hangs it is started again, and its pictures and sound go on; `on_lost` and `on_back` report that.
    Entering waits for the first HELLO; leaving takes 1.3 s at most.

    Args:
        module: the engine's module.
        arguments: its arguments.
        address: where it is listened for, as `LinkServer.listen` has it; a private Unix socket if not given.
        on_audio: gets its blocks of sound.
        on_event: gets its events.
        on_lost: called with the reason when the engine is disconnected.
        on_back: called with its HELLO when it is connected again.
        clock: the media clock; the machine's if not given.
        start_timeout: seconds that it has for its HELLO.

    Raises:
        LinkError: on entering: the engine ended, or sent no HELLO in time; the text has its last output.
    """

    def __init__(
        self,
        module: str,
        *arguments: str,
        address: str | None = None,
        on_audio: Callable[[RawAudio], None] | None = None,
        on_event: Callable[[Event], None] | None = None,
        on_lost: Callable[[str], None] | None = None,
        on_back: Callable[[Hello], None] | None = None,
        clock: MediaClock | None = None,
        start_timeout: float = START_TIMEOUT,
    ) -> None:
        super().__init__(address, None, on_audio=on_audio, on_event=on_event, clock=clock or SystemClock())
        self._module = module
        self._arguments = arguments
        self._on_lost = on_lost
        self._on_back = on_back
        self._start_timeout = start_timeout
        self._ready = asyncio.Event()

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            self._server = await stack.enter_async_context(self._listening)
            running = asyncio.create_task(self._keep_running(), name=f"engine {self._module}")
            stack.push_async_callback(_stop, running)
            await _first(running, self._ready.wait())
            if running.done():
                running.result()
            self._stack = stack.pop_all()
        return self

    async def _keep_running(self) -> None:
        backoff = Backoff(FIRST_DELAY, 2.0, LONGEST_DELAY)
        while True:
            started = self._clock.now()
            try:
                await self._live()
            except (LinkError, OSError) as error:  # OSError: the process could not be started
                if not self._ready.is_set():
                    raise
                delay = backoff.after(self._clock.now() - started)
                _log.warning("%s; it is started again in %.1f s", error, delay)
            await self._clock.sleep_until(self._clock.now() + delay)

    async def _live(self) -> NoReturn:
        """Run the engine's process once; always ends with a `LinkError` that says how."""
        output = Output(self._module, self._clock)
        environment = {ADDRESS_VARIABLE: self._server.address, SECRET_VARIABLE: self._server.secret}
        running = child_process(self._module, *self._arguments, output=output, environment=environment)
        end = "sent no HELLO"
        async with running as process:
            connection = await self._greeting(process)
            if connection is not None:
                await self._serve(connection, process)
                end = "has ended"
        words = output.last_words or "it printed nothing"
        raise LinkError(f"{self._module} {end} (status {process.returncode}): {words}; the log has its output")

    async def _greeting(self, process: Process) -> EngineConnection | None:
        """Return the engine's connection; None if it does not come in time, or the process ends before."""
        arrival = asyncio.create_task(self._server.accept())
        try:
            await _first(arrival, process.wait(), self._clock.sleep_until(self._clock.now() + self._start_timeout))
            return arrival.result() if arrival.done() else None
        finally:
            arrival.cancel()

    async def _serve(self, connection: EngineConnection, process: Process) -> None:
        if self._ready.is_set():
            notify(self._on_back, connection.hello)
        self._ready.set()
        try:
            await _first(connection.closed(), process.wait(), self._hang())
        finally:
            await _farewell(connection, process)
        notify(self._on_lost, await connection.closed())

    async def _hang(self) -> None:
        await self._stall(self._start_timeout)
        _log.warning("%s has sent no picture for a while", self._module)


async def _first(*things: Coroutine[Any, Any, object] | asyncio.Task[Any]) -> None:
    """Wait until the first of `things` is done or has failed. Coroutines are cancelled then; tasks go on."""
    tasks = [thing if isinstance(thing, asyncio.Task) else asyncio.create_task(thing) for thing in things]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for thing, task in zip(things, tasks, strict=True):
            if thing is not task:
                task.cancel()


async def _farewell(connection: EngineConnection, process: Process) -> None:
    """Let a running engine exit, and read the last messages of one that has ended."""
    if connection.connected and process.returncode is None:
        connection.send_command(Quit())
        await ended_within(process, QUIT_TIMEOUT)
    if process.returncode is not None:
        with suppress(TimeoutError):
            async with asyncio.timeout(QUIT_TIMEOUT):
                await connection.closed()
    connection.abort("the engine does not respond")


async def _stop(task: asyncio.Task[None]) -> None:
    task.cancel()
    await asyncio.wait({task})
    error = None if task.cancelled() else task.exception()
    if error is not None and not isinstance(error, LinkError):  # a LinkError was raised on entering
        _log.error("%s failed", task.get_name(), exc_info=error)
