"""Why a gateway does not own an engine. Pure."""

from openrois.errors import OutOfResources, RoISError

__all__ = ["ClaimRefused", "GatewayReplaced"]


class ClaimRefused(OutOfResources):
    """An engine is owned through another adapter process.

    Attributes:
        engine_id: the engine.
        gateway_id: its owner.
        wait: seconds after which the claim is granted at the earliest, where the owner does not renew its own.
    """

    def __init__(self, engine_id: str, gateway_id: str, wait: float) -> None:
        super().__init__(
            f"{engine_id} is owned by gateway {gateway_id}, where another adapter process brought it: end that one, "
            f"or dial again in {wait:.1f} s, when gateway {gateway_id} may have lost it"
        )
        self.engine_id = engine_id
        self.gateway_id = gateway_id
        self.wait = wait


class GatewayReplaced(RoISError):
    """Another process runs under the id of this gateway, and has come later: it has lost all of its claims."""

    def __init__(self, gateway_id: str) -> None:
        super().__init__(
            f"another process has started as gateway {gateway_id}: give each gateway an id of its own, "
            "and end the process that is left over"
        )
