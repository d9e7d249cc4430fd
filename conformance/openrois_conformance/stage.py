"""The surroundings of a check: the gateway's address, the suite's adapter, and connections that end with the check."""

from collections.abc import Awaitable, Callable
from contextlib import AsyncExitStack, suppress
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Final, TypeVar
from urllib.parse import urlsplit

from websockets.exceptions import InvalidHandshake

from openrois.transport.websocket import refusal
from openrois_conformance.application import Application
from openrois_conformance.command_ids import CommandIds
from openrois_conformance.deviation import Deviation
from openrois_conformance.door import Door
from openrois_conformance.probe import Probe, dialled, new_engine_id
from openrois_conformance.probe_engine import ProbeEngine
from openrois_conformance.probe_profiles import component_profiles
from openrois_conformance.transcript import Transcript

__all__ = ["Check", "Checks", "Needs", "Setting", "Stage", "adapter_url"]

_CLOSE_TIMEOUT: Final = 1.0


class Needs(Enum):
    """Preconditions of a check. The value says why it was not run."""

    APPLICATION = "nothing"
    ADAPTER = "the suite's own adapter was not allowed (--no-adapter)"
    EXTENSIONS = "the gateway does not answer openrois.hello"
    LEASES = "the gateway does not speak openrois.lease"
    DIRECTORY = "the gateway does not speak openrois.directory"
    ADMINISTRATOR = "what the gateway was shown is no administrator's token"
    COMPONENT = "no component was given (--component)"


def adapter_url(url: str) -> str:
    """Return the address of adapters, given that of applications."""
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.netloc}/adapter"


@dataclass(frozen=True, slots=True)
class Setting:
    """Common settings of all checks of a run.

    Attributes:
        applications: where applications connect.
        adapters: where adapters dial.
        patience: seconds to wait for anything.
        transcript: keeps what is said during a check.
        probe: the suite's adapter, where there is one.
        extensions: those that the gateway speaks.
        component: a component of another maker that may be tried.
    """

    applications: Door
    adapters: Door
    patience: float
    transcript: Transcript
    probe: Probe | None = None
    extensions: tuple[str, ...] = ()
    component: str | None = None


@dataclass
class Stage:
    """The means of one check. Every connection that is opened here is closed when the check ends.

    Attributes:
        remarks: what a user should know although the check passed.
    """

    setting: Setting
    stack: AsyncExitStack
    remarks: list[str] = field(default_factory=list)
    _applications: list[Application] = field(default_factory=list)
    _ids: CommandIds = field(default_factory=CommandIds)

    @property
    def probe(self) -> Probe:
        """The suite's adapter."""
        if self.setting.probe is None:
            raise RuntimeError("a check that uses the adapter has to say that it needs it")
        return self.setting.probe

    @property
    def patience(self) -> float:
        """Seconds to wait for anything."""
        return self.setting.patience

    @property
    def component(self) -> str:
        """The component of another maker that may be tried."""
        return self.setting.component or ""

    def ref(self, name: str) -> str:
        """Return the component_ref of a component of the suite's adapter."""
        return self.probe.ref(name)

    def sent_id(self, command_id: str) -> str:
        """Return the id that stands on the wire for a command of the check."""
        return self._ids.sent(command_id)

    def remark(self, text: str) -> None:
        """Note a remark although the check passes."""
        self.remarks.append(text)

    async def application(self, **options: Any) -> Application:
        """Connect an application."""
        try:
            opened = self.setting.applications.opened(self.patience, close_timeout=_CLOSE_TIMEOUT, **options)
            socket = await self.stack.enter_async_context(opened)
        except ConnectionRefusedError:
            raise Deviation("an application to be let in", "no answer: nothing listens there") from None
        except (OSError, InvalidHandshake, ValueError, TimeoutError) as error:
            raise Deviation("an application to be let in", refusal(error)) from None
        name = f"application {len(self._applications) + 1}"
        app = Application(socket, name, self.setting.transcript, self.patience, self._ids)
        self._applications.append(app)
        return app

    async def adapter(self, engine: ProbeEngine | None = None) -> Probe:
        """Connect an adapter of the check's own; it may not be attached yet."""
        if engine is None:
            engine_id = new_engine_id()
            engine = ProbeEngine(engine_id, component_profiles(engine_id))
        opened = dialled(self.setting.adapters, self.setting.transcript, self.patience, engine)
        return await self.stack.enter_async_context(opened)

    async def attached(self, engine: ProbeEngine | None = None) -> Probe:
        """Connect an adapter of the check's own and wait until it is part of the tree."""
        probe = await self.adapter(engine)
        await self.until_there(next(iter(probe.engine.profiles)))
        return probe

    async def until_there(self, component_ref: str, *, there: bool = True) -> None:
        """Wait until a component can be found, or can no longer be found."""
        app = await self.application()
        wanted = [component_ref] if there else []
        condition = f"component_ref = '{component_ref}'"
        while (await app.ask("rois.command.search", condition=condition))["component_ref_list"] != wanted:
            try:
                await app.next("rois.system.profile_changed")
            except Deviation:
                what = "be found" if there else "be gone"
                raise Deviation(f"{component_ref} to {what} within {self.patience:g} s", "it is not") from None

    async def settle(self, app: Application, *allowed: str) -> None:
        """Refuse any notification to `app` that the adapter caused up to now, except those that are allowed."""
        condition = f"component_ref = '{self.ref('eye')}'"
        await app.granted("rois.query.query", query_type="component_status", condition=condition)
        for method in allowed:
            app.drop_notifications(method)
        await app.silent("nothing that was done causes one")

    async def strike(self) -> None:
        """End the check: end what it left running, and check what every application received."""
        if self.setting.probe is not None:
            await self.setting.probe.let_go()
        for app in self._applications:
            if app.is_open:
                await app.settled()

    async def clear(self) -> None:
        """Release everything, whatever state it is in."""
        for app in self._applications:
            with suppress(Deviation):
                if app.is_open:
                    await app.code("rois.system.disconnect")


Play = Callable[[Stage], Awaitable[None]]
_Play = TypeVar("_Play", bound=Play)


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that is tried from outside.

    Attributes:
        id: what requirements call it.
        title: one sentence: what the gateway shall do.
        play: does it; raises `Deviation` where the gateway does something else.
        needs: what it cannot do without.
    """

    id: str
    title: str
    play: Play
    needs: frozenset[Needs]


class Checks(list[Check]):
    """The checks of one module, in their order there."""

    def __call__(self, check_id: str, *needs: Needs) -> Callable[[_Play], _Play]:
        """Mark a function as a check; the first line of its docstring is the title."""

        def mark(play: _Play) -> _Play:
            title = (play.__doc__ or "").partition("\n")[0]
            self.append(Check(check_id, title, play, frozenset(needs)))
            return play

        return mark
