"""The way to a gateway: the address, the token, and TLS where the address asks for it."""

import logging
import ssl
from dataclasses import dataclass
from typing import Any, Final

from websockets.asyncio.client import connect

from openrois.transport.credentials import NO_CREDENTIALS, Credentials

__all__ = ["Door", "door_to"]

_frames: Final = logging.getLogger(f"{__name__}.frames")
# At DEBUG the library logs every header, tokens too.
_frames.setLevel(logging.WARNING)


@dataclass(frozen=True, slots=True)
class Door:
    """The address where applications or adapters connect, with credentials.

    Attributes:
        url: the address.
        credentials: what is shown there; a token is read for each connection.
        context: what TLS is done with; None where there is none.
    """

    url: str
    credentials: Credentials = NO_CREDENTIALS
    context: ssl.SSLContext | None = None

    def opened(self, patience: float, additional_headers: dict[str, str] | None = None, **options: Any) -> connect:
        """Return a WebSocket that is yet to be opened, and takes messages of any size.

        Args:
            patience: seconds to wait for it.
            additional_headers: shown beside the token.
            options: of the WebSocket.

        Raises:
            ValueError: the token cannot be read.
        """
        return connect(
            self.url,
            additional_headers={**self.credentials.headers(), **(additional_headers or {})},
            ssl=self.context,
            compression=None,
            max_size=None,
            max_queue=None,
            open_timeout=patience,
            proxy=None,
            logger=_frames,
            **options,
        )


def door_to(url: str, credentials: Credentials) -> Door:
    """Return the door at an address.

    Raises:
        ValueError: the file with the authorities cannot be used.
    """
    return Door(url, credentials, credentials.context(url))
