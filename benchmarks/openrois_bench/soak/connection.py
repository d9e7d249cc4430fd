"""One WebSocket of an application of the soak: it asks, works, and may be cut off or send what is wrong.

`openrois.client` comes back when it is cut off, with all that it had; here nothing may be done for the application.
"""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any, Final

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from openrois_bench.errors import BenchFailed, within

__all__ = ["PATIENCE", "Connection", "connected"]

PATIENCE: Final = 20.0
"""Seconds for an answer."""


class Connection:
    """One connection."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self._answers: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._ended: dict[str, asyncio.Future[str]] = {}
        self._number = 0
        self.events = 0

    async def read(self) -> None:
        """Read until the connection ends; what is waited for then fails."""
        try:
            while True:
                self._take(json.loads(await self.socket.recv()))
        except ConnectionClosed:
            waiting: tuple[asyncio.Future[Any], ...] = (*self._answers.values(), *self._ended.values())
            for future in waiting:
                future.set_exception(BenchFailed("the connection has ended"))
                future.exception()

    def _take(self, message: dict[str, Any]) -> None:
        params = message.get("params", {})
        if (waiting := self._answers.pop(message.get("id") or 0, None)) is not None and "result" in message:
            waiting.set_result(message["result"])
        elif message.get("method") == "rois.command.completed" and params["command_id"] in self._ended:
            self._ended.pop(params["command_id"]).set_result(params["status"])
        elif message.get("method") == "rois.event.notify_event":
            self.events += 1

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Return the result of a request, whatever its code.

        Raises:
            BenchFailed: no answer came.
        """
        self._number += 1
        answer = self._answers[self._number] = asyncio.get_running_loop().create_future()
        request = {"jsonrpc": "2.0", "id": self._number, "method": method, "params": params}
        await self.socket.send(json.dumps(request))
        async with within(PATIENCE, method):
            result: dict[str, Any] = await answer
        return result

    async def turn(self, arm: str, times: int) -> None:
        """Turn an arm so often, one after the other, and check each end.

        Raises:
            BenchFailed: a command was refused, failed, or did not end.
        """
        for _ in range(times):
            command_id = f"c{self._number}"
            ended = self._ended[command_id] = asyncio.get_running_loop().create_future()
            unit = {"component_ref": arm, "command_type": "turn", "command_id": command_id}
            if (await self.ask("rois.command.execute", command_unit_list=[unit]))["return_code"] != "OK":
                raise BenchFailed(f"{arm} is bound and does not turn")
            async with within(PATIENCE, "the end of a command"):
                if (status := await ended) != "OK":
                    raise BenchFailed(f"a command ended with {status}")

    def cut(self) -> None:
        """End the connection without a word."""
        self.socket.transport.abort()


@asynccontextmanager
async def connected(url: str) -> AsyncIterator[Connection]:
    """Connect to the gateway at `url` for as long as the block runs."""
    address = url.replace("http", "ws", 1)
    async with connect(address, compression=None, proxy=None, open_timeout=PATIENCE) as socket:
        connection = Connection(socket)
        reading = asyncio.ensure_future(connection.read())
        try:
            yield connection
        finally:
            await socket.close()
            await reading
