"""What can be set on a gateway."""

from dataclasses import dataclass

from openrois.gateway.loopback import is_loopback
from openrois.jsonrpc.session import CALL_TIMEOUT
from openrois.types.references import flaw_of_name

__all__ = ["GatewaySettings"]

_ICE_SCHEMES = ("stun:", "stuns:")


@dataclass(frozen=True, slots=True)
class GatewaySettings:
    """The settings of one gateway.

    Attributes:
        host: the address to listen on. Only loopback addresses are accepted: there is no authentication yet.
        port: the TCP port, 0 for any free one.
        engine_id: the gateway's own id in references and profiles.
        ice_servers: STUN addresses (`stun:host:port`) that both ends of every stream use.
        adapter_timeout: seconds that an adapter has for each answer.

    Raises:
        ValueError: one of them cannot be used; the message says why.
    """

    host: str = "127.0.0.1"
    port: int = 8765
    engine_id: str = "gateway"
    ice_servers: tuple[str, ...] = ()
    adapter_timeout: float = CALL_TIMEOUT

    def __post_init__(self) -> None:
        if not is_loopback(self.host):
            raise ValueError(
                f"the gateway listens on loopback addresses only, and {self.host!r} is none: "
                "without authentication anyone who reaches it could operate every robot behind it"
            )
        if not 0 <= self.port <= 65535:
            raise ValueError(f"{self.port} is no TCP port")
        if flaw := flaw_of_name(self.engine_id):
            raise ValueError(f"{self.engine_id!r} is no engine id: {flaw}")
        for url in self.ice_servers:
            if not url.startswith(_ICE_SCHEMES) or len(url) > 512:
                raise ValueError(f"{url[:80]!r} is no address of a STUN server, such as stun:stun.example.org:3478")
        if not 0 < self.adapter_timeout < 3600:
            raise ValueError("an adapter has more than 0 and less than 3600 seconds for an answer")
