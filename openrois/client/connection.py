"""The connection of a client: opened, greeted, watched, and made again when it ends."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack, suppress
from enum import Enum
from typing import Final, Protocol

from openrois.aio.tasks import TaskScope
from openrois.client.dialling import Dial
from openrois.client.errors import ConnectionFailed, ConnectionLost
from openrois.client.notices import Connected, Disconnected, Notice
from openrois.client.reconnect import Reconnect
from openrois.client.rpc_call import Outcome, ask
from openrois.errors import RoISError
from openrois.jsonrpc.protocol import METHOD_NOT_FOUND
from openrois.jsonrpc.session import NotificationHandler, RpcError, RpcSession
from openrois.transport.backoff import asked_to_wait
from openrois.transport.stream import StreamClosed
from openrois.types.messages import NoParams, ReturnResult
from openrois.types.model import Model

__all__ = ["Connection", "ConnectionOwner", "ConnectionState"]

_log = logging.getLogger(__name__)

_FAREWELL: Final = 1.0
_NO_HANDSHAKE: Final = 1006

_RESUMABLE: Final = frozenset({_NO_HANDSHAKE, 1011, 1012})
"""Close codes after which the session may go on: it broke, a side was silent, or one gateway of several restarts."""
_TOKEN_ENDED: Final = 4401
_NOT_OPENED: Final = "the client is not connected: use it in `async with client:`, or `await client.connect()` first"


class ConnectionState(Enum):
    """The state of a client's connection."""

    CONNECTING = "connecting"
    CONNECTED = "connected"
    WAITING = "waiting"
    """It ended; the next attempt comes in a while."""
    CLOSED = "closed"
    """It is not open yet, or will not be again."""


class ConnectionOwner(Protocol):
    """The state that is carried from one connection to the next."""

    notifications: Mapping[str, NotificationHandler]

    async def greet_gateway(self, session: RpcSession) -> None:
        """Greet the gateway, within the time for connecting. An exception ends the attempt."""
        ...

    async def restore_state(self, session: RpcSession) -> None:
        """Restore what the last connection held; no other request is sent before this is over."""
        ...

    async def run_background(self, session: RpcSession) -> None:
        """Do the background work of a connection; cancelled when it ends."""
        ...

    def end_connection(self, reason: str, *, lost: bool = False, again: bool = False) -> None:
        """Note that the connection has ended: whether it was lost, and whether another attempt follows."""
        ...

    def handle_notice(self, notice: Notice) -> None:
        """Put a notice into the feeds."""
        ...

    def handle_closed(self, error: Exception | None) -> None:
        """End every feed: there will be no connection any more, as it was closed, or for `error`."""
        ...


