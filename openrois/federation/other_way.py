"""A way of STOP between gateways beside their link. Pure."""

from typing import Protocol

from openrois.cluster.postgres.stop_messages import StopAnswer

__all__ = ["OtherWay"]


class OtherWay(Protocol):
    """A way of STOP to other gateways beside the link."""

    async def ask(self, gateway_id: str, engine_id: str, subject: str, *, rank: str, stop_id: str) -> StopAnswer:
        """Ask the owner of an engine to stop everything on it; return what became of that, in half a second."""
        ...
