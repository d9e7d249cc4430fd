"""The ways of one application's requests: to the session here, or to one at the gateway that owns the engine."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

from pydantic import BaseModel, ValidationError

from openrois.engine.condition import parse_condition
from openrois.federation.assertion import Assertion
from openrois.federation.federation import Federation
from openrois.federation.foreign_work import ForeignWork
from openrois.federation.lines import SessionLine
from openrois.federation.sub_session import SubSession
from openrois.federation.sub_sessions import SubSessions
from openrois.interfaces.selection import COMPONENT_PROPERTIES
from openrois.jsonrpc.session import Handler, Reply
from openrois.scope.scoped_tree import ScopedTree
from openrois.session.session import ApplicationSession
from openrois.transport.stream import StreamClosed
from openrois.types.references import engine_of
from openrois.types.streams import EXTENSION_VERSION

__all__ = ["Routes", "fitting"]

_PROPERTIES: Final = COMPONENT_PROPERTIES | {"stream_id"}
"""What any condition may name: its own reader refuses what is too much."""


class Routes:
    """The sessions of one application.

    Args:
        federation: the gateway among the others of its cluster.
        app: the session at the engines of this gateway.
        local: its methods.
        notify: sends the application a notification.
        address: where the application comes from.
        on_lost: called when a session at another gateway has ended.

    Attributes:
        engine: all engines of the cluster that the application sees.
        work: what it has at other gateways.
        subs: its sessions there.
        line: the line of its sessions, once it can be resumed.
    """

    def __init__(
        self,
        federation: Federation,
        app: ApplicationSession,
        local: Mapping[str, Handler],
        notify: Callable[..., None],
        address: str,
        on_lost: Callable[[SubSession, StreamClosed], None],
    ) -> None:
        self.federation = federation
        self.app = app
        self.local = local
        self.notify = notify
        self.address = address
        self.engine = ScopedTree(federation.directory, app.principal, federation.views)
        self.work = ForeignWork()
        federation.works.add(self.work)
        self.line = SessionLine()
        self.subs = SubSessions(
            federation.dial,
            app.host.tasks,
            self.assertion,
            notify,
            self.work.note_notification,
            on_lost,
            federation.counts,
        )

    def assertion(self) -> Assertion:
        """Return what is asserted of the application to other gateways now."""
        return Assertion.of(
            self.app.principal,
            address=self.address,
            client_id=self.app.client_id,
            line=self.line.line_id,
            generation=self.line.generation,
        )

    async def extend(self) -> None:
        """Let the sessions elsewhere send the notifications of extensions, where the one here does."""
        if self.app.extended and not self.subs.says("openrois.hello"):
            await self.subs.say("openrois.hello", {"version": EXTENSION_VERSION, "extensions": []})

    def gateway(self, engine_id: str, component_ref: object = None) -> str | None:
        """Return the other gateway that owns an engine; None where the session here answers.

        Raises:
            EngineUnreachable: the application would see the component that is named, and its gateway is not reached.
        """
        if self.engine.tree.has_engine(engine_id):
            gateway_id = self.federation.directory.gateway_of(engine_id)
            return None if gateway_id == self.federation.gateway_id else gateway_id
        if isinstance(component_ref, str) and self.engine.sees(component_ref):
            self.federation.require_reachable(engine_id)
        return None

    def require_reachable(self, condition: str) -> None:
        """Do nothing unless a condition names a component that the application would see at a gateway in reach.

        Raises:
            BadParameter: it cannot be read.
            EngineUnreachable: it does, and that gateway is not reached.
        """
        component_ref = parse_condition(condition, _PROPERTIES).value_of("component_ref")
        if component_ref is not None:
            self.gateway(engine_of(component_ref), component_ref)

    async def ask_at(
        self,
        gateway_id: str | None,
        name: str,
        params: dict[str, Any],
        *,
        refs: Iterable[str] = (),
        urgent: bool = False,
        accepted: Callable[[Mapping[str, Any]], None] = lambda _result: None,
    ) -> Any:
        """Ask the session at a gateway what the application asks, and return its reply.

        Args:
            gateway_id: the other gateway; None where the session here answers.
            name: the method.
            params: as they came.
            refs: the components that the application works with by that.
            urgent: whether another gateway is asked also where there is no room for questions.
            accepted: called with the result of another gateway before any later message of it is read.

        Raises:
            EngineUnreachable: the other gateway is not reached.
        """
        if gateway_id is None:
            return await self.local[name](params)
        sub = await self.subs.to(gateway_id)
        for component_ref in refs:
            sub.note_ref(component_ref)
        return await sub.relay(name, params, urgent=urgent, accepted=accepted)

    async def ask_about(self, component_ref: str, name: str, params: dict[str, Any]) -> Any:
        """Ask the session that has a component, and return its reply."""
        gateway_id = self.gateway(engine_of(component_ref), component_ref)
        return await self.ask_at(gateway_id, name, params, refs=(component_ref,))

    async def ask_here(self, name: str, params: dict[str, Any]) -> tuple[Any, str, Reply]:
        """Ask the session here; return the result, the reason of a refusal, and both as a reply."""
        said = await self.local[name](params)
        reply = said if isinstance(said, Reply) else Reply(said)
        return reply.result, reply.reason, reply


def fitting(model: type[BaseModel], params: dict[str, Any]) -> Any:
    """Return params as their model; None where they do not fit, which the session here explains."""
    try:
        return model.model_validate(params)
    except ValidationError:
        return None
