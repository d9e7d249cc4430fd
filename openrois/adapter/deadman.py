"""The dead man's switch: motion stops when no application is in control any more, or when that cannot be known."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Coroutine, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.commands.stop import STOP_TIMEOUT
from openrois.component.component import Component
from openrois.contract import Client, Extension
from openrois.errors import Aborted, RoISError, Unsupported
from openrois.jsonrpc.heartbeat import Heartbeat
from openrois.types.codes import ComponentFunction
from openrois.types.messages import Result
from openrois.types.streams import HolderNotification

__all__ = ["DeadMan", "HolderExtension"]

_log = logging.getLogger(__name__)

ALLOWANCE: Final = 0.1
"""Seconds left for calling `stop` once the last sign of life is too old."""

_LATE: Final = 0.02
"""Seconds after which this process counts as having been suspended itself: it reads what came meanwhile first."""

_AT_ONCE: Final = frozenset({"stop", "set_parameter"})
"""Commands that move nothing, or end it."""

Outcome = tuple[Result, ...]


@dataclass(eq=False)
class _Moving:
    """A command that may move something."""

    component_ref: str
    component: Component
    patience: float
    tripped: "asyncio.Future[str]" = field(default_factory=lambda: asyncio.get_running_loop().create_future())


class DeadMan:
    """Watches over the commands of components that have a dead man's switch.

    It trips when the connection to the gateway ends, when the gateway gives no sign of life, and when the application
    that held the component does not hold it any more, whatever the reason. Then the component's own `stop` is
    called at once, and its commands end with ABORT. A command whose turn comes only then begins nothing.

    Args:
        heartbeat: to the gateway.
        tasks: owns the watching.
        clock: monotonic seconds.
        sleep: waits for some seconds.
    """

    def __init__(
        self,
        heartbeat: Heartbeat,
        tasks: TaskScope,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._heartbeat = heartbeat
        self._tasks = tasks
        self._clock = clock
        self._sleep = sleep
        self._moving: set[_Moving] = set()
        self._watching: asyncio.Task[None] | None = None
        self._stopping: dict[Component, asyncio.Task[None]] = {}
        self._holders: dict[str, tuple[Client, int]] = {}
        heartbeat.on_cut.add(lambda reason: self._trip(self._moving, reason))

    async def guard(
        self, component_ref: str, component: Component, command_type: str, work: Coroutine[Any, Any, Outcome]
    ) -> Outcome:
        """Run a command of a component to its end, or until the switch trips.

        Raises:
            Aborted: it has tripped.
            RoISError: whatever the command raises.
        """
        if component.dead_man is None:
            return await work
        if command_type in _AT_ONCE:
            # In a task as what moves, so that they begin in the order in which they came: a `stop` would not end a
            # `start` that came just before it.
            return await asyncio.ensure_future(work)
        if self._is_uncontrolled(component_ref, component):
            work.close()
            raise Aborted(f"{component.name} does not move: no application has control")
        moving = _Moving(component_ref, component, max(component.dead_man - ALLOWANCE, 0.0))
        task = asyncio.ensure_future(work)
        self._begin_watching(moving)
        try:
            either: set[asyncio.Future[Any]] = {task, moving.tripped}
            await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
            if moving.tripped.done():
                await asyncio.wait({self._stopping[component]})
                raise Aborted(moving.tripped.result())
            return await task
        finally:
            self._end_watching(moving)
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    def _is_uncontrolled(self, component_ref: str, component: Component) -> bool:
        """Tell whether a gateway that reports holders has reported none: the one that began it may have left."""
        held = component_ref in self._holders or component.profile.function is not ComponentFunction.ACTUATION
        return self._heartbeat.is_alive and not held

    def take_holder(self, notice: HolderNotification, client: Client) -> bool:
        """Note the holder of a component: what moves for another application stops.

        Returns whether an application held the component and does not any more.
        """
        held = self._holders.get(notice.component_ref)
        if notice.holds:
            self._holders[notice.component_ref] = client, notice.epoch
            if held is not None and held[1] < notice.epoch:
                self._trip_component(notice.component_ref, "control has changed hands, or connections")
        elif held is not None and held[0] is client:
            del self._holders[notice.component_ref]
            self._trip_component(notice.component_ref, "no application has control any more")
        return held is not None and self._holders.get(notice.component_ref, (None, 0))[0] is not held[0]

    def forget_client(self, client: Client) -> list[str]:
        """Stop what moves for an application that is gone; returns the refs of the components that it held."""
        lost = [ref for ref, (holder, _) in self._holders.items() if holder is client]
        for component_ref in lost:
            del self._holders[component_ref]
            self._trip_component(component_ref, "the application that had control is gone")
        return lost

    def _trip_component(self, component_ref: str, reason: str) -> None:
        self._trip((moving for moving in self._moving if moving.component_ref == component_ref), reason)

    def _trip(self, chosen: Iterable[_Moving], reason: str) -> None:
        for moving in [moving for moving in chosen if not moving.tripped.done()]:
            stopping = self._stopping.get(moving.component)
            if stopping is None or stopping.done():
                self._stopping[moving.component] = self._tasks.start(self._stop(moving.component, reason))
            moving.tripped.set_result(f"{moving.component.name} was stopped: {reason}")

    async def _stop(self, component: Component, reason: str) -> None:
        _log.warning("%s is stopped: %s", component.name, reason)
        try:
            async with asyncio.timeout(STOP_TIMEOUT):
                if component.profile.command("stop") is not None:
                    await component.run("stop", ())
        except (RoISError, TimeoutError) as error:
            _log.error("%s did not stop: %s", component.name, str(error) or f"no answer within {STOP_TIMEOUT:g} s")

    def _begin_watching(self, moving: _Moving) -> None:
        self._moving.add(moving)
        self._heartbeat.want(True)
        if self._watching is None:
            self._watching = self._tasks.start(self._watch())

    def _end_watching(self, moving: _Moving) -> None:
        self._moving.discard(moving)
        if all(other.component is not moving.component for other in self._moving):
            self._stopping.pop(moving.component, None)
        if not self._moving:
            self._heartbeat.want(False)

    async def _watch(self) -> None:
        """Trip what has waited too long for a sign of life, while anything moves."""
        while free := [moving for moving in self._moving if not moving.tripped.done()]:
            due = self._heartbeat.seen_at + min(moving.patience for moving in free)
            left = due - self._clock()
            await self._sleep(max(left, 0.0))
            if left > 0 and self._clock() - due > _LATE:
                # This process did not run itself.
                await self._sleep(_LATE)
            if not self._heartbeat.is_alive:
                # A gateway that gives none is missed when its connection ends; until then there is nothing to see.
                self._heartbeat.sign()
            now = self._clock()
            overdue = (moving for moving in self._moving if now >= self._heartbeat.seen_at + moving.patience)
            self._trip(overdue, f"no sign of life from the gateway for {now - self._heartbeat.seen_at:.2f} s")
        self._watching = None


class HolderExtension:
    """The extension of an engine that passes the holders of components to the dead man's switch; an `Extension`.

    A component that its holder has lost is notified, too.

    Args:
        deadman: gets the holders.
        inner: answers the streaming and signaling methods, where the engine has streams.
        components: of the engine, by their refs.
    """

    def __init__(self, deadman: DeadMan, inner: Extension | None, components: Mapping[str, Component]) -> None:
        self._deadman = deadman
        self._inner = inner
        self._components = components

    def engines(self) -> frozenset[str]:
        """Return the ids of the engines that have streams."""
        return frozenset() if self._inner is None else self._inner.engines()

    @property
    def takes_role(self) -> bool:
        """Whether visitors are told apart."""
        return getattr(self._inner, "takes_role", False)

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Pass on streaming and signaling."""
        if self._inner is None:
            raise Unsupported("the engine has no streams")
        return await self._inner.call(method, params, client)

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        """Note the holder of a component, and pass it on."""
        if self._deadman.take_holder(notification, client):
            self._note_lost(notification.component_ref)
        if self._inner is not None:
            await self._inner.set_holder(notification, client)

    async def forget_client(self, client: Client) -> None:
        """Stop what moves for the application, and pass the call on."""
        for component_ref in self._deadman.forget_client(client):
            self._note_lost(component_ref)
        if self._inner is not None:
            await self._inner.forget_client(client)

    def _note_lost(self, component_ref: str) -> None:
        component = self._components.get(component_ref)
        if component is not None:
            try:
                component.holder_lost()
            except Exception:
                # The other components and the streams of the application are told all the same.
                _log.exception("%s: its holder_lost failed", component_ref)
