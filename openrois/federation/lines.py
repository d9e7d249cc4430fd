"""The sessions at this gateway that can be resumed at any gateway, by their lines; and what they hold, in the store."""

import logging
import secrets
from collections.abc import Iterable
from dataclasses import dataclass
from weakref import WeakKeyDictionary, WeakValueDictionary

from openrois.auth.principal import Principal, Role
from openrois.errors import RoISError, Unsupported
from openrois.leases.changes import Change, Gained, Lost, NotReturned, Why
from openrois.resumption.holdings_writer import HoldingsWriter
from openrois.resumption.lines import Freed, Held, Holding
from openrois.scope.revocation import Entitlements
from openrois.session.session import ApplicationSession, EngineHost
from openrois.types.references import engine_of

__all__ = ["Lines", "SessionLine", "new_line"]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SessionLine:
    """An application's session over all its connections.

    Attributes:
        line_id: its name; empty where it cannot be resumed.
        generation: how often it was resumed.
    """

    line_id: str = ""
    generation: int = 0


def new_line() -> SessionLine:
    """Return a line that has not been resumed."""
    return SessionLine(secrets.token_hex(16))


class Lines:
    """The lines that have a session at this gateway.

    Args:
        host: this gateway's engine.
        writer: writes what they hold to the store.
    """

    def __init__(self, host: EngineHost, writer: HoldingsWriter) -> None:
        self._host = host
        self._writer = writer
        self._sessions: WeakValueDictionary[str, ApplicationSession] = WeakValueDictionary()
        self._lines: WeakKeyDictionary[ApplicationSession, SessionLine] = WeakKeyDictionary()
        self._awaited: dict[str, tuple[Holding, ...]] = {}
        host.leases.carrier.on_change = self._note_change

    async def written(self, seconds: float) -> bool:
        """Wait until the store has what is held here, or for so long; tell whether it has."""
        return await self._writer.flushed(seconds)

    def session_of(self, line_id: str) -> ApplicationSession | None:
        """Return the session of a line here, whose connection may be lost; None where there is none."""
        return self._sessions.get(line_id)

    def adopt(self, app: ApplicationSession, line: SessionLine) -> None:
        """Let a session belong to a line, and go on in the place of the session that it has here already.

        Raises:
            Unsupported: the line was resumed since, or leases do not survive a connection here.
        """
        former = self._sessions.get(line.line_id)
        if former is not None and former is not app and self._lines[former].generation > line.generation:
            raise Unsupported("the session was resumed by another connection since")
        self._host.leases.token(app)
        self._lines[app] = line
        self._sessions[line.line_id] = app
        if former is not None and former is not app:
            self._succeed(former, app)
        for component_ref, epoch in self._host.leases.model.owned_by(app).items():
            self._writer.note(Held(component_ref, engine_of(component_ref), line.line_id, epoch))

    def _succeed(self, former: ApplicationSession, app: ApplicationSession) -> None:
        keeper = self._host.leases
        if keeper.model.may_go_on(former):
            keeper.succeed(former, app)
        app.succeed(former)
        for component_ref in Entitlements(app.principal).lost_bindings(tuple(app.bound)):
            app.give_back(component_ref)
            app.bound.discard(component_ref)

    # What is held.

    def _note_change(self, change: Change) -> None:
        """Write a change of holders; that of a component that has gone is kept: it may come to another gateway.

        What was taken for a time stays its lender's there: no loan outlives its gateway.
        """
        match change:
            case Gained(_, _, _, _, True) | Lost(_, _, _, _, True) | Lost(_, _, _, Why.GONE | Why.LENT):
                pass
            case Gained(component_ref, holder, epoch, _) if (line := self._lines.get(_session(holder))) is not None:
                self._writer.note(Held(component_ref, engine_of(component_ref), line.line_id, epoch))
            case Lost(component_ref, holder, epoch, _) if _session(holder) in self._lines:
                self._writer.note(Freed(component_ref, epoch))
            case NotReturned(component_ref, lender, epoch, why) if (
                why is not Why.GONE and _session(lender) in self._lines
            ):
                self._writer.note(Freed(component_ref, epoch))
            case _:
                pass

    def await_engines(self, holdings: Iterable[Holding]) -> None:
        """Reserve components for the lines that held them, as soon as their engines are attached."""
        by_engine: dict[str, list[Holding]] = {}
        for holding in holdings:
            by_engine.setdefault(holding.engine_id, []).append(holding)
        self._awaited |= {engine_id: tuple(found) for engine_id, found in by_engine.items()}

    def restore(self, engine_ids: Iterable[str]) -> None:
        """Reserve what was held of engines that are attached now."""
        for engine_id in engine_ids:
            for holding in self._awaited.pop(engine_id, ()):
                try:
                    self._restore(holding)
                except RoISError as error:
                    _log.warning("%s is not kept for its holder: %s", holding.component_ref, error)

    def _restore(self, holding: Holding) -> None:
        app = self._sessions.get(holding.line_id)
        if app is None:
            # It stands for the session until that comes.
            scope = (f"{holding.engine_id}/*",)
            principal = Principal(holding.subject, frozenset({Role.OPERATOR}), scope, rank=holding.rank)
            app = ApplicationSession(self._host, _drop, principal=principal)
            app.detach()
            app.is_relayed = True
            self._lines[app] = SessionLine(holding.line_id)
            self._sessions[holding.line_id] = app
        if app.closed:
            self._host.leases.reserve(holding.component_ref, app)
        elif app.engine.sees(holding.component_ref):
            self._host.leases.bind(holding.component_ref, app)


def _session(holder: object) -> ApplicationSession:
    assert isinstance(holder, ApplicationSession)
    return holder


def _drop(_method: str, _params: object, **_more: bool) -> None:
    """Drop a notification: the session has no connection."""
