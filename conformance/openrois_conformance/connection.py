"""One WebSocket to the gateway under test: everything on it is kept in the transcript, and every wait is bounded."""

import asyncio
import json
from typing import Any

from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from openrois_conformance.deviation import Deviation, shown
from openrois_conformance.transcript import Transcript

__all__ = ["Connection"]


class Connection:
    """One open connection.

    Args:
        socket: the WebSocket.
        name: what it is called in the transcript.
        transcript: keeps what is said.
        patience: seconds to wait for anything.
    """

    def __init__(self, socket: ClientConnection, name: str, transcript: Transcript, patience: float) -> None:
        self.socket = socket
        self.name = name
        self.patience = patience
        self._transcript = transcript

    @property
    def is_open(self) -> bool:
        """Whether neither side has closed it."""
        return self.socket.close_code is None

    async def send(self, message: Any) -> None:
        """Send a frame: text as it is, bytes as a binary frame, anything else as JSON."""
        frame = message if isinstance(message, str | bytes) else json.dumps(message, ensure_ascii=False)
        self._transcript.note(self.name, frame if isinstance(frame, str) else repr(frame), outgoing=True)
        try:
            await self.socket.send(frame)
        except ConnectionClosed as closed:
            raise _broken(closed) from None

    async def receive(self) -> Any:
        """Return what the next frame says.

        Raises:
            Deviation: none came in time, it is no text, or no JSON, or the connection has ended.
        """
        try:
            async with asyncio.timeout(self.patience):
                frame = await self.socket.recv()
        except TimeoutError:
            raise Deviation(f"a frame within {self.patience:g} s", "nothing") from None
        except ConnectionClosed as closed:
            raise _broken(closed) from None
        self._transcript.note(self.name, frame if isinstance(frame, str) else repr(frame), outgoing=False)
        if not isinstance(frame, str):
            raise Deviation("text frames", "a binary frame")
        try:
            return json.loads(frame)
        except ValueError:
            raise Deviation("JSON", shown(frame)) from None

    async def closed(self) -> tuple[int, str]:
        """Wait until the gateway closes the connection and return its code and reason."""
        try:
            async with asyncio.timeout(self.patience):
                await self.socket.wait_closed()
        except TimeoutError:
            raise Deviation(f"the connection to be closed within {self.patience:g} s", "it is open") from None
        code, reason = self.socket.close_code or 1006, self.socket.close_reason or ""
        self._transcript.note(self.name, f"closed with {code} {reason}".rstrip(), outgoing=False)
        return code, reason


def _broken(closed: ConnectionClosed) -> Deviation:
    frame = closed.rcvd
    how = "broken off" if frame is None else f"closed with {frame.code} {frame.reason}".rstrip()
    return Deviation("an open connection", how)
