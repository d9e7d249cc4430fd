"""Reserving a body: all components that an application needs of one engine, or none.

Components are bound in the sorted order of their references. Of applications that try at the same moment one always
gets its body, unless an application that has its body holds a part of it: the one with the last of the references over
which they compete. The others release what they have and try again after a while, by chance, so that they do not meet
again. Nothing is held while they wait, as it would be in the line of `openrois.lease.request`, which also asks the
holder to hand over one part of its body.
"""

import asyncio
from collections.abc import AsyncIterator, Callable, Collection, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from typing import Final

from openrois.client.bindings import Bindings
from openrois.client.body import Body, Reservation, Wanted
from openrois.client.body_directory import BodyComponent, BodyInfo, BodyProfile, bodies_in, bodies_of
from openrois.client.component import proxy_of
from openrois.client.connection import Connection
from openrois.client.control import Control
from openrois.client.engine_directory import EngineDirectory
from openrois.client.errors import ConnectionLost
from openrois.client.notices import BindingLost, BodyLost, Disconnected, Notice
from openrois.client.operations import Operations
from openrois.client.reconnect import Reconnect
from openrois.client.values import where
from openrois.errors import OutOfResources, RoISError, Unsupported
from openrois.jsonrpc.session import RpcError
from openrois.transport.backoff import Backoff
from openrois.types.codes import ComponentFunction
from openrois.types.directory import DIRECTORY
from openrois.types.leases import LEASES, LeaseState
from openrois.types.messages import ComponentParams, ConditionParams, SearchResult

__all__ = ["WAIT", "Bodies"]

WAIT: Final = 10.0
"""Seconds for which `Client.body` tries unless it is told otherwise."""

_FIRST: Final = 0.1
_LONGEST: Final = 1.0
"""Seconds between two attempts at most: the first time, and after many."""

_AT_ONCE: Final = 64
_UNREAD: Final = -1


