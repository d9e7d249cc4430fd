"""Resuming a lost session: its token, and the ends of commands that completed meanwhile."""

import asyncio
import logging
from typing import Final

from openrois.client.bindings import Bindings
from openrois.client.commands import Commands
from openrois.client.rpc_call import ask
from openrois.errors import ComponentFailed, RoISError, TimedOut
from openrois.jsonrpc.session import RpcError, RpcSession
from openrois.types.leases import MAX_RESUMED, LeaseTokenResult, ResumeParams, ResumeResult
from openrois.types.messages import CommandResultParams, NoParams, ResultsResult

__all__ = ["Resumption"]

_log = logging.getLogger(__name__)

PATIENCE: Final = 30.0
"""Seconds after which commands of unknown end are given up: a gateway that has crashed is back by then."""

_AT_ONCE: Final = 64

_QUERIES: Final = 6
"""Queries for the end of a command that may still run at another gateway: each waits for some seconds."""

_MILLISECOND: Final = 0.001


class Resumption:
    """Resumes the session of a lost connection on the next one.

    The gateway lets it resume its session, or else has been restarted, or waited long enough. Then its journal may
    know how commands have ended; it is asked for each whose handle still waits.

    Args:
        commands: those of the client.
        bindings: what it wants to hold.
        timeout: seconds that an answer may take.
    """

    def __init__(self, commands: Commands, bindings: Bindings, timeout: float) -> None:
        self._commands = commands
        self._bindings = bindings
        self._timeout = timeout
        self._extended = False
        self._token = ""
        self._former = ""
        self._grace = 0.0
        self._orphans: tuple[str, ...] = ()
        self._reason = ""
        self._giving_up: asyncio.TimerHandle | None = None

    async def greet_gateway(self, session: RpcSession, *, extended: bool) -> None:
        """Resume the lost session, or at least get a token for the next time.

        Args:
            session: the new connection.
            extended: whether the gateway knows of leases; one that does not gets no such requests.

        Raises:
            ConnectionLost: the connection ended.
            TimeoutError: no answer in time.
        """
        self._extended = extended
        # An attempt that failed half way had a session, too.
        self._former, self._token = self._token or self._former, ""
        self._orphans = self._commands.ids()
        if not extended:
            self._give_up()
            return
        if self._former:
            await self._resume(session)
        if not self._token:
            await self._get_token(session)

    async def run_background(self, session: RpcSession) -> None:
        """Query the ends of commands that the gateway will not notify; of each the end is known then.

        Raises:
            ConnectionLost, TimeoutError: as `greet_gateway`.
        """
        orphans = self._orphans
        for first in range(0, len(orphans), _AT_ONCE):
            await asyncio.gather(*(self._find_end(session, each) for each in orphans[first : first + _AT_ONCE]))
        if self._orphans is orphans:
            self._give_up()

    def end_connection(self, reason: str, *, lost: bool, again: bool) -> None:
        """Note that the connection has ended.

        Args:
            reason: why.
            lost: it was not closed, so that its session may be resumed.
            again: another connection follows, on which the ends of commands may be notified.
        """
        self._reason = reason
        self._former, self._token = self._token if lost else "", ""
        self._stop_timer()
        if again and self._extended:
            self._orphans = self._commands.ids()
            patience = max(self._grace, PATIENCE)
            self._giving_up = asyncio.get_running_loop().call_later(patience, self._give_up)
        else:
            self._orphans = ()
            self._commands.lost(reason)

    async def _resume(self, session: RpcSession) -> None:
        params = ResumeParams(token=self._former, command_ids=self._orphans[:MAX_RESUMED])
        try:
            resumed = await ask(session, "openrois.lease.resume", params, ResumeResult, timeout=self._timeout)
        except (RoISError, RpcError) as error:
            _log.info("the lost session is not resumed: %s", error)
            self._former = ""
            return
        self._keep(resumed)
        self._former, self._orphans = "", (*resumed.forgotten, *self._orphans[MAX_RESUMED:])
        for lease in resumed.leases:
            if not self._bindings.wants(lease.component_ref):
                # It was given back while there was no connection.
                session.post("rois.command.release", {"component_ref": lease.component_ref})

    async def _get_token(self, session: RpcSession) -> None:
        try:
            self._keep(await ask(session, "openrois.lease.token", NoParams(), LeaseTokenResult, timeout=self._timeout))
        except (RoISError, RpcError) as error:
            # An application that may not bind needs no token, and some gateways have none.
            _log.debug("no resume token: %s", error)

    def _keep(self, told: LeaseTokenResult) -> None:
        self._token, self._grace = told.token, told.grace_ms * _MILLISECOND

    async def _find_end(self, session: RpcSession, command_id: str) -> None:
        """Query until two answers: a notification of the end comes right behind the first one, before the second."""
        params = CommandResultParams(command_id=command_id, condition="")
        why, answers = "it may still run at another gateway", 0
        for _ in range(_QUERIES):
            if command_id not in self._commands:
                return
            if answers == 2:
                why = "its end was notified over the lost connection, and never arrived"
                break
            try:
                await ask(session, "rois.command.get_command_result", params, ResultsResult, timeout=self._timeout)
                answers += 1
            except ComponentFailed:
                # It failed, or did not end before the gateway did: `completed` says that, too.
                answers += 1
            except TimedOut:
                # The gateway that runs it may be lost. This one has waited for some seconds, and will know.
                continue
            except (RoISError, RpcError):
                why = "the gateway does not know of it"
                break
        self._commands.lost(f"{self._reason}; {why}", (command_id,))

    def _give_up(self) -> None:
        """Give up the commands of the lost session: their ends are not notified any more."""
        self._stop_timer()
        orphans, self._orphans, self._former = self._orphans, (), ""
        self._commands.lost(self._reason, orphans)

    def _stop_timer(self) -> None:
        if self._giving_up is not None:
            self._giving_up.cancel()
            self._giving_up = None
