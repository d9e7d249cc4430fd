"""A session that goes on over another connection, at whichever gateway: its token, its line, what it finds again."""

import logging
from asyncio import gather
from collections.abc import Collection, Mapping
from hashlib import sha256
from typing import Any, Final

from pydantic import ValidationError

from openrois.errors import BadParameter, RoISError, StoreUnreachable, Unsupported
from openrois.federation.lines import SessionLine, new_line
from openrois.federation.routes import Routes, fitting
from openrois.federation.sub_session import SubSession
from openrois.interfaces.lease import held_leases, tell_missed
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.jsonrpc.session import Reply
from openrois.leases.tokens import new_token
from openrois.types.leases import LeaseTokenResult, ResumeParams, ResumeResult
from openrois.types.messages import NoParams
from openrois.types.references import engine_of

__all__ = ["KEEP", "REPORT", "Resumption"]

_log = logging.getLogger(__name__)

KEEP: Final = "openrois.cluster.keep"
"""Notification to another gateway: the session belongs to this line, and outlasts a lost connection."""

REPORT: Final = "openrois.cluster.report"
"""Method of another gateway: what a session that was resumed holds there, and which commands are known."""

REPORT_TIMEOUT: Final = 1.0
"""Seconds that another gateway has to report; what it does not report in time is forgotten."""

MAX_USED: Final = 1024
"""Engines of one application whose leases are looked for at their next gateway; the first that was used is left."""

WRITING_TIME: Final = 0.25
"""Seconds that a token waits for the store to have what the session holds; then it is given without."""

_NOT_VALID: Final = "the resume token is not valid"
_RESUME: Final = "openrois.lease.resume"