class Bodies:
    """Lists and reserves bodies for one client, and gives a body back when a part of it is lost.

    Args:
        operations: of the client.
        connection: of the client.
        bindings: what it has.
        control: its leases.
        directory: the engines that there are.
        reconnect: the chance and the clock of waits.
        tell: takes what the application should know.
    """

    def __init__(
        self,
        operations: Operations,
        connection: Connection,
        bindings: Bindings,
        control: Control,
        directory: EngineDirectory,
        reconnect: Reconnect,
        tell: Callable[[Notice], None],
    ) -> None:
        self._operations = operations
        self._connection = connection
        self._bindings = bindings
        self._control = control
        self._directory = directory
        self._reconnect = reconnect
        self._tell = tell
        self._reserved: dict[str, Reservation] = {}

    # Which there are.

    async def all(self) -> list[BodyInfo]:
        """Return all bodies; see `Client.bodies`."""
        bodies, functions = await self._read()
        free = await self._free(functions)
        return [
            BodyInfo(body.engine_id, tuple(BodyComponent(ref, urn, free.get(ref)) for ref, urn in body.types.items()))
            for body in bodies
        ]

    async def _read(self) -> tuple[tuple[BodyProfile, ...], dict[str, ComponentFunction | None]]:
        """Return all bodies, and the function of each component."""
        if DIRECTORY in self._operations.extensions:
            entries = await self._directory.read()
            components = (each for entry in entries.values() for each in entry.components)
            return bodies_of(entries.values()), {each.component_ref: each.function for each in components}
        answer = await self._operations.get_profile()
        return bodies_in(answer), {ref: profile.function for ref, profile in answer.component_profiles.items()}

    async def _free(self, functions: Mapping[str, ComponentFunction | None]) -> dict[str, bool | None]:
        """Tell of each component whether no application holds it; of none where the gateway knows no leases."""
        if LEASES not in self._operations.extensions:
            return {}
        leased = [ref for ref, function in functions.items() if function is ComponentFunction.ACTUATION]
        free: dict[str, bool | None] = dict.fromkeys(functions, True)
        for first in range(0, len(leased), _AT_ONCE):
            some = leased[first : first + _AT_ONCE]
            free.update(zip(some, await asyncio.gather(*map(self._is_free, some)), strict=True))
        return free

    async def _is_free(self, component_ref: str) -> bool | None:
        try:
            return (await self._control.status(component_ref)).state is LeaseState.FREE
        except RoISError:
            # It is gone meanwhile, or this application may not know.
            return None

    # Reserving one.

    @asynccontextmanager
    async def body(self, wanted: Wanted, condition: str, wait: float) -> AsyncIterator[Body]:
        """Reserve a body while the block runs; see `Client.body`."""
        reservation = await self._reserve(wanted, condition, wait)
        kinds = {**wanted.required, **wanted.optional}
        proxies = {urn: proxy_of(self._operations, kinds[urn], ref) for urn, ref in reservation.bound.items()}
        try:
            yield Body(reservation, proxies)
        finally:
            refs = tuple(reservation.bound.values())
            self._give_back(reservation)
            await self._released(refs)

    async def _reserve(self, wanted: Wanted, condition: str, wait: float) -> Reservation:
        deadline = self._reconnect.clock() + wait
        backoff = Backoff(_FIRST, limit=_LONGEST)
        bodies: tuple[BodyProfile, ...] = ()
        read_in = _UNREAD
        while True:
            if read_in != self._operations.generation:
                read_in = self._operations.generation
                if condition:
                    bodies = bodies_in(await self._operations.get_profile(condition))
                else:
                    bodies, _ = await self._read()
            refusals: list[tuple[str, RoISError]] = []
            for body in _candidates(bodies, wanted):
                try:
                    return await self._try(body, wanted)
                except RoISError as refusal:
                    refusals.append((body.engine_id, refusal))
            if not refusals or any(isinstance(refusal, Unsupported) for _, refusal in refusals):
                # Not every gateway notifies that components came or went.
                read_in = _UNREAD
            left = deadline - self._reconnect.clock()
            if left <= 0:
                raise _failure(wanted, condition, bodies, refusals)
            await self._reconnect.sleep(min(self._reconnect.spread(backoff.after(0)), left))

    async def _try(self, body: BodyProfile, wanted: Wanted) -> Reservation:
        """Reserve a body, or nothing of it.

        Raises:
            RoISError: a required component is not to be had.
        """
        reservation = Reservation(body.engine_id, frozenset(wanted.optional))
        try:
            await self._bind_each(reservation, body, wanted.required, required=True)
            await self._bind_each(reservation, body, wanted.optional, required=False)
            reservation.require_held()
        except BaseException:
            self._give_back(reservation)
            raise
        reservation.complete = True
        return reservation

    async def _bind_each(
        self, reservation: Reservation, body: BodyProfile, urns: Collection[str], *, required: bool
    ) -> None:
        """Bind the first component of each type that is to be had, in the sorted order of all references."""
        refs = [ref for ref, urn in body.types.items() if urn in urns]
        for place, ref in enumerate(refs, 1):
            urn = body.types[ref]
            if urn in reservation.bound:
                continue
            try:
                await self._bind(reservation, ref)
            except RoISError:
                if required and urn not in (body.types[other] for other in refs[place:]):
                    raise
            else:
                reservation.bound[urn] = ref

    async def _bind(self, reservation: Reservation, component_ref: str) -> None:
        if component_ref in self._reserved:
            raise OutOfResources(f"{component_ref} is a part of another body of this application")
        self._reserved[component_ref] = reservation
        try:
            await self._operations.bind(component_ref)
        except BaseException:
            del self._reserved[component_ref]
            raise
        if reservation.error is not None:
            self._release(component_ref)
            reservation.require_held()

    # Giving it back.

    def _give_back(self, reservation: Reservation) -> None:
        """Release everything, in one step that cannot be cancelled half way."""
        for component_ref in reservation.bound.values():
            self._release(component_ref)
        reservation.bound.clear()

    def _release(self, component_ref: str) -> None:
        del self._reserved[component_ref]
        if self._bindings.unuse(component_ref):
            self._bindings.gave_back(component_ref)
            # A task that binds it now would lose it to a release that is sent after its bind.
            if not self._bindings.turn(component_ref).locked():
                self._connection.post("rois.command.release", ComponentParams(component_ref=component_ref))

    async def _released(self, component_refs: Sequence[str]) -> None:
        """Return when releases that were sent have been processed: a question behind them is answered."""
        with suppress(RoISError, RpcError, TimeoutError, ConnectionLost):
            for component_ref in component_refs[:1]:
                params = ConditionParams(condition=where(component_ref=component_ref))
                await self._connection.act("rois.command.search", params, SearchResult)

    def handle_notice(self, notice: Notice) -> None:
        """Give back a body of which a required component was lost; an optional one is released alone."""
        match notice:
            case BindingLost(component_ref, error) if component_ref in self._reserved:
                self._lose(self._reserved[component_ref], component_ref, error)
            case Disconnected(reason, None):
                for reservation in set(self._reserved.values()):
                    self._lose(reservation, "", ConnectionLost(reason))

    def _lose(self, reservation: Reservation, component_ref: str, error: Exception) -> None:
        urn = next((urn for urn, ref in reservation.bound.items() if ref == component_ref), "")
        if urn in reservation.optional:
            self._release(reservation.bound.pop(urn))
            return
        reservation.error = error
        self._give_back(reservation)
        if reservation.complete:
            self._tell(BodyLost(reservation.engine_id, component_ref, error))


def _candidates(bodies: Sequence[BodyProfile], wanted: Wanted) -> list[BodyProfile]:
    """Return the bodies with all that is required, those that have more of what is optional first."""
    having = [body for body in bodies if body.has(wanted.required)]
    return sorted(having, key=lambda body: -sum(body.has((urn,)) for urn in wanted.optional))


def _failure(
    wanted: Wanted, condition: str, bodies: Sequence[BodyProfile], refusals: Sequence[tuple[str, RoISError]]
) -> RoISError:
    """Return the error that says which bodies there are, and what refused."""
    named = f"body with {wanted}{condition and f' where {condition}'}"
    if refusals:
        return OutOfResources(f"no {named} is free: {'; '.join(f'{engine}: {why}' for engine, why in refusals)}")
    there = "; ".join(f"{body.engine_id} ({body.codes()})" for body in bodies)
    return Unsupported(f"there is no {named}; there are: {there or 'none'}")
