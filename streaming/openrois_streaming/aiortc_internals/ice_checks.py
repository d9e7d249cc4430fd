"""Connectivity checks and consent of an aioice connection, beside those that aioice makes to find its first path.

Private names in use, and why no public one does it:

* `connect` starts to ask for consent as its last step, for ever if `close` was called meanwhile.
* `_nominated` is the pair that is sent over; when its other end is silent, a pair that succeeded in a check replaces
it.
* `_query_consent_task` and `_closing` say whether consent is asked for, and whether `close` was called.
"""

import asyncio
import logging
from collections.abc import Callable
from typing import Final, Generic, TypeVar

from aioice import Candidate, ice, stun
from aioice.candidate import candidate_priority

from openrois_streaming.network.guard import Source
from openrois_streaming.tasks import OwnedTasks

ProtocolT = TypeVar("ProtocolT", bound=ice.StunProtocol)

PROOF_TRIES: Final = 3
"""Checks of a source after ICE is done; the others are 0.5, 1.5 and 3.5 s after the first one."""

_log = logging.getLogger(__name__)


def stop_consent_when_closed(connection: ice.Connection) -> None:
    """Keep `connection` from asking for consent after `close`. To be called before it connects.

    aioice continues 20 ms after `close` at the latest, and would ask for ever.
    """
    connect = connection.connect

    async def connect_unless_closed() -> None:
        await connect()
        consent = connection._query_consent_task
        if connection._closing and consent is not None:
            consent.cancel()
            await asyncio.wait({consent})
            raise ConnectionError("the connection was closed while its path was found")

    connection.connect = connect_unless_closed  # type: ignore[method-assign]


class Checks(Generic[ProtocolT]):
    """Connectivity checks beside those that aioice makes to find its first path. To be closed.

    Args:
        connection: its credentials and paths are used.
        admit: called for each source whose check succeeds.
        reject: called for each source whose check fails.
    """

    def __init__(
        self,
        connection: ice.Connection,
        admit: Callable[[ProtocolT, Source], None],
        reject: Callable[[ProtocolT, Source], None],
    ) -> None:
        self._connection = connection
        self._admit = admit
        self._reject = reject
        self._proving: set[tuple[ProtocolT, Source]] = set()
        self._tasks = OwnedTasks("ice", self._failed)

    async def answers(self, *, tries: int = 1) -> bool:
        """Check whether the other end answers on the nominated path within 0.5 s, or within 1.5 s with two `tries`.

        Every ICE agent must answer (RFC 8445 section 7.3), also without media to send.
        """
        pair = self._connection._nominated.get(1)
        return pair is not None and await self._check(pair, tries=tries)

    def prove(self, protocol: ProtocolT, source: Source) -> None:
        """Start a check of `source`, unless one is under way."""
        if (protocol, source) not in self._proving and not self._connection._closing:
            self._proving.add((protocol, source))
            self._tasks.start(self._try_to_prove(protocol, source), "check")

    async def settled(self) -> None:
        """Wait until no check is under way."""
        await self._tasks.finished()

    async def aclose(self) -> None:
        """Stop all checks."""
        await self._tasks.aclose()

    async def _try_to_prove(self, protocol: ProtocolT, source: Source) -> None:
        remote = Candidate("0", 1, "udp", candidate_priority(1, "prflx"), source[0], source[1], "prflx")
        pair = ice.CandidatePair(protocol, remote)
        try:
            if not await self._check(pair, tries=PROOF_TRIES):
                self._reject(protocol, source)
                return
            self._admit(protocol, source)
            # A path that appears while the present one is silent has replaced it, behind a NAT for example.
            if not await self.answers() and await self._check(pair, tries=PROOF_TRIES, nominate=True):
                self._connection._nominated[1] = pair
        finally:
            self._proving.discard((protocol, source))

    async def _check(self, pair: ice.CandidatePair, *, tries: int, nominate: bool = False) -> bool:
        connection = self._connection
        if connection.remote_password is None:
            return False
        try:
            _, seen_from = await pair.protocol.request(
                connection.build_request(pair, nominate=nominate),
                pair.remote_addr,
                integrity_key=connection.remote_password.encode(),
                retransmissions=tries - 1,
            )
        except (stun.TransactionError, OSError):
            return False
        return seen_from == pair.remote_addr

    def _failed(self, error: BaseException) -> None:
        _log.error("an internal error stopped a connectivity check", exc_info=error)
