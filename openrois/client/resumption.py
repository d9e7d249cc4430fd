"""Going on where a lost connection ended: the token for it, and the commands whose end is not known meanwhile."""

import asyncio
import logging
from typing import Final

from openrois.client.asking import ask
from openrois.client.bindings import Bindings
from openrois.client.commands import Commands
from openrois.client.reconnect import Reconnect
from openrois.errors import OutOfResources, RoISError
from openrois.jsonrpc.session import RpcError, RpcSession
from openrois.types.leases import MAX_RESUMED, LeaseTokenResult, ResumeParams, ResumeResult
from openrois.types.messages import NoParams

__all__ = ["Resumption"]

_log = logging.getLogger(__name__)

RETRY: Final = 1.0
"""Seconds between two attempts while the gateway takes the lost connection for alive."""

_ATTEMPTS: Final = 15
"""Attempts; a gateway needs some ten seconds to notice that a connection is dead."""

_MILLISECOND: Final = 0.001


class Resumption:
    """What a client does about a lost connection beside making another one.

    Args:
        commands: those of the client.
        bindings: what it wants to hold.
        reconnect: how it waits.
        timeout: seconds that an answer may take.
    """

    def __init__(self, commands: Commands, bindings: Bindings, reconnect: Reconnect, timeout: float) -> None:
        self._commands = commands
        self._bindings = bindings
        self._reconnect = reconnect
        self._timeout = timeout
        self._token = ""
        self._former = ""
        self._grace = 0.0
        self._orphans: tuple[str, ...] = ()
        self._reason = ""
        self._giving_up: asyncio.TimerHandle | None = None

    async def move_in(self, session: RpcSession) -> None:
        """Resume the lost session, or at least get a token for the next time.

        Raises:
            ConnectionLost: the connection ended.
            TimeoutError: no answer in time.
        """
        if self._former:
            await self._resume(session)
        if not self._former and not self._token:
            await self._get_token(session)

    async def stay(self, session: RpcSession) -> None:
        """Try again for as long as the gateway takes the lost connection for alive.

        Raises:
            ConnectionLost, TimeoutError: as `move_in`.
        """
        for _ in range(_ATTEMPTS):
            if not self._former:
                return
            await self._reconnect.sleep(RETRY)
            await self.move_in(session)
        self.give_up()

    def move_out(self, reason: str, *, lost: bool) -> None:
        """Learn that the connection has ended: its commands may be told of yet where it was lost, and else not."""
        self._reason = reason
        if lost and self._token:
            self._stop_timer()
            self._former, self._token, self._orphans = self._token, "", self._commands.ids()
            self._giving_up = asyncio.get_running_loop().call_later(self._grace, self.give_up)
        elif not (lost and self._former):
            self._token = ""
            self.give_up()
            self._commands.lost(reason)

    async def _resume(self, session: RpcSession) -> None:
        params = ResumeParams(token=self._former, command_ids=self._orphans[:MAX_RESUMED])
        try:
            resumed = await ask(session, "openrois.lease.resume", params, ResumeResult, timeout=self._timeout)
        except OutOfResources:
            return
        except (RoISError, RpcError) as error:
            _log.info("the lost session is not resumed: %s", error)
            self.give_up()
            return
        self._stop_timer()
        self._keep(resumed)
        self._former, self._orphans = "", ()
        for lease in resumed.leases:
            if not self._bindings.wants(lease.component_ref):
                # It was given back while there was no connection.
                session.post("rois.command.release", {"component_ref": lease.component_ref})
        self._commands.lost(f"{self._reason}; the gateway does not know of it", resumed.forgotten)

    async def _get_token(self, session: RpcSession) -> None:
        try:
            self._keep(await ask(session, "openrois.lease.token", NoParams(), LeaseTokenResult, timeout=self._timeout))
        except (RoISError, RpcError) as error:
            # Whoever may not hold anything needs none, and some gateways keep nothing.
            _log.debug("no resume token: %s", error)

    def _keep(self, told: LeaseTokenResult) -> None:
        self._token, self._grace = told.token, told.grace_ms * _MILLISECOND

    def give_up(self) -> None:
        """Learn that the lost session is not resumed: nobody tells of its commands any more."""
        self._stop_timer()
        orphans, self._orphans, self._former = self._orphans, (), ""
        self._commands.lost(self._reason, orphans)

    def _stop_timer(self) -> None:
        if self._giving_up is not None:
            self._giving_up.cancel()
            self._giving_up = None
