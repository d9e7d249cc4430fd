"""Measured deployment: a gateway and an adapter behind it, each a process of its own, over loopback."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Final

from openrois_bench.errors import within
from openrois_bench.gateway.gauge import COMPONENT, ENGINE
from openrois_bench.gateway.load import Application, Door, applications
from openrois_bench.gateway.security import Security
from openrois_bench.processes.child import Child, child

__all__ = ["Deployment", "deployed", "request"]

ATTACHING: Final = 20.0
"""Seconds that the adapter has to stand behind its gateway."""


@dataclass(frozen=True, slots=True)
class Deployment:
    """A gateway with an adapter behind it.

    Attributes:
        gateway: its process.
        adapter: its process.
        door: where applications enter.
        certificate: what the gateway shows, and its key; empty without TLS.
    """

    gateway: Child
    adapter: Child
    door: Door
    certificate: tuple[str, ...]


def request(number: int, method: str, **params: object) -> bytes:
    """Return the text of a request."""
    return json.dumps({"jsonrpc": "2.0", "id": number, "method": method, "params": params}).encode()


@asynccontextmanager
async def deployed(security: Security, *options: str) -> AsyncIterator[Deployment]:
    """Run gateway and adapter while the block does.

    Args:
        security: how the gateway is protected.
        options: further options of the gateway.

    Raises:
        BenchFailed: one of them did not start.
    """
    with security.prepared(f"{ENGINE}/*") as secured:
        arguments = ("-P", "-m", "openrois.cli", "gateway", "--port", "0", *secured.gateway, *options)
        async with child(*arguments) as gateway:
            url = gateway.said.rpartition(" ")[2]
            door = Door(url, secured.context, secured.token)
            async with child(
                "-P", "-m", "openrois_bench.gateway.gauge", url, environment=dict(secured.adapter)
            ) as adapter:
                async with within(ATTACHING, "attaching the adapter"), applications(door, 1) as (application,):
                    await _attached(application)
                yield Deployment(gateway, adapter, door, secured.certificate)


async def _attached(application: Application) -> None:
    """Wait until the component can be found: whenever the tree of engines changes, it is looked for."""
    found = asyncio.Event()

    def on_message(message: bytes) -> None:
        if COMPONENT.encode() in message:
            found.set()
        elif b"profile_changed" in message:
            ask_discovery()

    def ask_discovery() -> None:
        application.send(request(0, "rois.command.search", condition=""))

    application.on_message = on_message
    ask_discovery()
    await found.wait()
