"""A check session: awaits an engine at an address, starts its command if there is one, and runs all checks."""

import asyncio
import os
import signal
from asyncio.subprocess import DEVNULL, Process
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from typing import Final

from openrois_avatar.check import media_checks
from openrois_avatar.check.command_checks import Patience, check_commands
from openrois_avatar.check.connection import CheckedConnection
from openrois_avatar.check.finding import Finding, failed, passed
from openrois_avatar.check.shutdown_checks import END, check_shutdown
from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE
from openrois_avatar.link.listening import listening
from openrois_avatar.link.messages import Hello

__all__ = ["CannotStart", "CheckSession", "check_session"]

_WAITING: Final = 8
"""Connections that may wait for their turn."""
_BUFFER: Final = 4 << 20
_STANDARD_ERROR: Final = 2


class CannotStart(Exception):
    """A command that cannot be run; the text says why."""


class CheckSession:
    """The session with one engine, and its process if the check started it; made by `check_session`."""

    def __init__(self, address: str, secret: str, patience: Patience) -> None:
        self.address = address
        self.hello: Hello | None = None
        """The engine's HELLO."""
        self.start: Callable[[], Awaitable[Process]] | None = None
        """Starts the engine's process, if there is a command."""
        self._program: Process | None = None
        self._secret = secret
        self._patience = patience
        self._lines: asyncio.Queue[CheckedConnection] = asyncio.Queue(_WAITING)

    async def connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve a connection for as long as it lasts."""
        connection = CheckedConnection(reader, writer)
        try:
            self._lines.put_nowait(connection)
        except asyncio.QueueFull:
            connection.hang_up("too many connections wait")
        await connection.read()

    async def findings(self) -> AsyncIterator[Finding]:
        """Run all checks on the engine that connects next.

        Raises:
            CannotStart: the command cannot be run.
        """
        if self.start is not None:
            self._program = await self.start()
        connection = await self._next(self._patience.connect)
        if connection is None:
            yield failed("connection", self._missing_reason(), "From the greeting to the end")
            return
        yield passed("connection", f"to {self.address}", END)
        fault = await self._greeting(connection)
        if fault or connection.hello is None:
            connection.hang_up(fault)
            yield failed("greeting", fault, "JSON messages")
            return
        self.hello = connection.hello
        yield passed("greeting", _told(connection.hello), "JSON messages")
        async for finding in self._greeted(connection, connection.hello):
            yield finding
        connection.hang_up("the check is over")

    async def _greeted(self, connection: CheckedConnection, hello: Hello) -> AsyncIterator[Finding]:
        await connection.watch(self._patience.watch)
        for finding in media_checks.check_pictures(
            hello, connection.record.pictures, connection.paused, connection.opened
        ):
            yield finding
        for finding in media_checks.check_sound(hello, connection.record.blocks):
            yield finding
        if not connection.is_over():
            async for finding in check_commands(connection, hello, self._patience):
                yield finding
                if connection.is_over():
                    break
        if connection.fault:
            yield failed("protocol", f"the connection was closed for a fault: {connection.fault}", "Frames")
        elif connection.is_over():
            yield failed("protocol", f"the connection ended before the checks did: {connection.end}", END)
        else:
            yield media_checks.check_ring(hello, connection.record.pictures, given=connection.ring is not None)
            async for finding in check_shutdown(connection, self, self._patience):
                yield finding

    async def _greeting(self, connection: CheckedConnection) -> str:
        """Wait for HELLO and answer it; return the fault, empty if there is none."""
        if not await connection.until(lambda: connection.hello is not None, self._patience.greet):
            return connection.fault or connection.end or f"no HELLO came within {self._patience.greet:g} s"
        assert connection.hello is not None, "HELLO was awaited"
        if self._secret and connection.hello.secret != self._secret:
            return "HELLO does not have the secret"
        connection.welcome()
        return ""

    @property
    def was_started(self) -> bool:
        """Whether the check has started the engine's process."""
        return self._program is not None

    @property
    def status(self) -> int | None:
        """The exit status of its process, None while that runs, and where it was not started by the check."""
        return None if self._program is None else self._program.returncode

    async def ended(self, seconds: float) -> bool:
        """Wait until its process has ended, `seconds` at most; return whether it has."""
        if self._program is not None:
            with suppress(TimeoutError):
                async with asyncio.timeout(seconds):
                    await self._program.wait()
        return self.status is not None

    async def again(self, seconds: float) -> CheckedConnection | None:
        """Return its next connection after HELLO and WELCOME; None if none comes in time, or its process ends."""
        connection = await self._next(seconds)
        if connection is not None and await self._greeting(connection):
            return None
        return connection

    async def anew(self) -> CheckedConnection | None:
        """Start its process again, and return the new connection."""
        assert self.start is not None, "only a process of the check can be started again"
        self._program = await self.start()
        return await self.again(self._patience.connect)

    async def _next(self, seconds: float) -> CheckedConnection | None:
        """Return the next connection; None if none comes in time, or the engine's process ends before."""
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

    def _missing_reason(self) -> str:
        if self._program is not None and self._program.returncode is not None:
            return f"the engine ended with status {self._program.returncode} before it connected"
        return f"no engine connected to {self.address} within {self._patience.connect:g} s; --wait gives it longer"


@asynccontextmanager
async def check_session(
    address: str | None, secret: str, command: Sequence[str], patience: Patience
) -> AsyncIterator[CheckSession]:
    """Listen at `address`, and run `command` if there is one, for as long as the context lasts.

    The command finds the address and the secret in its environment; its output goes to standard error.

    Raises:
        LinkError: the address cannot be listened on.
    """
    async with AsyncExitStack() as stack:
        listener, where = stack.enter_context(listening(address))
        session = CheckSession(where, secret, patience)
        server = await asyncio.start_server(session.connected, sock=listener, limit=_BUFFER)
        stack.callback(server.close)
        if command:
            session.start = lambda: stack.enter_async_context(_running(command, where, secret))
        yield session


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
        # It has a session of its own, so this reaches its children, too.
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
