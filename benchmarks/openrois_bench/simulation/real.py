"""The same peers before a real gateway: a process of its own, over WebSockets and loopback."""

import asyncio
import secrets
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from websockets.asyncio.client import connect

from openrois.auth.issuing import issue_token
from openrois.auth.principal import Role
from openrois.transport.websocket import WebSocketStream
from openrois_bench.processes.child import Child, child
from openrois_bench.processes.files import allow_files
from openrois_bench.simulation.world import Plan

__all__ = ["RealGateway", "real_gateway"]

AT_ONCE: Final = 16
"""Connections that are opened at a time: a gateway takes few of one address that have not said what they want."""


class RealGateway:
    """A gateway of one process, with authentication.

    Args:
        process: of the gateway.
        key: file of the key for tokens.
    """

    def __init__(self, process: Child, key: Path) -> None:
        self.process = process
        self._url = process.said.rpartition(" ")[2].replace("http", "ws", 1)
        self._key = key
        self._free = asyncio.Semaphore(AT_ONCE)

    async def dial_adapter(self, engine_id: str) -> WebSocketStream:
        """Return an adapter's end of a new connection."""
        return await self._dial("adapter", self._token(f"adapter of {engine_id}", Role.ADAPTER, f"{engine_id}/*"))

    async def dial_application(self, _owner: "RealGateway", subject: str, scope: str) -> WebSocketStream:
        """Return an application's end of a new connection."""
        return await self._dial("", self._token(subject, Role.OPERATOR, scope))

    def _token(self, subject: str, role: Role, scope: str) -> str:
        return issue_token(self._key, subject, [role], (scope,), now=int(time.time()), ttl=3600)

    async def _dial(self, path: str, token: str) -> WebSocketStream:
        headers = {"Authorization": f"Bearer {token}"}
        async with self._free:
            socket = await connect(
                self._url + path,
                compression=None,
                max_size=None,
                ping_interval=None,
                proxy=None,
                additional_headers=headers,
            )
        # Without the pings of the SDK: thousands of these stand in one process.
        return WebSocketStream(socket)


@asynccontextmanager
async def real_gateway(plan: Plan) -> AsyncIterator[RealGateway]:
    """Run a gateway that takes the bodies and applications of a plan while the block runs."""
    most = str(2 * plan.applications + 8)
    allow_files(plan.bodies + 2 * plan.applications + 256)
    with TemporaryDirectory(prefix="openrois-bench-") as name:
        key = _written(Path(name, "key"), secrets.token_urlsafe(48))
        limits = ("--most-adapters", str(2 * plan.bodies + 8), "--most-applications", most, "--per-address", most)
        arguments = ("-P", "-m", "openrois_bench.simulation.unpinged", "--port", "0", *limits, "--auth-key", str(key))
        async with child(*arguments) as process:
            yield RealGateway(process, key)


def _written(file: Path, secret: str) -> Path:
    file.touch(0o600)
    file.write_text(secret)
    return file
