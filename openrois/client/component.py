"""A component as an application sees it: by the names of its messages, with values of Python's types."""

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from functools import cache
from typing import Any, ClassVar, TypeVar, overload

from openrois.catalog.component_type import ComponentType
from openrois.catalog.payload import Payload
from openrois.client.feed import BUFFER
from openrois.client.operations import Operations
from openrois.client.steps import Step
from openrois.client.subscription import Subscription
from openrois.client.values import read, where, write
from openrois.errors import Unsupported
from openrois.types.messages import Argument, EventNotification
from openrois.types.profiles import HRIComponentProfile

__all__ = ["ComponentProxy", "proxy_of"]

P = TypeVar("P", bound=Payload)


@cache
def _profile_of(kind: ComponentType) -> HRIComponentProfile:
    return kind.profile()


class ComponentProxy:
    """One component of any type. Its messages follow from its type, or else from its profile, which is read once.

    Its messages are named: `await lamp.command("switch", times=3)`, `await lamp.query("power")`,
    `async for data in lamp.event("switched")`. A subclass gives them methods of their own; the basic components have
    theirs in `openrois.client.components`.

    Attributes:
        component_type: the type of a subclass's components.
        client: whose component it is.
        component_ref: its reference.
    """

    component_type: ClassVar[ComponentType | None] = None

    def __init__(self, client: Operations, component_ref: str, component_type: ComponentType | None = None) -> None:
        self.client = client
        self.component_ref = component_ref
        self._type = component_type or self.component_type
        self._read_in: tuple[int, int] | None = None
        self._profile: HRIComponentProfile | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.component_ref}>"

    async def profile(self) -> HRIComponentProfile:
        """Return the component's profile.

        Raises:
            Unsupported: there is no such component.
        """
        answer = await self.client.get_profile(where(component_ref=self.component_ref))
        profile = answer.component_profiles.get(self.component_ref)
        if profile is None:
            raise Unsupported(f"there is no component {self.component_ref}")
        return profile

    async def _shape(self) -> HRIComponentProfile:
        """Return the names and types of the messages: of the type, or of the component's profile now."""
        if self._type is not None:
            return _profile_of(self._type)
        generation = self.client.generation_of(self.component_ref)
        if self._profile is None or self._read_in != generation:
            self._read_in = generation
            self._profile = await self.profile()
        return self._profile

    async def bind(self) -> None:
        """Reserve the component; raises as `Client.bind`."""
        await self.client.bind(self.component_ref)

    async def release(self) -> None:
        """Give the component back."""
        await self.client.release(self.component_ref)

    @asynccontextmanager
    async def bound(self) -> AsyncIterator[None]:
        """Reserve the component for as long as the block runs, see `Client.bound`.

        Raises:
            OutOfResources: another application has it.
        """
        async with self.client.bound(self.component_ref):
            yield

    @overload
    def command(self, name: str, /, **arguments: Any) -> Step[dict[str, Any]]: ...
    @overload
    def command(self, name: str, results: None, /, **arguments: Any) -> Step[None]: ...
    @overload
    def command(self, name: str, results: type[P], /, **arguments: Any) -> Step[P]: ...
    def command(self, name: str, results: Any = dict, /, **arguments: Any) -> Step[Any]:
        """Return a command, to be awaited or to be put into a sequence.

        Args:
            name: the command's type.
            results: what it gives: a payload, None for nothing; values by name unless given.
            arguments: by name; None is not sent.
        """

        async def prepare() -> tuple[Argument, ...]:
            profile = (await self._shape()).command(name)
            if profile is None:
                raise Unsupported(f"{self.component_ref} has no command {name!r}")
            return write(f"{name} of {self.component_ref}", profile.arguments, arguments)

        return Step(self.client, self.component_ref, name, prepare, _results_of(self, name, results))

    def set_parameter(self, **parameters: Any) -> Step[None]:
        """Return the change of parameters, all at once; None and those not named stay as they are."""

        async def prepare() -> tuple[Argument, ...]:
            profiles = (await self._shape()).parameter_profiles
            return write(f"set_parameter of {self.component_ref}", profiles, parameters)

        return Step(self.client, self.component_ref, "set_parameter", prepare, _results_of(self, "set_parameter", None))

    @overload
    async def get_parameter(self) -> dict[str, Any]: ...
    @overload
    async def get_parameter(self, parameters: type[P]) -> P: ...
    async def get_parameter(self, parameters: Any = dict) -> Any:
        """Return the parameters that have a value: as a payload, or by name."""
        values = await self.client.get_parameter(self.component_ref)
        return read(f"get_parameter of {self.component_ref}", parameters, values)

    @overload
    async def query(self, name: str, /) -> dict[str, Any]: ...
    @overload
    async def query(self, name: str, results: type[P], /) -> P: ...
    async def query(self, name: str, results: Any = dict, /) -> Any:
        """Query the component; the answer is a payload, or values by name."""
        answer = await self.client.query(name, where(component_ref=self.component_ref))
        return read(f"{name} of {self.component_ref}", results, answer)

    @overload
    def event(self, name: str, /, *, buffer: int = BUFFER) -> Subscription[dict[str, Any]]: ...
    @overload
    def event(self, name: str, results: type[P], /, *, buffer: int = BUFFER) -> Subscription[P]: ...
    def event(self, name: str, results: Any = dict, /, *, buffer: int = BUFFER) -> Subscription[Any]:
        """Return an event's occurrences from now on, each as a payload or as values by name.

        Args:
            name: the event's type.
            results: what it tells.
            buffer: how many may wait to be read; the oldest makes room for the newest.
        """
        return self.client.listen(name, where(component_ref=self.component_ref), _data_of(self, name, results), buffer)


def proxy_of(client: Operations, kind: Any, component_ref: str) -> ComponentProxy:
    """Return a component by its reference, without a request.

    Args:
        client: whose component it is.
        kind: a class for it or a `ComponentType`; for anything else its messages are read from its profile.
        component_ref: its reference.
    """
    if isinstance(kind, ComponentType):
        return ComponentProxy(client, component_ref, kind)
    if isinstance(kind, type) and issubclass(kind, ComponentProxy):
        return kind(client, component_ref)
    return ComponentProxy(client, component_ref)


def _results_of(component: ComponentProxy, name: str, kind: Any) -> Callable[[str], Awaitable[Any]]:
    """Return a function that reads the results of a completed command."""

    async def read_results(command_id: str) -> Any:
        if kind is None:
            return None
        return read(f"{name} of {component.component_ref}", kind, await component.client.get_command_result(command_id))

    return read_results


def _data_of(component: ComponentProxy, name: str, kind: Any) -> Callable[[EventNotification], Awaitable[Any]]:
    """Return a function that reads the data of an event."""
    tells_nothing = kind is not dict and not kind.data()

    async def read_data(notification: EventNotification) -> Any:
        told = notification.results
        if not told and not tells_nothing:
            # That they come with the event is an extension; what they are can always be asked for.
            told = await component.client.get_event_detail(notification.event_id)
        return read(f"{name} of {component.component_ref}", kind, told)

    return read_data
