"""What can be set on a gateway."""

import ipaddress
from dataclasses import dataclass

__all__ = ["GatewaySettings"]


@dataclass(frozen=True, slots=True)
class GatewaySettings:
    """The settings of one gateway.

    Attributes:
        host: the address to listen on. Only loopback addresses are accepted: there is no authentication yet.
        port: the TCP port, 0 for any free one.
        engine_id: the gateway's own id in references and profiles.
        ice_servers: STUN addresses (`stun:host:port`) that both ends of every stream use.
    """

    host: str = "127.0.0.1"
    port: int = 8765
    engine_id: str = "gateway"
    ice_servers: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not _is_loopback(self.host):
            raise ValueError(
                f"the gateway listens on loopback addresses only, and {self.host!r} is none: "
                "without authentication anyone who reaches it could operate every robot behind it"
            )


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
