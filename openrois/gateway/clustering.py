"""A gateway of a cluster: what it shares with the others, and its sessions for the applications of these."""

import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Collection, Mapping
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import Any, Final, Protocol, cast

from openrois.auth.principal import Principal
from openrois.cluster.postgres.stop_messages import StopAnswer
from openrois.commands.stop import stop_components
from openrois.errors import BadParameter, StoreUnreachable, Unsupported
from openrois.federation.assertion import Assertion
from openrois.federation.federation import Federation
from openrois.federation.gateway_link import GatewayLink, GatewayStream
from openrois.federation.lines import Lines
from openrois.federation.other_way import OtherWay
from openrois.federation.shared_quotas import SharedQuotas
from openrois.gateway.applications import serve_sub_session
from openrois.gateway.auth_setup import AuthSetup
from openrois.gateway.claims import GatewayClaims
from openrois.gateway.draining import RETRY_AFTER, SERVICE_RESTART
from openrois.gateway.settings import GatewaySettings
from openrois.gateway.token_expiry import TokenExpiry
from openrois.journal.journal import Journal
from openrois.leases.epochs import ClaimedEpochs
from openrois.observability.health import Readiness
from openrois.ownership.directorate import Directorate
from openrois.resumption.holdings_writer import HoldingsWriter
from openrois.resumption.store import ResumeStore
from openrois.session.session import EngineHost
from openrois.transport.stream import POLICY_VIOLATION
from openrois.types.stops import new_stop_id

__all__ = ["ClusterParts", "Clustering"]

_log = logging.getLogger(__name__)

LOOK_AGAIN: Final = 0.5
"""Seconds between two looks for the former holders of engines that were taken while the store did not answer."""

SETTLING_TIME: Final = 1.0
"""Seconds that the end of a gateway waits for the store, before its adapters go to another one."""

_CUT: Final = 1006


class ServedStops(OtherWay, Protocol):
    """STOP by the store, both ways."""

    def serve(self, handler: Callable[[str, str, str, str], Awaitable[StopAnswer]]) -> Callable[[], None]:
        """Answer with `handler`; return a function that ends that.

        It gets an engine, a subject and its rank, and the id of the STOP.
        """
        ...


@dataclass(frozen=True, slots=True)
class ClusterParts:
    """What a gateway shares with others.

    Attributes:
        link: to the other gateways, which is entered when this one serves them.
        directorate: which gateway owns which engine.
        journal: which commands were accepted, and how they ended.
        resume_store: which sessions can be resumed, and what they hold.
        stops: STOP of other gateways, and to them, where the link fails.
        epochs: of the engines that this gateway owns.
    """

    link: GatewayLink
    directorate: Directorate
    journal: Journal
    resume_store: ResumeStore
    stops: ServedStops
    epochs: ClaimedEpochs


