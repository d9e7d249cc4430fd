"""Fills the event log: with events that the caller waits for, and with what happens to its body."""

import asyncio
import logging
from collections.abc import Callable
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.client import (
    BindingLent,
    BindingRestored,
    BodyLost,
    Client,
    ComponentProxy,
    Connected,
    ConnectionLost,
    ControlRequested,
    ControlStopped,
    Disconnected,
    Feed,
    Notice,
    OutOfResources,
    ProfileChanged,
    RoISError,
    RpcError,
    Subscription,
)
from openrois.types.references import engine_of
from openrois_agents.tools.consents import Consents
from openrois_agents.tools.event_log import EventLog
from openrois_agents.tools.untrusted import plain_text

__all__ = ["Watching"]

_log = logging.getLogger(__name__)

MAX_SUBSCRIPTIONS: Final = 16
"""Events that a caller may watch at a time."""


class Watching:
    """Reads events of a caller into its log.

    Args:
        log: the log.
        on_profile_changed: called when bodies or their components came or went.
    """

    def __init__(self, log: EventLog, on_profile_changed: Callable[[], None]) -> None:
        self._event_log = log
        self._on_profile_changed = on_profile_changed
        self._notices = TaskScope()
        self._tasks = TaskScope()
        self._watched: dict[tuple[str, str], Subscription[dict[str, Any]]] = {}
        self._followed: dict[Consents, asyncio.Task[None]] = {}

    async def watch(self, component: ComponentProxy, event: str, consents: Consents) -> None:
        """Log an event of a component from now on, until the task is over; again is no mistake.

        Args:
            component: announces it.
            event: its type.
            consents: of the visitors of that body, without whom nothing is told of them.

        Raises:
            OutOfResources: too many are watched.
            RoISError: it cannot be subscribed.
        """
        key = (component.component_ref, event)
        if key in self._watched:
            return
        if len(self._watched) >= MAX_SUBSCRIPTIONS:
            raise OutOfResources(f"{MAX_SUBSCRIPTIONS} events are watched already: give_back ends that")
        subscription = component.event(event)
        self._watched[key] = subscription
        try:
            await subscription.__aenter__()
        except BaseException:
            del self._watched[key]
            raise
        if consents not in self._followed:
            self._followed[consents] = self._tasks.start(self._follow(consents))
        self._tasks.start(self._read(key, subscription, consents))

    async def _follow(self, consents: Consents) -> None:
        try:
            await consents.follow()
        except (ConnectionLost, RoISError, RpcError) as error:
            _log.info("what visitors state is followed no more: %s", error)
        finally:
            self._followed.pop(consents, None)

    async def _read(self, key: tuple[str, str], subscription: Subscription[dict[str, Any]], consents: Consents) -> None:
        component_ref, event = key
        try:
            async for data in subscription:
                if not consents.concern(component_ref, event, data):
                    self._event_log.add(event, component_ref, plain_text(data))
                elif await _agree(consents, data):
                    self._event_log.add(event, component_ref, plain_text(data), consents)
        except (ConnectionLost, RoISError, RpcError) as error:
            _log.info("%s of %s is watched no more: %s", event, component_ref, error)
        finally:
            self._watched.pop(key, None)

    async def stop(self) -> None:
        """Watch no event any more."""
        for each in self._followed.values():
            each.cancel()
        await asyncio.gather(*map(_close, tuple(self._watched.values())))

    async def close(self) -> None:
        """Watch nothing any more."""
        await self.stop()
        await self._tasks.__aexit__(None, None, None)
        await self._notices.__aexit__(None, None, None)

    def follow_notices(self, client: Client) -> None:
        """Log what a client tells of the body that it holds."""
        self._notices.start(self._read_notices(client.notices()))

    async def _read_notices(self, notices: Feed[Notice]) -> None:
        try:
            async for notice in notices:
                self._note(notice)
        except ConnectionLost as error:
            _log.info("the connection to the gateway is over: %s", error)

    def _note(self, notice: Notice) -> None:
        add = self._event_log.add
        match notice:
            case BodyLost(engine_id, component_ref, error):
                add("body_lost", engine_id, {"component": component_ref, "reason": str(error)})
            case BindingLent(component_ref, holder, seconds):
                add("part_taken_for_a_time", component_ref, {"by": holder, "seconds": round(seconds)})
            case BindingRestored(component_ref):
                add("part_came_back", component_ref, {})
            case ControlStopped(engine_id, by, reason):
                add("stopped_by_a_person" if by else "handed_back_by_a_person", engine_id, {"by": by, "reason": reason})
            case ControlRequested(component_ref, _, subject, within):
                add("part_requested", engine_of(component_ref), {"by": subject, "answer_within": round(within)})
            case Disconnected(reason, _):
                add("connection_lost", "gateway", {"reason": reason})
            case Connected():
                add("connection_restored", "gateway", {})
                self._on_profile_changed()
            case ProfileChanged():
                self._on_profile_changed()


async def _agree(consents: Consents, data: dict[str, Any]) -> bool:
    try:
        return (await consents.ask())(data)
    except Exception:
        # What an odd body tells must not end the watch, and is no consent.
        _log.exception("consent could not be asked for, and an event is not told")
        return False


async def _close(subscription: Subscription[dict[str, Any]]) -> None:
    """End a subscription; where the gateway does not answer, it ends with the connection."""
    try:
        await subscription.close()
    except (ConnectionLost, RoISError, RpcError, TimeoutError) as error:
        _log.info("an event may still be subscribed: %s", error)
