"""An adapter as a process of its own: its end by a signal, and what it reports to the program that started it."""

import asyncio
import os
import signal
from collections.abc import Coroutine, Sequence
from typing import Any

from openrois.adapter.dialer import serve_parent
from openrois.aio.memory_return import returning_memory
from openrois.aio.supervisor import Supervisor
from openrois.aio.tasks import TaskScope
from openrois.session.session import EngineHost
from openrois.transport.credentials import Credentials

__all__ = ["AdapterProcess", "run_until_stopped"]


async def run_until_stopped(work: Coroutine[Any, Any, None]) -> None:
    """Run to the end, or until SIGINT or SIGTERM cancels it; raises what it raises."""
    running = asyncio.create_task(work)

    def stop() -> None:
        # Once is enough: a second cancellation would cut off the orderly end that the first one began.
        if not running.cancelling():
            running.cancel()

    for name in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(name, stop)
    await asyncio.wait({running})
    if not running.cancelled():
        running.result()


class AdapterProcess:
    """The process of one adapter. It prints `ready <engine id>` once, and notifies the service manager.

    Args:
        engine_id: of the adapter.

    Attributes:
        is_attached: whether the gateway has accepted it, and the connection lasts.
    """

    def __init__(self, engine_id: str) -> None:
        self.is_attached = False
        self._engine_id = engine_id
        self._supervisor = Supervisor(os.environ)
        self._was_attached = False

    async def serve(self, host: EngineHost, gateways: Sequence[str], credentials: Credentials) -> None:
        """Serve an engine to its gateway, one of several at a time, until cancelled.

        Args:
            host: the engine.
            gateways: `ws://host:port/adapter` of each.
            credentials: for the gateways.
        """
        async with TaskScope() as tasks:
            tasks.start(self._supervisor.watch())
            tasks.start(returning_memory())
            try:
                await serve_parent(host, *gateways, credentials=credentials, attached=self._set_attached)
            finally:
                self._supervisor.notify_state("STOPPING=1")

    def _set_attached(self, is_attached: bool) -> None:
        """Note that the gateway has accepted the adapter, or that the connection has ended."""
        self.is_attached = is_attached
        if is_attached and not self._was_attached:
            self._was_attached = True
            print(f"ready {self._engine_id}", flush=True)
            self._supervisor.notify_state("READY=1")
        self._supervisor.notify_state(f"STATUS={'behind its gateway' if is_attached else 'waits for its gateway'}")
