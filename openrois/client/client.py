"""The client: an application's connection to a gateway, from which everything else of this package is reached."""

import asyncio
from collections.abc import Iterable
from contextlib import AbstractAsyncContextManager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self, TypeVar, overload

from openrois.catalog.component_type import ComponentType
from openrois.client.application import Application
from openrois.client.body import Body, Wanted
from openrois.client.body_directory import BodyInfo, Kind, code_of, urn_of
from openrois.client.component import ComponentProxy, proxy_of
from openrois.client.connection import Connection, ConnectionState
from openrois.client.control import Control
from openrois.client.dialling import Dial, websocket
from openrois.client.feed import BUFFER, Feed
from openrois.client.notices import Connected, Notice, Notification, ProfileChanged
from openrois.client.operations import Operations
from openrois.client.reconnect import Reconnect
from openrois.client.reserving import WAIT, Bodies
from openrois.client.values import where
from openrois.errors import BadParameter, RoISError, Unsupported
from openrois.transport.backoff import Backoff
from openrois.transport.credentials import Credentials, Token
from openrois.types.codes import ComponentStatus
from openrois.types.directory import DIRECTORY

__all__ = ["Client"]

_RECONNECT: Final = Reconnect()

Proxy = TypeVar("Proxy", bound=ComponentProxy)
Told = TypeVar("Told", bound=Notice)


