"""The gateways of a simulation: an engine host each, as a process has it, before connections in memory."""

import time
from collections import Counter
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import AsyncExitStack, asynccontextmanager
from contextvars import copy_context
from functools import partial
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal, Role
from openrois.auth.subject_quotas import SubjectQuotas
from openrois.engine.engine import Engine
from openrois.gateway.adapters import serve_adapter
from openrois.gateway.applications import serve_application
from openrois.gateway.sign_in import SignIns
from openrois.gateway.token_expiry import TokenExpiry
from openrois.jsonrpc.protocol import decode
from openrois.leases.epochs import CountedEpochs
from openrois.session.session import EngineHost
from openrois.transport.stream import StreamClosed
from openrois_bench.simulation.meter import Account, charged
from openrois_bench.simulation.stream import BatchEnd, batch_pair

__all__ = ["Gateway", "simulated_gateways"]

_LOST: Final = 1006
"""The code of a connection that was lost."""

CAPACITY: Final = 1024
"""Messages that a connection in memory holds in each direction: a socket's buffers hold as many short ones."""


class Gateway:
    """One gateway.

    Args:
        number: of the gateway.
        tasks: owns what serves connections.
        counts: what happened, by name; shared.

    Attributes:
        host: its engine, and what its sessions share.
        of_adapters, of_applications, of_hops: what its connections to adapters, those of applications, and messages to
            other gateways are charged to.
    """

    def __init__(self, number: int, tasks: TaskScope, counts: Counter[str]) -> None:
        name = f"gateway-{number:02}"
        self.host = EngineHost(
            Engine(name), tasks, quotas=SubjectQuotas(), epochs=CountedEpochs(round(time.time() * 1000))
        )
        self.of_adapters = Account(f"{name} adapters")
        self.of_applications = Account(f"{name} applications")
        self.of_hops = Account(f"{name} hops")
        self._tasks = tasks
        self._counts = counts
        self._sign_ins = SignIns(self.host.audit)

    async def dial_adapter(self, engine_id: str) -> BatchEnd:
        """Return an adapter's end of a new connection."""
        near, far = batch_pair(CAPACITY)
        principal = Principal(f"adapter of {engine_id}", frozenset({Role.ADAPTER}), (f"{engine_id}/*",))
        expiry = TokenExpiry(principal)
        self._start(
            lambda: _served(serve_adapter(self.host, near, expiry=expiry, sign_ins=self._sign_ins)), self.of_adapters
        )
        return far

    async def dial_application(self, owner: "Gateway", subject: str, scope: str) -> BatchEnd:
        """Return an application's end of a new connection.

        Where another gateway owns its body, the session stands there. This gateway reads each message with its JSON-RPC
        parser and sends it on, both ways. What the network between two gateways costs is no part of it.
        """
        if owner is self:
            return self._dial_own(subject, scope)
        near, far = batch_pair(CAPACITY)
        beyond = owner._dial_own(subject, scope)
        for source, target in ((near, beyond), (beyond, near)):
            self._start(partial(_pass_on, source, target, self._counts), self.of_hops)
        return far

    def _dial_own(self, subject: str, scope: str) -> BatchEnd:
        near, far = batch_pair(CAPACITY)
        expiry = TokenExpiry(Principal(subject, frozenset({Role.OPERATOR}), (scope,)))
        self._start(
            lambda: _served(serve_application(self.host, near, expiry, sign_ins=self._sign_ins)), self.of_applications
        )
        return far

    def _start(self, work: Callable[[], Coroutine[Any, Any, None]], account: Account) -> None:
        """Start a task, all of whose callbacks are charged to an account."""
        context = copy_context()
        context.run(charged.set, account)
        context.run(lambda: self._tasks.start(work()))


async def _served(serving: Coroutine[Any, Any, StreamClosed]) -> None:
    await serving


async def _pass_on(source: BatchEnd, target: BatchEnd, counts: Counter[str]) -> None:
    """Pass the messages of one direction on until either side ends, and end the other one alike."""
    try:
        while True:
            text = await source.receive()
            decode(text)
            counts["hops"] += 1
            await target.send(text)
    except StreamClosed as closed:
        for end in (source, target):
            if closed.code == _LOST:
                end.abort()
            else:
                await end.close(closed.code, closed.reason)


@asynccontextmanager
async def simulated_gateways(number: int, counts: Counter[str]) -> AsyncIterator[list[Gateway]]:
    """Run gateways in this process while the block runs."""
    async with AsyncExitStack() as stack:
        yield [Gateway(each, await stack.enter_async_context(TaskScope()), counts) for each in range(number)]
