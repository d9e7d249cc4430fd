"""How a client reaches its gateway: a WebSocket by address, or whatever else a `Dial` opens."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager

from websockets.exceptions import InvalidHandshake, InvalidStatus

from openrois.client.errors import ConnectionFailed
from openrois.transport.address import gateway_url
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois.transport.stream import MessageStream
from openrois.transport.websocket import dial, refusal

__all__ = ["Dial", "websocket"]

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
        except ValueError as error:
            raise ConnectionFailed(str(error)) from error
        except InvalidStatus as error:
            final = error.response.status_code in (401, 403)
            raise ConnectionFailed(f"{address} answered {refusal(error)}", final=final) from error
        except InvalidHandshake as error:
            raise ConnectionFailed(f"what answers at {address} is no gateway: {error}") from error
        except OSError as error:
            raise ConnectionFailed(
                f"no gateway answers at {address}; `openrois gateway` starts one here ({error})"
            ) from error
        try:
            yield stream
        finally:
            await opening.__aexit__(None, None, None)

    return connect