class Clustering:
    """A gateway's membership in its cluster.

    Args:
        parts: what it shares with the others.
        host: its engine.

    Attributes:
        federation: the engines of all gateways, and the way to these.
        claims: of the engines whose adapters are here.
        parts: what it shares with the others.
        writer: writes what is held here to the store.
        sub_sessions: number of sessions here of applications of other gateways, and of these gateways themselves.
    """

    def __init__(self, parts: ClusterParts, host: EngineHost) -> None:
        self.writer = HoldingsWriter(parts.resume_store)
        self.sub_sessions = 0
        self._lines = Lines(host, self.writer)
        quotas = SharedQuotas(parts.link.gateway_id, host.quotas)
        self.federation = Federation(
            parts.link, parts.directorate, host.engine, self._lines, parts.resume_store, parts.stops, quotas
        )
        self.claims = GatewayClaims(host.engine, parts.directorate, parts.epochs)
        self.parts = parts
        self._host = host

    @classmethod
    @asynccontextmanager
    async def opened(cls, settings: GatewaySettings) -> "AsyncIterator[ClusterParts | None]":
        """Connect to what the gateways of a cluster share while the block runs; None where the gateway is on its own.

        Raises:
            StoreUnreachable: PostgreSQL is not there.
            StoreUnusable: its schema is newer than this program can read.
            MissingExtra: the extra `cluster` is not installed.
            ValueError: an address or a file cannot be used.
        """
        if not settings.cluster:
            yield None
            return
        # A gateway on its own does without the libraries.
        module = import_module("openrois.gateway.cluster_parts")
        opening = cast(Callable[[GatewaySettings], AbstractAsyncContextManager[ClusterParts]], module.open_parts)
        async with opening(settings) as parts:
            yield parts

    @staticmethod
    async def migrate_store_back(settings: GatewaySettings) -> int:
        """Carry what the gateways of a cluster share back by one version; return the version that it had.

        Raises:
            StoreUnreachable: PostgreSQL is not there, or refuses.
            StoreUnusable: the schema has not the version of this program.
            MissingExtra: the extra `cluster` is not installed.
            ValueError: there is no store, or it cannot be used.
        """
        if not settings.store:
            raise ValueError("--migrate-store-back needs --store and --cluster, as the gateways have them")
        migrating = import_module("openrois.gateway.cluster_parts").migrate_store_back
        return await cast(Callable[[GatewaySettings], Awaitable[int]], migrating)(settings)

    @asynccontextmanager
    async def serving(self, auth_setup: AuthSetup, readiness: Readiness) -> AsyncIterator[None]:
        """Serve the applications of other gateways, and know the engines of these, while the block runs."""
        link, directorate = self.parts.link, self.parts.directorate
        readiness.require("NATS, which joins the gateways", lambda: not link.trouble)
        readiness.require("the store that the gateways share", lambda: not directorate.problem)
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(self.writer)
            await stack.enter_async_context(self.claims)
            self.claims.on_claimed = self._look_for_holders
            stack.callback(self._host.engine.changes.add(lambda change: self._lines.restore(change.engines_now)))
            stack.callback(self.parts.stops.serve(self._stop_engine))
            await stack.enter_async_context(link)
            await stack.enter_async_context(self.federation.running())
            await link.listen(lambda stream, said: self._handle(auth_setup, stream, said))
            yield

    async def settle(self) -> None:
        """Wait, for at most a moment, until the store has all that the next owners of the engines here need."""
        await self._lines.written(SETTLING_TIME)

    async def _stop_engine(self, engine_id: str, subject: str, rank: str, stop_id: str) -> StopAnswer:
        """Stop everything that acts on an engine, for a subject whose rights another gateway has checked.

        Raises:
            Unsupported: there is no such engine here.
        """
        host = self._host
        if not host.engine.tree.has_engine(engine_id):
            raise Unsupported(f"there is no engine {engine_id[:200]!r}")
        principal = Principal(subject, frozenset(), (), rank=rank)
        waiting = ", programs wait" if host.stops.stop(engine_id, principal, stop_id or new_stop_id()) else ""
        host.audit.acted(principal, "openrois.stop_all", engine_id, f"by another gateway{waiting}")
        reason = f"everything was stopped by {subject}"
        refs = host.engine.acting_of(engine_id)
        failures = await stop_components(host.engine, host.pending, host.tasks, refs, reason)
        failed = {ref: why for ref, why in failures.items() if why}
        problem = "; ".join(f"{ref}: {why}" for ref, why in failed.items())
        return StopAnswer(tuple(ref for ref in failures if ref not in failed), tuple(failed), problem=problem)

    async def _look_for_holders(self, engine_ids: Collection[str]) -> None:
        """Look which sessions have held components of engines at another gateway, before these are attached here."""
        try:
            await self._await_holders(engine_ids)
        except StoreUnreachable as error:
            _log.warning("%s: what is kept for former holders of %s waits", error, ", ".join(sorted(engine_ids)))
            self._host.tasks.start(self._look_again(engine_ids))

    async def _await_holders(self, engine_ids: Collection[str]) -> None:
        self._lines.await_engines(await self.parts.resume_store.held(engine_ids))

    async def _look_again(self, engine_ids: Collection[str]) -> None:
        """Look for former holders until the store answers, or the grace of their leases is over."""
        for _ in range(round(self._host.lease_rules.grace / LOOK_AGAIN)):
            await self._host.sleep(LOOK_AGAIN)
            with suppress(StoreUnreachable):
                await self._await_holders(engine_ids)
                self._lines.restore(each for each in engine_ids if self._host.engine.tree.has_engine(each))
                return

    async def _handle(self, auth_setup: AuthSetup, stream: GatewayStream, said: Mapping[str, Any]) -> None:
        """Serve an application of another gateway, as that gateway asserts it."""
        if self._host.draining:
            await stream.close(SERVICE_RESTART, f"retry_after={RETRY_AFTER}")
            return
        try:
            assertion = Assertion.parse(said)
            if assertion.kind == "local" and auth_setup.admission.verifier is not None:
                raise BadParameter("this gateway asks for tokens and that one does not: give both the same keys")
        except BadParameter as error:
            _log.warning("another gateway asks for a session in vain: %s", error)
            await stream.close(POLICY_VIOLATION, str(error))
            return
        expiry = TokenExpiry(assertion.principal, address=assertion.address)
        with auth_setup.expiries.holding(expiry, stream), self.federation.quotas.hearing() as hear:
            host, sign_ins, is_cut = self._host, auth_setup.sign_ins, partial(self._is_cut, stream)
            self.sub_sessions += 1
            try:
                await serve_sub_session(host, stream, expiry, sign_ins, self._lines, assertion, is_cut, hear)
            finally:
                self.sub_sessions -= 1

    def _is_cut(self, stream: GatewayStream) -> bool:
        """Tell whether another gateway may have lost a stream, and told its application that what it asked has failed.

        Where an application is lost to that gateway, its stream is closed in good order.
        """
        self.parts.link.notice_pause()
        return stream.closed is not None and stream.closed.code == _CUT