class Resumption:
    """The line of one application's sessions.

    Args:
        routes: of the application.
    """

    def __init__(self, routes: Routes) -> None:
        self._routes = routes
        self._used: dict[str, None] = {}
        """Engines of which the application may hold something."""
        self._missed: dict[str, None] = {}
        """Those of them that have left their gateway."""

    def methods(self) -> BoundMethods:
        """Return the methods."""
        return BoundMethods((_METHODS, self))

    async def _token(self, params: dict[str, Any]) -> Any:
        if fitting(NoParams, params) is None:
            return await self._routes.local["openrois.lease.token"](params)
        app = self._routes.app
        app.extended = app.leasing = True
        line = self._routes.line if self._routes.line.line_id else new_line()
        token = await self._issue(line)
        self._belong_to(line)
        await self._routes.federation.lines.written(WRITING_TIME)
        return LeaseTokenResult(token=token, grace_ms=self._grace_ms)

    @property
    def _grace_ms(self) -> int:
        return round(self._routes.app.host.leases.model.rules.grace * 1000)

    async def _issue(self, line: SessionLine) -> str:
        """Return a token that resumes the sessions of a line at any gateway; the one before counts as used.

        Raises:
            Unsupported: leases do not survive a connection here, or the session was resumed elsewhere.
            StoreUnreachable: tokens cannot be kept now.
        """
        routes = self._routes
        # Refused here where there is no grace.
        routes.app.host.leases.token(routes.app)
        token = new_token()
        store, principal = routes.federation.resume_store, routes.app.principal
        if not await store.issue(line.line_id, line.generation, principal.subject, _digest(token), rank=principal.rank):
            raise Unsupported("this session was resumed by another connection since")
        return token

    def _belong_to(self, line: SessionLine) -> None:
        """Let all sessions of the application belong to a line."""
        routes = self._routes
        is_new, routes.line = line != routes.line, line
        routes.federation.lines.adopt(routes.app, line)
        routes.federation.keep_alive(line.line_id, self)
        if is_new:
            routes.subs.send_notification(KEEP, routes.assertion().hello())

    async def _resume(self, params: dict[str, Any]) -> Any:
        asked = fitting(ResumeParams, params)
        if asked is None:
            return await self._routes.local[_RESUME](params)
        routes, app = self._routes, self._routes.app
        app.extended = app.leasing = True
        if app.host.leases.model.has_any(app) or app.commands.unfinished or routes.work.running:
            raise BadParameter("resume before binding or executing anything that acts")
        line = await self._redeem(asked.token)
        self._belong_to(line)
        # What ends here from now on is notified by itself, while others are asked.
        missed = [command_id for command_id in asked.command_ids if app.commands.ending(command_id) is not None]
        reports = await gather(*(self._report(gateway_id, asked) for gateway_id in routes.federation.others))
        is_whole = routes.federation.is_joined and None not in reports
        routes.federation.counts.resumptions["whole" if is_whole else "partial"] += 1
        found = [report for report in reports if report is not None]
        held = held_leases(app)
        app.host.audit.acted(app.principal, _RESUME, " ".join(sorted(each.component_ref for each in held)), "")
        known = {command_id for command_id in asked.command_ids if command_id in app.commands}
        known |= {each for report in found for each in asked.command_ids if each not in report.forgotten}
        token = await self._issue(line)
        # What this session holds now is kept for the next one that goes on.
        await routes.federation.lines.written(WRITING_TIME)
        result = ResumeResult(
            token=token,
            grace_ms=self._grace_ms,
            leases=(*held, *(lease for report in found for lease in report.leases)),
            forgotten=tuple(command_id for command_id in asked.command_ids if command_id not in known),
        )
        return Reply(result, lambda: tell_missed(app, missed))

    async def _redeem(self, token: str) -> SessionLine:
        """Use up a token, and return the line that this session belongs to from now on.

        Raises:
            Unsupported: the token is not valid.
            StoreUnreachable: that cannot be found out now.
        """
        app = self._routes.app
        found = await self._routes.federation.resume_store.redeem(_digest(token), app.principal.subject)
        if found.line_id and not found.is_replayed:
            return SessionLine(found.line_id, found.generation)
        self._routes.federation.counts.resumptions["replayed" if found.is_replayed else "refused"] += 1
        reason = "a resume token was used twice" if found.is_replayed else _NOT_VALID
        app.host.audit.refused(app.principal, _RESUME, "", reason)
        raise Unsupported(_NOT_VALID)

    async def _report(self, gateway_id: str, asked: ResumeParams) -> ResumeResult | None:
        """Return what a gateway has of the line; None where it is not reached, or does not say."""
        params = {"command_ids": list(asked.command_ids)}
        try:
            sub = await self._routes.subs.to(gateway_id)
            said = await sub.ask(REPORT, params, timeout=REPORT_TIMEOUT, accepted=self._noting(sub, asked))
            report = ResumeResult.read_newer(said[0])
        except (RoISError, ValidationError) as error:
            _log.warning("a resumed session finds nothing at gateway %s: %s", gateway_id, error)
            return None
        for lease in report.leases:
            sub.note_ref(lease.component_ref)
            self._routes.work.note_held(lease.component_ref, is_held=True)
        return report

    def _noting(self, sub: SubSession, asked: ResumeParams) -> Any:
        def note(result: Any) -> None:
            forgotten = set(result.get("forgotten", ()))
            known = [command_id for command_id in asked.command_ids if command_id not in forgotten]
            # Their ends may come right behind this reply.
            self._routes.work.adopt(sub.gateway_id, known)

        return note

    # When an engine has another gateway.

    def note_use(self, component_ref: str) -> None:
        """Note that the application may hold something of an engine."""
        self._used[engine_of(component_ref)] = None
        if len(self._used) > MAX_USED:
            del self._used[next(iter(self._used))]

    def note_loss(self, refs: Collection[str]) -> None:
        """Note the components of a gateway that was lost: the session goes on where their engines are found again."""
        if self._routes.line.line_id:
            engine_ids = set(map(engine_of, refs))
            self._missed |= dict.fromkeys(engine_ids)
            self.find_again(engine_ids)

    def find_again(self, engine_ids: Collection[str]) -> None:
        """Go on with the session at the gateways where engines are now that were at other ones."""
        if not self._routes.line.line_id:
            return
        for engine_id in engine_ids:
            if not self._routes.engine.tree.has_engine(engine_id):
                if engine_id in self._used:
                    self._missed[engine_id] = None
            elif engine_id in self._missed:
                del self._missed[engine_id]
                self._routes.app.host.tasks.start(self._open(engine_id))

    async def _open(self, engine_id: str) -> None:
        try:
            gateway_id = self._routes.gateway(engine_id)
            if gateway_id is not None:
                await self._routes.subs.to(gateway_id)
        except RoISError as error:
            _log.info("a session does not go on at %s yet: %s", engine_id, error)
            self._missed[engine_id] = None

    async def close(self, *, lost: bool) -> None:
        """End the line, unless the connection was lost and the session may go on over another one."""
        line, federation = self._routes.line, self._routes.federation
        if not line.line_id:
            return
        federation.forget_line(line.line_id, self)
        if not lost:
            try:
                await federation.resume_store.end_line(line.line_id, line.generation)
            except StoreUnreachable as error:
                # It is removed when it has not been touched for a day.
                _log.info("a session that has left stays in the store for a while: %s", error)


_METHODS: Final[Mapping[str, SharedMethod]] = {"openrois.lease.token": Resumption._token, _RESUME: Resumption._resume}


def _digest(token: str) -> bytes:
    return sha256(token.encode(errors="surrogatepass")).digest()