class Connection:
    """A connection that hides its interruptions from its owner.

    Args:
        dial: opens it.
        owner: keeps its state from one connection to the next.
        connect_timeout: seconds that opening and greeting may take together.
        request_timeout: seconds that an answer may take.
        reconnect: when it is made again; None for never.
        renewable: a token that has ended is no reason to give up: the next connection shows a newer one.
    """

    def __init__(
        self,
        dial: Dial,
        owner: ConnectionOwner,
        *,
        connect_timeout: float,
        request_timeout: float,
        reconnect: Reconnect | None,
        renewable: bool = False,
    ) -> None:
        self.state = ConnectionState.CLOSED
        self.request_timeout = request_timeout
        self._dial = dial
        self._owner = owner
        self._connect_timeout = connect_timeout
        self._reconnect = reconnect
        self._renewable = renewable
        self._session: RpcSession | None = None
        self._restoring: RpcSession | None = None
        """The next connection, while what the last one had is made again there."""
        self._changed = asyncio.Event()
        self._over: str | None = None
        self._supervising: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Connect, and stay connected until `close`.

        Raises:
            ConnectionFailed: there is no gateway, or it does not let this application in.
            RuntimeError: it was opened or closed before.
        """
        if self._supervising is not None or self._over is not None:
            raise RuntimeError("this client was used before: make another one with Client()")
        opened: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._supervising = asyncio.ensure_future(self._supervise(opened))
        try:
            await opened
        except ConnectionFailed as failure:
            await self.close()
            # The sentence says what to do; how far below that was noticed would only hide it.
            raise failure.with_traceback(None) from failure.__cause__
        except BaseException:
            await self.close()
            raise

    async def close(self) -> None:
        """Disconnect from the gateway, for at most a second, and end the connection. Idempotent."""
        session, self._over = self._session, self._over or "the client is closed"
        try:
            if session is not None:
                with suppress(Exception):
                    await ask(session, "rois.system.disconnect", NoParams(), ReturnResult, timeout=_FAREWELL)
                await session.close(1000, "client closed")
        finally:
            # Also where the caller is cancelled during the farewell.
            if self._supervising is not None:
                self._supervising.cancel()
                await asyncio.wait({self._supervising})

    async def ask(
        self,
        method: str,
        params: Model,
        model: type[Outcome],
        accepted: Callable[[Outcome], None] | None = None,
        too_late: Callable[[Outcome], None] | None = None,
    ) -> Outcome:
        """Send a request that may be repeated: without a connection it waits for one, and repeats it where one ended.

        Raises:
            RoISError, RpcError: as `openrois.client.rpc_call.ask`.
            ConnectionLost: there will be no connection any more.
            TimeoutError: no answer in time; waiting for the connection counts.
        """
        clock = asyncio.get_running_loop().time
        deadline = clock() + self.request_timeout
        while True:
            session = await self._connected(method, deadline - clock())
            try:
                left = max(deadline - clock(), 0)
                return await ask(session, method, params, model, timeout=left, accepted=accepted, too_late=too_late)
            except ConnectionLost:
                self._drop_session(session)
            except TimeoutError:
                raise self._too_long(method) from None

    async def act(
        self,
        method: str,
        params: Model,
        model: type[Outcome],
        accepted: Callable[[Outcome], None] | None = None,
        too_late: Callable[[Outcome], None] | None = None,
    ) -> Outcome:
        """Send a request that must not be late or repeated: without a connection it fails at once.

        Raises:
            RoISError, RpcError, ConnectionLost, TimeoutError: as `openrois.client.rpc_call.ask`.
        """
        session = self.session(method)
        timeout = self.request_timeout
        return await ask(session, method, params, model, timeout=timeout, accepted=accepted, too_late=too_late)

    def session(self, method: str) -> RpcSession:
        """Return the connection that there is now, to send `method` on it and on no other.

        Raises:
            ConnectionLost: there is none.
        """
        self.require_open(method)
        if self._session is None:
            reason = "there is no connection, and commands are not kept for later: wait for `Connected`, or try again"
            raise ConnectionLost(f"{method}: {reason}")
        return self._session

    def require_open(self, doing: str) -> None:
        """Do nothing where there is a connection, or will be one again.

        Args:
            doing: what needs it.

        Raises:
            ConnectionLost: it was not opened yet, or is over.
        """
        if self._over is not None or self._supervising is None:
            raise ConnectionLost(f"{doing}: {self._over or _NOT_OPENED}")

    def post(self, method: str, params: Model) -> None:
        """Send a request and drop its answer; nothing happens without a connection.

        What is given back while it is made again on the next connection is given back there.
        """
        session = self._session or self._restoring
        if session is not None:
            session.post(method, params.model_dump(mode="json", exclude_none=True))

    async def _connected(self, method: str, patience: float) -> RpcSession:
        try:
            async with asyncio.timeout(patience):
                while self._session is None:
                    self.require_open(method)
                    self._changed.clear()
                    await self._changed.wait()
        except TimeoutError:
            raise self._too_long(method) from None
        return self._session

    def _too_long(self, method: str) -> TimeoutError:
        return TimeoutError(f"{method}: no answer within {self.request_timeout:g} s")

    def _drop_session(self, session: RpcSession) -> None:
        """Stop using a session that has ended, before the supervisor notices."""
        if self._session is session:
            self._session = None

    async def _supervise(self, opened: asyncio.Future[None]) -> None:
        failure: Exception | None = None
        try:
            await self._keep_connected(opened)
        except ConnectionFailed as error:
            failure = error
        except Exception as error:
            _log.exception("the connection could not be kept")
            failure = error
        finally:
            closed, self._over = self._over, self._over or str(failure or "the client's event loop is over")
            self._session, self.state = None, ConnectionState.CLOSED
            if failure is not None and not opened.done():
                opened.set_exception(failure)
            self._owner.end_connection(self._over)
            self._owner.handle_notice(Disconnected(self._over, None))
            self._owner.handle_closed(None if closed else ConnectionLost(self._over))
            self._changed.set()

    async def _keep_connected(self, opened: asyncio.Future[None]) -> None:
        """Connect again and again; raises `ConnectionFailed` when that is over."""
        again = self._reconnect or Reconnect()
        backoff = again.backoff()
        while True:
            closed, lasted = await self._live_once(opened, again.clock)
            if self._over is not None:
                raise ConnectionFailed(self._over)
            if self._reconnect is None:
                raise ConnectionFailed(f"the connection ended: {closed}")
            if closed.code == _TOKEN_ENDED and not self._renewable:
                raise ConnectionFailed(f"the gateway does not let this application in any more: {closed.reason}")
            delay = again.spread(backoff.after(lasted)) + asked_to_wait(closed.reason)
            self.state = ConnectionState.WAITING
            # Of an attempt that failed the code is ours, and says nothing.
            reason = closed.reason if closed.code == _NO_HANDSHAKE and closed.reason else str(closed)
            self._owner.handle_notice(Disconnected(reason, delay))
            _log.info("%s; trying again in %.1f s", reason, delay)
            await again.sleep(delay)

    async def _live_once(self, opened: asyncio.Future[None], clock: Callable[[], float]) -> tuple[StreamClosed, float]:
        """Make one attempt; return how it ended and how long there was a connection.

        The first one of all raises `ConnectionFailed` instead.
        """
        self.state = ConnectionState.CONNECTING
        try:
            async with AsyncExitStack() as stack:
                session, running = await self._begin(stack)
                self._session, self.state = session, ConnectionState.CONNECTED
                self._changed.set()
                began = clock()
                if opened.done():
                    self._owner.handle_notice(Connected())
                else:
                    opened.set_result(None)
                async with TaskScope() as tasks:
                    tasks.start(self._owner.run_background(session))
                    closed = await asyncio.shield(running)
                    self._drop_session(session)
                    again = self._reconnect is not None and self._over is None
                    lost = again and closed.code in _RESUMABLE
                    self._owner.end_connection(f"the connection ended: {closed}", lost=lost, again=again)
                    return closed, clock() - began
        except ConnectionFailed as error:
            if error.final or not opened.done():
                raise
            return StreamClosed(_NO_HANDSHAKE, str(error)), 0.0

    async def _begin(self, stack: AsyncExitStack) -> tuple[RpcSession, "asyncio.Task[StreamClosed]"]:
        try:
            async with asyncio.timeout(self._connect_timeout):
                stream = await stack.enter_async_context(self._dial())
                session = RpcSession(stream, notifications=self._owner.notifications)
                session.call_timeout = self.request_timeout
                running = asyncio.ensure_future(session.run())
                stack.push_async_callback(_ended, running)
                await self._owner.greet_gateway(session)
            self._restoring = session
            await self._owner.restore_state(session)
        except ConnectionFailed:
            raise
        except TimeoutError:
            raise ConnectionFailed(f"the gateway did not answer within {self._connect_timeout:g} s") from None
        except (OSError, StreamClosed, RoISError, RpcError) as error:
            stranger = isinstance(error, RpcError) and error.code == METHOD_NOT_FOUND
            what = "what answers does not serve applications" if stranger else "no connection to the gateway"
            raise ConnectionFailed(f"{what}: {error}") from error
        finally:
            self._restoring = None
        return session, running


async def _ended(task: "asyncio.Task[StreamClosed]") -> None:
    task.cancel()
    await asyncio.wait({task})
