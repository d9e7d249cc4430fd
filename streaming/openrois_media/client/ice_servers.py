"""The STUN and TURN servers of the gateway; their credentials are short-lived."""

import logging
from typing import Final

from openrois_signaling.messages import IceServer
from openrois_streaming.clock import MediaClock
from pydantic import ValidationError

from openrois.client import Client, RpcError
from openrois.jsonrpc.protocol import METHOD_NOT_FOUND

__all__ = ["IceServers"]

_MARGIN: Final = 30.0
"""Seconds before their end at which credentials are asked for anew."""


_log = logging.getLogger(__name__)


class IceServers:
    """Servers of one client's gateway.

    Attributes:
        current: the servers that were answered last.
    """

    def __init__(self, client: Client, clock: MediaClock) -> None:
        self.current: tuple[IceServer, ...] = ()
        self._client = client
        self._clock = clock
        self._stale_at = float("-inf")

    def expire(self) -> None:
        """Ask anew at the next `refresh`: another session may reach another gateway."""
        self._stale_at = float("-inf")

    async def refresh(self) -> None:
        """Ask the gateway, unless the servers are still valid. A gateway may have none.

        Raises:
            RoISError, RpcError, ConnectionLost, TimeoutError: as `Client.call`.
        """
        if self._clock.now() < self._stale_at:
            return
        try:
            answer = await self._client.call("signaling.ice_servers")
            self.current = tuple(IceServer.model_validate(each) for each in answer.get("ice_servers", ()))
            ttl = float(answer.get("ttl", 0))
        except RpcError as error:
            if error.code != METHOD_NOT_FOUND:
                raise
            self.current, ttl = (), 0.0
        except (ValidationError, TypeError) as error:
            _log.warning("the gateway's ICE servers cannot be read: %s", error)
            ttl = 0.0
        self._stale_at = self._clock.now() + max(ttl - _MARGIN, 0.0)