class Client(Operations):
    """An application at a gateway: `async with Client() as client:`, or `connect` and `close` in a notebook.

    The block begins when the gateway has answered, and fails with `ConnectionFailed` when it does not. From then on a
    lost connection is made again, with what was bound and subscribed; `notices` reports it. When the block ends the
    gateway forgets the application: nothing stays bound, commands that run go on. Before it, and after it, everything
    that needs the gateway fails with `ConnectionLost` at once.

    Args:
        url: the gateway's address.
        dial: opens connections in place of a WebSocket to `url`.
        token: a JSON Web Token (RFC 7519) for the gateway, where it wants one; or a function that returns the newest:
            it is called at every connection, and before the present one ends. Unless given it is what is then in the
            file that the environment names (`OPENROIS_TOKEN_FILE`), if it names one.
        ca_file: authorities (PEM) that may have signed the gateway's certificate; unless given those of the
            environment (`OPENROIS_CA_FILE`), or else the system's.
        connect_timeout: seconds that connecting may take.
        request_timeout: seconds that an answer may take.
        reconnect: when a lost connection is made again; None for never.

    Attributes:
        control: asks for components that others hold, hands them over, and stops everything.
    """

    def __init__(
        self,
        url: str = "ws://127.0.0.1:8765/",
        *,
        dial: Dial | None = None,
        token: Token | None = None,
        ca_file: Path | str | None = None,
        connect_timeout: float = 10.0,
        request_timeout: float = 30.0,
        reconnect: Reconnect | None = _RECONNECT,
    ) -> None:
        named = Credentials.of_files(None, ca_file)
        credentials = Credentials(named.token if token is None and dial is None else token, named.ca_file)
        self._application = Application(lambda: self._connection, reconnect or _RECONNECT, request_timeout, credentials)
        connection = Connection(
            dial or websocket(url, credentials),
            self._application,
            connect_timeout=connect_timeout,
            request_timeout=request_timeout,
            reconnect=reconnect,
            renewable=callable(credentials.token),
        )
        super().__init__(connection, self._application)
        self.control = Control(connection, self._application.bindings, self.notices)
        self._application.on_notice.add(self.control.handle_notice)
        self._bodies = Bodies(
            self,
            connection,
            self._application.bindings,
            self.control,
            self._application.directory,
            reconnect or _RECONNECT,
            self._application.handle_notice,
        )
        self._application.on_notice.add(self._bodies.handle_notice)

    async def __aenter__(self) -> Self:
        return await self.connect()

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    async def connect(self) -> Self:
        """Connect, and stay connected until `close`: `client = await Client().connect()`.

        Raises:
            ConnectionFailed: there is no gateway, or it does not let this application in.
            RuntimeError: this client was connected or closed before.
        """
        await self._connection.open()
        return self

    async def close(self) -> None:
        """Take leave of the gateway, for at most a second, and end the connection. Idempotent."""
        await self._connection.close()

    @property
    def state(self) -> ConnectionState:
        """The state of the connection."""
        return self._connection.state

    @overload
    def notices(self, *, buffer: int = BUFFER) -> Feed[Notice]: ...
    @overload
    def notices(self, *kinds: type[Told], buffer: int = BUFFER) -> Feed[Told]: ...
    def notices(self, *kinds: type[Any], buffer: int = BUFFER) -> Feed[Any]:
        """Return the client's notices from now on: `async for fault in client.notices(Fault)`.

        Args:
            kinds: only notices of these types; all unless given.
            buffer: how many may wait to be read.

        Raises:
            ConnectionLost: the client is not connected yet, or was closed.
        """
        self._connection.require_open("notices")
        wanted = kinds or (Notice,)
        feed: Feed[Any] = Feed(buffer, lambda notice: isinstance(notice, wanted))
        self._application.notices.add(feed)
        return feed

    def notifications(self, *methods: str, buffer: int = BUFFER) -> Feed[Notification]:
        """Return the gateway's notifications from now on as they come, those of extensions too.

        Args:
            methods: only these, such as `"signaling.offer"`; all unless given.
            buffer: how many may wait to be read.

        Raises:
            ConnectionLost: the client is not connected yet, or was closed.
        """
        self._connection.require_open("notifications")
        feed: Feed[Notification] = Feed(buffer, lambda told: not methods or told.method in methods)
        self._application.listeners.add(feed)
        return feed

    @overload
    def component(self, kind: type[Proxy], component_ref: str, /) -> Proxy: ...
    @overload
    def component(self, kind: ComponentType, component_ref: str, /) -> ComponentProxy: ...
    @overload
    def component(self, component_ref: str, /) -> ComponentProxy: ...
    def component(self, kind: Any, component_ref: str | None = None, /) -> ComponentProxy:
        """Return a component by its reference, without a request: whether it exists shows when it is used.

        Args:
            kind: a class of `openrois.client.components` or one's own; a `ComponentType`; or left out for a component
                whose messages are read from its profile.
            component_ref: its reference.
        """
        if component_ref is None:
            return ComponentProxy(self, kind)
        return proxy_of(self, kind, component_ref)

    @overload
    async def find(self, kind: type[Proxy], condition: str = "", *, within: float = 0) -> Proxy: ...
    @overload
    async def find(self, kind: ComponentType, condition: str = "", *, within: float = 0) -> ComponentProxy: ...
    async def find(self, kind: Any, condition: str = "", *, within: float = 0) -> ComponentProxy:
        """Return the one component of a type, or the one of them that meets a condition.

        Args:
            kind: the type, as `component` takes it.
            condition: which of them, if there are several.
            within: seconds to wait for it, where its engine may start later than the application, and for its device,
                which may not be connected yet; if that takes longer it is returned as it is.

        Raises:
            Unsupported: there is none.
            BadParameter: there are several; it says which, and how to choose.
        """
        changes = self.notices(ProfileChanged, Connected)
        found: list[ComponentProxy] = await self.find_all(kind, condition)
        try:
            async with asyncio.timeout(within) as limit:
                while not found:
                    # That the client is closed meanwhile is said by the next question.
                    await anext(changes, None)
                    found = await self.find_all(kind, condition)
        except TimeoutError:
            if not limit.expired():
                raise
        code = code_of(urn_of(kind))
        if not found:
            raise Unsupported(f"there is no {code}{condition and f' where {condition}'}")
        if len(found) > 1:
            refs = [proxy.component_ref for proxy in found]
            raise BadParameter(
                f"there are {len(found)} components {code}: {', '.join(refs)}; take one that is free by"
                f' `client.body({code})`, or name one: `where(component_ref="{refs[0]}")`'
            )
        if within:
            with suppress(TimeoutError):
                async with asyncio.timeout_at(limit.when()):
                    await _until_usable(found[0])
        return found[0]

    @overload
    async def find_all(self, kind: type[Proxy], condition: str = "") -> list[Proxy]: ...
    @overload
    async def find_all(self, kind: ComponentType, condition: str = "") -> list[ComponentProxy]: ...
    async def find_all(self, kind: Any, condition: str = "") -> list[Any]:
        """Return the components of a type that meet a condition, in the order of the profile; none is no error.

        Args:
            kind: the type, as `component` takes it.
            condition: which of them; see `where`.

        Raises:
            BadParameter: it is no condition.
        """
        urn = urn_of(kind)
        of_type = where(component_type=urn)
        refs = await self.search(f"{of_type} AND {condition}" if condition else of_type)
        if not refs and DIRECTORY not in self.extensions:
            # Some gateways compare the code of the identifier alone with the URN.
            profiles = (await self.get_profile(condition)).component_profiles
            refs = tuple(ref for ref, profile in profiles.items() if profile.component_type == urn)
        return [self.component(kind, component_ref) for component_ref in refs]

    async def bodies(self) -> list[BodyInfo]:
        """Return the bodies behind the gateway: what each can do, and whether it is free.

        A body is an engine that owns components, with all that is reachable through it. A gateway that knows leases
        reports from then on by `ControlChanged` when one of the components changes hands.
        """
        return await self._bodies.all()

    def body(
        self, *required: Kind, optional: Kind | Iterable[Kind] = (), condition: str = "", wait: float = WAIT
    ) -> AbstractAsyncContextManager[Body]:
        """Reserve a body while the block runs: `async with client.body(Navigation, SpeechSynthesis) as body:`.

        All components are bound of one body, or none; the block ends with all of them released. Of several bodies the
        first that is free is taken, those with more of the optional types first; of several components of a type in it
        the first by reference. A body whose required component is lost is given back, and `BodyLost` tells.

        Args:
            required: the component types that it must have.
            optional: types that it should have; it is reserved without those that are taken, or not there.
            condition: of components, as `search` takes it: `component_ref LIKE 'avatar/%'`; see `where`.
            wait: seconds for which it is tried again; 0 for once. An attempt that has begun is finished.

        Raises:
            OutOfResources: all that have the components are taken; it says which refused.
            Unsupported: there is no such body; it says which there are.
            BadParameter: it is no condition.
            ValueError: no type is required, or one is named twice.
            TypeError: one is no component type.
        """
        return self._bodies.body(Wanted.of(required, optional), condition, wait)


async def _until_usable(component: ComponentProxy) -> None:
    """Wait until a component is connected to what it depends on; RoIS has no notification of that."""
    backoff = Backoff(first=0.05, limit=1)
    with suppress(RoISError):
        # Not every component answers this.
        while True:
            answer = await component.query("component_status")
            if answer.get("status") not in (ComponentStatus.UNINITIALIZED, ComponentStatus.ERROR):
                return
            await asyncio.sleep(backoff.after(0))
