"""Waits for an engine at an address, starts it if it is to be started, and takes it through all checks."""

import asyncio
import os
import signal
from asyncio.subprocess import DEVNULL, Process
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from typing import Final

from openrois_avatar.check import judging
from openrois_avatar.check.acting import Patience, acting
from openrois_avatar.check.ending import END, ending
from openrois_avatar.check.finding import Finding, failed, passed
from openrois_avatar.check.line import Line
from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE
from openrois_avatar.link.listening import listening
from openrois_avatar.link.messages import Hello

__all__ = ["CannotStart", "Visit", "visiting"]

_WAITING: Final = 8
"""Connections that wait for their turn; the check looks at one after another."""
_BUFFER: Final = 4 << 20
_STANDARD_ERROR: Final = 2


class CannotStart(Exception):
    """The engine's command cannot be run; the text says why."""


class Visit:
    """A place at which an engine is awaited, and its process if it was started here; made by `visiting`."""

    def __init__(self, address: str, secret: str, patience: Patience) -> None:
        self.address = address
        self.hello: Hello | None = None
        """What the engine said of itself when it came."""
        self.start: Callable[[], Awaitable[Process]] | None = None
        """Starts its process, if the check is to."""
        self._program: Process | None = None
        self._secret = secret
        self._patience = patience
        self._lines: asyncio.Queue[Line] = asyncio.Queue(_WAITING)

    async def connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve a connection for as long as it lasts."""
        line = Line(reader, writer)
        try:
            self._lines.put_nowait(line)
        except asyncio.QueueFull:
            line.hang_up("too many connections wait")
        await line.read()

    async def findings(self) -> AsyncIterator[Finding]:
        """Check the engine that comes next, one thing after another.

        Raises:
            CannotStart: there is no such command.
        """
        if self.start is not None:
            self._program = await self.start()
        line = await self._next(self._patience.connect)
        if line is None:
            yield failed("connection", self._nobody(), "From the greeting to the end")
            return
        yield passed("connection", f"to {self.address}", END)
        fault = await self._greeting(line)
        if fault or line.hello is None:
            line.hang_up(fault)
            yield failed("greeting", fault, "JSON messages")
            return
        self.hello = line.hello
        yield passed("greeting", _told(line.hello), "JSON messages")
        async for finding in self._greeted(line, line.hello):
            yield finding
        line.hang_up("the check is over")

    async def _greeted(self, line: Line, hello: Hello) -> AsyncIterator[Finding]:
        await line.watch(self._patience.watch)
        for finding in judging.pictures(hello, line.seen.pictures, line.paused, line.opened):
            yield finding
        for finding in judging.sound(hello, line.seen.blocks):
            yield finding
        if not line.is_over():
            async for finding in acting(line, hello, self._patience):
                yield finding
                if line.is_over():
                    break
        if line.fault:
            yield failed("protocol", f"the connection was closed for a fault: {line.fault}", "Frames")
        elif line.is_over():
            yield failed("protocol", f"the connection ended before the checks did: {line.end}", END)
        else:
            yield judging.ring(hello, line.seen.pictures, given=line.ring is not None)
            async for finding in ending(line, self, self._patience):
                yield finding

    async def _greeting(self, line: Line) -> str:
        """Wait for HELLO and answer it; what is wrong, empty if nothing is."""
        if not await line.until(lambda: line.hello is not None, self._patience.greet):
            return line.fault or line.end or f"no HELLO came within {self._patience.greet:g} s"
        assert line.hello is not None, "it was waited for"
        if self._secret and line.hello.secret != self._secret:
            return "HELLO does not have the secret"
        line.welcome()
        return ""

    @property
    def was_started(self) -> bool:
        """Whether the check has started the engine."""
        return self._program is not None

    @property
    def status(self) -> int | None:
        """The exit status of its process, None while that runs, and where it was not started by the check."""
        return None if self._program is None else self._program.returncode

    async def ended(self, seconds: float) -> bool:
        """Wait so long at most until its process has ended; whether it has."""
        if self._program is not None:
            with suppress(TimeoutError):
                async with asyncio.timeout(seconds):
                    await self._program.wait()
        return self.status is not None

    async def again(self, seconds: float) -> Line | None:
        """Its next connection, greeted and welcome; None if none comes in time, or its process ends before."""
        line = await self._next(seconds)
        if line is not None and await self._greeting(line):
            return None
        return line

    async def anew(self) -> Line | None:
        """The connection of a new process of it."""
        assert self.start is not None, "only what was started can be started again"
        self._program = await self.start()
        return await self.again(self._patience.connect)

    async def _next(self, seconds: float) -> Line | None:
        """The next connection; None if none comes in time, or the engine's process ends before."""
        coming = asyncio.ensure_future(self._lines.get())
        ended = None if self._program is None else asyncio.ensure_future(self._program.wait())
        waiting: set[asyncio.Future[object]] = {coming}  # type: ignore[arg-type]
        if ended is not None:
            waiting.add(ended)  # type: ignore[arg-type]
        try:
            await asyncio.wait(waiting, timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
            return coming.result() if coming.done() else None
        finally:
            for each in waiting:
                each.cancel()

    def _nobody(self) -> str:
        if self._program is not None and self._program.returncode is not None:
            return f"the engine ended with status {self._program.returncode} before it connected"
        return f"no engine came to {self.address} within {self._patience.connect:g} s"


@asynccontextmanager
async def visiting(
    address: str | None, secret: str, command: Sequence[str], patience: Patience
) -> AsyncIterator[Visit]:
    """Listen at `address`, and run `command` if there is one, for as long as the context lasts.

    The command finds the address and the secret in its environment; what it prints goes to standard error.

    Raises:
        LinkError: one cannot listen there.
    """
    async with AsyncExitStack() as stack:
        listener, where = stack.enter_context(listening(address))
        visit = Visit(where, secret, patience)
        server = await asyncio.start_server(visit.connected, sock=listener, limit=_BUFFER)
        stack.callback(server.close)
        if command:
            visit.start = lambda: stack.enter_async_context(_running(command, where, secret))
        yield visit


@asynccontextmanager
async def _running(command: Sequence[str], address: str, secret: str) -> AsyncIterator[Process]:
    environment = {**os.environ, ADDRESS_VARIABLE: address, SECRET_VARIABLE: secret}
    try:
        process = await asyncio.create_subprocess_exec(
            *command, stdin=DEVNULL, stdout=_STANDARD_ERROR, env=environment, start_new_session=True
        )
    except OSError as error:
        raise CannotStart(f"{command[0]} cannot be started: {error.strerror}") from error
    try:
        yield process
    finally:
        # Its session is its own, so this reaches what it started too.
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()


def _told(hello: Hello) -> str:
    shape = hello.video
    sound = "no sound" if hello.audio_channels is None else f"sound in {hello.audio_channels} channels"
    can = [name for name in ("hears", "walks", "input", "ring") if getattr(hello, name)]
    return (
        f"{hello.name} {hello.version}: {shape.width}x{shape.height} {shape.format} at {shape.fps:g}, {sound}, "
        f"{len(hello.reactions)} reactions{''.join(f', {each}' for each in can)}"
    )
