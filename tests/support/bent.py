"""A faulty gateway: a proxy in front of a real one that changes messages."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any

from websockets.asyncio.client import connect
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

_BROKEN = 1006

Bend = Callable[[Any, str], Sequence[Any]]
"""Takes a message and the method that it is of, or that it answers; gives what is passed on in its place."""


def straight(message: Any, _method: str) -> Sequence[Any]:
    """Pass a message on as it is."""
    return [message]


@dataclass
class Bent:
    """The proxy.

    Attributes:
        url: where applications connect.
        to_application: bends what the gateway tells applications.
        to_gateway: bends what applications ask.
        to_adapter: bends what the gateway asks adapters.
        close_code: stands in for the code with which the gateway closes.
    """

    url: str = ""
    to_application: Bend = straight
    to_gateway: Bend = straight
    to_adapter: Bend = straight
    close_code: int | None = None


class _Leg:
    """One connection through the proxy, with its requests and responses."""

    def __init__(self, bent: Bent, near: ServerConnection, far: Any) -> None:
        self.bent = bent
        self.near = near
        self.far = far
        self.is_adapter = near.request is not None and near.request.path == "/adapter"
        self.asked: dict[str, str] = {}

    async def inward(self) -> None:
        """Pass on what comes from an application or adapter."""
        with suppress(ConnectionClosed):
            async for frame in self.near:
                await self._pass(frame, self.far, straight if self.is_adapter else self.bent.to_gateway)
        if self.near.close_code == _BROKEN:
            self.far.transport.abort()
        else:
            await self.far.close()

    async def outward(self) -> None:
        """Pass on what comes from the gateway."""
        bend = "to_adapter" if self.is_adapter else "to_application"
        with suppress(ConnectionClosed):
            async for frame in self.far:
                await self._pass(frame, self.near, getattr(self.bent, bend))
        code = self.bent.close_code or self.far.close_code or 1000
        await self.near.close(code if code not in (1005, 1006) else 1000, self.far.close_reason or "")

    async def _pass(self, frame: str | bytes, to: Any, bend: Bend) -> None:
        try:
            message = json.loads(frame)
        except (ValueError, RecursionError):
            await to.send(frame)
            return
        for each in bend(message, self._method(message)):
            await to.send(frame if each is message else json.dumps(each))

    def _method(self, message: Any) -> str:
        if not isinstance(message, dict):
            return ""
        key = json.dumps(message.get("id"))
        if isinstance(message.get("method"), str):
            self.asked[key] = message["method"]
            return str(message["method"])
        return self.asked.get(key, "")


@asynccontextmanager
async def bent(url: str, **bends: Any) -> AsyncIterator[Bent]:
    """Put a proxy in front of the gateway whose applications connect to `url`."""
    proxy = Bent(**bends)

    async def handle(near: ServerConnection) -> None:
        path = near.request.path if near.request is not None else "/"
        headers = (
            {}
            if near.request is None or "Origin" not in near.request.headers
            else {"Origin": near.request.headers["Origin"]}
        )
        far_url = url.rstrip("/") + path
        async with connect(far_url, compression=None, max_size=None, max_queue=None, additional_headers=headers) as far:
            leg = _Leg(proxy, near, far)
            await asyncio.gather(leg.inward(), leg.outward())

    async with serve(handle, "127.0.0.1", 0, compression=None, max_size=None) as server:
        port = next(iter(server.sockets)).getsockname()[1]
        proxy.url = f"ws://127.0.0.1:{port}/"
        yield proxy
