"""The component that is tried: reached through a bus, with bounded waits, and known by its profile alone."""

import asyncio
from collections.abc import Awaitable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from openrois.component.component import Component
from openrois.contract import ComponentBus, Event, SubscriptionLost
from openrois.errors import RoISError
from openrois.testing.samples import argument
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIComponentProfile, ParameterProfile
from openrois.types.values import check_value

__all__ = ["Broken", "EventCollector", "LocalSubject", "Subject", "require"]

T = TypeVar("T")


class Broken(AssertionError):
    """A component violates the contract; the text says what it did and what was due."""


def require(kept: bool, sentence: str) -> None:
    """Raise `Broken` with a sentence unless the contract is kept."""
    if not kept:
        raise Broken(sentence)


@dataclass
class EventCollector:
    """A sink that keeps its events."""

    received: list[Event | SubscriptionLost] = field(default_factory=list)

    def __call__(self, item: Event | SubscriptionLost) -> None:
        """Keep an event."""
        self.received.append(item)


@dataclass(frozen=True, kw_only=True)
class Subject:
    """One component behind a bus.

    Attributes:
        bus: how it is reached.
        component_ref: which it is.
        profile: what it says of itself.
        parameters: what has to be set before `start`, as texts by name.
        refuses: messages that it always refuses, and why; they are asked for nothing.
        patience: seconds that an answer may take.
    """

    bus: ComponentBus
    component_ref: str
    profile: HRIComponentProfile
    parameters: Mapping[str, str] = field(default_factory=dict)
    refuses: Mapping[str, str] = field(default_factory=dict)
    patience: float = 5.0

    async def within(self, doing: str, work: Awaitable[T]) -> T:
        """Await something that may not take long."""
        try:
            async with asyncio.timeout(self.patience):
                return await work
        except TimeoutError:
            raise Broken(f"{doing} took longer than {self.patience:g} s") from None

    async def query(self, name: str) -> tuple[Result, ...]:
        """Return the results of a query, which must not fail."""
        try:
            return await self.within(f"query {name}", self.bus.query(self.component_ref, name))
        except RoISError as error:
            raise Broken(f"query {name} failed: {error or type(error).__name__}") from error

    async def invoke(self, name: str, *arguments: Argument) -> tuple[Result, ...]:
        """Run a command that must end with OK, soon."""
        try:
            return await self.within(f"command {name}", self.bus.invoke(self.component_ref, name, arguments))
        except RoISError as error:
            raise Broken(f"command {name} failed: {error or type(error).__name__}") from error

    async def refused(self, doing: str, work: Awaitable[object], *errors: type[RoISError]) -> None:
        """Require that something is refused with one of `errors`."""
        expected = " or ".join(error.__name__ for error in errors)
        try:
            given = await self.within(doing, work)
        except errors:
            return
        except RoISError as error:
            raise Broken(f"{doing} is refused with {type(error).__name__}, not {expected}: {error}") from error
        raise Broken(f"{doing} is not refused with {expected}: it gave {given!r}")

    @property
    def has_status(self) -> bool:
        """Whether it answers `component_status`, as all basic components but SystemInformation do."""
        return self.profile.has_query("component_status")

    async def status(self) -> str:
        """Return the component's status."""
        (status,) = await self.query("component_status")
        return status.value

    async def parameter_values(self) -> dict[str, str]:
        """Return the parameters' values by name."""
        return {parameter.name: parameter.value for parameter in await self.query("get_parameter")}

    async def prepare(self) -> None:
        """Set the parameters that `start` needs."""
        chosen = [profile for profile in self.profile.parameter_profiles if profile.name in self.parameters]
        if chosen:
            await self.invoke("set_parameter", *(argument(each, self.parameters[each.name]) for each in chosen))

    def require_fitting(self, message: str, results: tuple[Result, ...], due: tuple[ParameterProfile, ...]) -> None:
        """Require that results are what the profile promises of a message."""
        codes = {profile.name: profile.data_type_ref.code for profile in due}
        names = [result.name for result in results]
        require(len(names) == len(set(names)), f"{message} gives a result twice: {', '.join(names)}")
        for result in results:
            require(result.name in codes, f"{message} gives {result.name!r}, which its profile does not name")
            code = codes[result.name]
            require(
                result.data_type_ref == code,
                f"{message} gives {result.name!r} as {result.data_type_ref}, its profile says {code}",
            )
            try:
                check_value(code, result.value)
            except ValueError as error:
                raise Broken(f"{message} gives {result.name!r} that does not fit: {error}") from None


@dataclass(frozen=True, kw_only=True)
class LocalSubject(Subject):
    """A component in this process.

    Attributes:
        component: the same component, without a bus.
    """

    component: Component
