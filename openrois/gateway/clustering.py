"""A gateway of a cluster: what it shares with the others, and its sessions for the applications of these."""

import logging
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from importlib import import_module
from typing import Any, cast

from openrois.errors import BadParameter
from openrois.federation.assertion import Assertion
from openrois.federation.federation import Federation
from openrois.federation.gateway_link import GatewayLink
from openrois.gateway.applications import serve_sub_session
from openrois.gateway.auth_setup import AuthSetup
from openrois.gateway.draining import RETRY_AFTER, SERVICE_RESTART
from openrois.gateway.settings import GatewaySettings
from openrois.gateway.token_expiry import TokenExpiry
from openrois.observability.health import Readiness
from openrois.ownership.directorate import Directorate
from openrois.session.session import EngineHost
from openrois.transport.stream import POLICY_VIOLATION, MessageStream

__all__ = ["ClusterParts", "Clustering"]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ClusterParts:
    """What a gateway shares with others.

    Attributes:
        link: to the other gateways, which is entered when this one serves them.
        directorate: which gateway owns which engine.
    """

    link: GatewayLink
    directorate: Directorate


class Clustering:
    """A gateway's membership in its cluster.

    Args:
        parts: what it shares with the others.
        host: its engine.

    Attributes:
        federation: the engines of all gateways, and the way to these.
    """

    def __init__(self, parts: ClusterParts, host: EngineHost) -> None:
        self.federation = Federation(parts.link, parts.directorate, host.engine)
        self._parts = parts
        self._host = host

    @classmethod
    @asynccontextmanager
    async def opened(cls, settings: GatewaySettings) -> "AsyncIterator[ClusterParts | None]":
        """Connect to what the gateways of a cluster share while the block runs; None where the gateway is on its own.

        Raises:
            StoreUnreachable: PostgreSQL is not there.
            StoreUnusable: its schema is newer than this program knows.
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

    @asynccontextmanager
    async def serving(self, auth_setup: AuthSetup, readiness: Readiness) -> AsyncIterator[None]:
        """Serve the applications of other gateways, and know the engines of these, while the block runs."""
        link, directorate = self._parts.link, self._parts.directorate
        readiness.require("NATS, which joins the gateways", lambda: not link.trouble)
        readiness.require("the store that the gateways share", lambda: not directorate.problem)
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(link)
            await stack.enter_async_context(self.federation.running())
            await link.listen(lambda stream, said: self._handle(auth_setup, stream, said))
            yield

    async def _handle(self, auth_setup: AuthSetup, stream: MessageStream, said: Mapping[str, Any]) -> None:
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
        with auth_setup.expiries.holding(expiry, stream):
            await serve_sub_session(self._host, stream, expiry, auth_setup.sign_ins)
