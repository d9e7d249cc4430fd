"""Opens connections from a client to its gateway: a WebSocket by address, or whatever else a `Dial` opens."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Final

from websockets.exceptions import InvalidHandshake, InvalidStatus

from openrois.client.errors import ConnectionFailed
from openrois.transport.address import gateway_url
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois.transport.stream import MessageStream
from openrois.transport.unreachable import unreachable
from openrois.transport.websocket import dial

__all__ = ["Dial", "websocket"]

_FINAL: Final = (401, 403)
"""Refusals after which another attempt cannot help."""

Dial = Callable[[], AbstractAsyncContextManager[MessageStream]]
"""Opens a connection for as long as the block runs; raises `OSError` or `TimeoutError` where there is none."""


def websocket(url: str, credentials: Credentials = NO_CREDENTIALS) -> Dial:
    """Return how to reach the gateway at `url`.

    Args:
        url: as `gateway_url` takes it.
        credentials: what is shown to it; a token travels in the `Authorization` header.

    Raises:
        ValueError: `url` is no address of a gateway, or carries a password.
    """
    address = gateway_url(url)

    @asynccontextmanager
    async def connect() -> AsyncIterator[MessageStream]:
        opening = dial(address, credentials=credentials, open_timeout=None)
        try:
            stream = await opening.__aenter__()
        except (InvalidHandshake, ValueError, OSError) as error:
            said = unreachable(address, error, remedies=("Client(token=...)", "Client(ca_file=...)"))
            final = isinstance(error, InvalidStatus) and error.response.status_code in _FINAL
            # The sentence has all of it; what the library says of each layer below would hide it.
            raise ConnectionFailed(said, final=final) from None
        try:
            yield stream
        finally:
            await opening.__aexit__(None, None, None)

    return connect
