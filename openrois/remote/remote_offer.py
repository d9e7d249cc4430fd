"""What a remote engine offers: its answer to our hello, and its directory, or its whole profile where it has none."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from openrois.contract import Directory
from openrois.errors import ComponentFailed, NotResponding, Unsupported
from openrois.jsonrpc import protocol
from openrois.jsonrpc.session import NotificationHandler, RpcError
from openrois.remote.attachment import ATTACHED
from openrois.remote.followed_engines import together
from openrois.remote.greeting import Greeting
from openrois.remote.remote_directory import RemoteDirectory
from openrois.remote.rpc_call import RpcCalls, read_result
from openrois.remote.shared_profiles import shared_profile
from openrois.types.codes import ReturnCode
from openrois.types.directory import DIRECTORY
from openrois.types.leases import LEASES
from openrois.types.messages import ProfileResult
from openrois.types.stops import STOPPED, Stopped
from openrois.types.streams import EXTENSION_VERSION, EXTENSIONS

__all__ = ["Identity", "RemoteOffer"]

HELLO_TIMEOUT: Final = 1.0
"""Seconds after which an engine that does not answer `openrois.hello` is taken for one of the base wire."""

READS: Final = 8
"""Times in a row that the directory of an engine is read because it has changed meanwhile."""


@dataclass(frozen=True, slots=True)
class Identity:
    """Who an adapter is.

    Attributes:
        instance: the random text of its process; empty where it sends none.
        epoch: the greatest epoch that it has ever seen; 0 for none.
        stopped: what persons have stopped of its engines for programs, by engine; None where it keeps none in mind.
    """

    instance: str = field(default="", repr=False)
    epoch: int = 0
    stopped: Mapping[str, Stopped] | None = None


class RemoteOffer:
    """What the engine at the other end of a connection offers.

    Args:
        calls: asks it.
        call_timeout: seconds that it has for an answer.
        changed: called when its offer has to be read again; must not block.
        touched: called before that with the engines that may have changed, or with None for any; must not block.
    """

    def __init__(
        self,
        calls: RpcCalls,
        call_timeout: float,
        changed: Callable[[], None],
        touched: Callable[[Collection[str] | None], None],
    ) -> None:
        self._calls = calls
        self._call_timeout = call_timeout
        self._changed = changed
        self._touched = touched
        self._directory = RemoteDirectory(calls, self._take_changes)
        self._is_plain = False
        self._is_reading = False
        """Whether the directory is read, again and again while it changes."""
        self._greeting: Greeting | None = None

    def notifications(self) -> dict[str, NotificationHandler]:
        """Return the handlers of the notifications of changes."""
        return {
            "rois.system.profile_changed": lambda _params: self._take_changes(None),
            **self._directory.notifications(),
        }

    @property
    def greeting(self) -> Greeting | None:
        """The answer to our hello; None where the engine seems to have no extensions."""
        return None if self._is_plain else self._greeting

    @property
    def identity(self) -> Identity:
        """Who the other side is, as far as it says so."""
        greeting = self._greeting
        if greeting is None:
            return Identity()
        keeps_stops = STOPPED in greeting.extensions
        stopped = {each.engine_id: each for each in greeting.stopped} if keeps_stops else None
        return Identity(greeting.instance, greeting.epoch, stopped)

    def _take_changes(self, engine_ids: Collection[str] | None) -> None:
        self._touched(engine_ids)
        if not self._is_reading:
            self._changed()

    async def read(self) -> tuple[Directory, frozenset[str]]:
        """Return the directory, and which engines have streams.

        An engine of the base wire is asked for its profile first, and so is any until it has said that it has a
        directory: it may take a hello for a fault.

        Raises:
            RoISError: the engine did not answer as it should.
        """
        whole = None if self._has_directory else await self._read_profile()
        if not self._is_plain:
            await self._greet()
        if self._has_directory:
            return await self._read_directory()
        if whole is None:
            whole = await self._read_profile()
        return whole, self._streaming_of(whole)

    @property
    def _has_directory(self) -> bool:
        greeting = self.greeting
        return greeting is not None and DIRECTORY in greeting.extensions

    def _streaming_of(self, whole: Directory) -> frozenset[str]:
        """Return which engines of a profile have streams, by the greeting."""
        greeting = self.greeting
        if greeting is None or "rois.stream" not in greeting.extensions:
            return frozenset()
        named = greeting.engines or (whole.profile.identifier.code,)
        return frozenset(named).intersection(whole.profile.engine_ids())

    async def _read_profile(self) -> Directory:
        """Return the other side's whole profile."""
        result = await self._calls.ask("rois.system.get_profile", {"condition": ""}, ProfileResult)
        if result.profile is None:
            raise ComponentFailed("the engine has no profile")
        # It speaks for the components that it lists: another profile could belong to another engine.
        listed = {ref: result.component_profiles.get(ref) for ref in result.profile.component_refs()}
        profiles = {ref: shared_profile(profile) for ref, profile in listed.items() if profile is not None}
        return Directory(result.profile, profiles)

    async def _read_directory(self) -> tuple[Directory, frozenset[str]]:
        """Return the same by the other side's directory: what is as it was is not read again."""
        remote = self._directory
        self._is_reading = True
        try:
            for _ in range(READS):
                await remote.read()
                if remote.is_settled:
                    break
        finally:
            self._is_reading = False
        if remote.engines.main is None:
            raise ComponentFailed("the directory of the engine changes faster than it can be listed")
        if not remote.is_settled:
            self._changed()
        return together(remote.engines.main, remote.engines.roots.values()), remote.engines.streaming()

    async def _greet(self) -> None:
        params = {"version": EXTENSION_VERSION, "extensions": [*EXTENSIONS, DIRECTORY, LEASES, ATTACHED, STOPPED]}
        timeout = min(HELLO_TIMEOUT, self._call_timeout)
        try:
            self._greeting = await self._calls.ask(
                "openrois.hello", params, Greeting, too_late=self._take_late_greeting, timeout=timeout
            )
        except Unsupported:
            self._is_plain = True
        except NotResponding:
            # It may speak the base wire alone, and answer what it does not know with nothing.
            self._is_plain = self._greeting is None
        except ComponentFailed as error:
            self._is_plain = isinstance(error.__cause__, RpcError) and error.__cause__.code == protocol.METHOD_NOT_FOUND
            if not self._is_plain:
                raise

    def _take_late_greeting(self, result: Any) -> None:
        greeting = read_result("openrois.hello", result, Greeting)
        former = self._greeting
        if greeting.return_code is not ReturnCode.OK or greeting == former:
            return
        self._greeting, self._is_plain = greeting, False
        # Epochs grow all the time, and are no reason for another look.
        if former is None or greeting.model_copy(update={"epoch": former.epoch}) != former:
            self._changed()
