"""What can be set on a gateway."""

from dataclasses import dataclass, field

from openrois.gateway.loopback import is_loopback
from openrois.jsonrpc.session import CALL_TIMEOUT
from openrois.types.references import flaw_of_name

__all__ = ["SECRET_LENGTH", "GatewaySettings"]

SECRET_LENGTH = 16
"""Characters that a secret has at least; who guesses it relays over the server at will."""

_URL_LIMIT = 512


@dataclass(frozen=True, slots=True)
class GatewaySettings:
    """The settings of one gateway.

    Attributes:
        host: the address to listen on. Only loopback addresses are accepted: there is no authentication yet.
        port: the TCP port, 0 for any free one.
        engine_id: the gateway's own id in references and profiles.
        ice_servers: STUN addresses (`stun:host:port`) that both ends of every stream use.
        turn: TURN addresses (`turn:host:port`, `turns:host:port`) whose server knows `turn_secret`.
        turn_secret: what it makes short-lived credentials with (coturn's `static-auth-secret`).
        turn_ttl: seconds for which credentials hold.
        adapter_timeout: seconds that an adapter has for each answer.

    Raises:
        ValueError: one of them cannot be used; the message says why.
    """

    host: str = "127.0.0.1"
    port: int = 8765
    engine_id: str = "gateway"
    ice_servers: tuple[str, ...] = ()
    turn: tuple[str, ...] = ()
    turn_secret: str = field(default="", repr=False)
    turn_ttl: int = 600
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
            if not url.startswith("stun:") or not _is_url(url):
                raise ValueError(f"{url[:80]!r} is no address of a STUN server, such as stun:stun.example.org:3478")
        for url in self.turn:
            if not url.startswith(("turn:", "turns:")) or not _is_url(url):
                raise ValueError(f"{url[:80]!r} is no address of a TURN server, such as turn:turn.example.org:3478")
        self._check_turn()
        if not 0 < self.adapter_timeout < 3600:
            raise ValueError("an adapter has more than 0 and less than 3600 seconds for an answer")

    def _check_turn(self) -> None:
        if bool(self.turn) != bool(self.turn_secret):
            raise ValueError("a TURN server and the secret that it shares with the gateway are given together")
        if self.turn and len(self.turn_secret) < SECRET_LENGTH:
            raise ValueError(f"the secret of the TURN server has at least {SECRET_LENGTH} characters")
        if not 60 <= self.turn_ttl <= 86400:
            raise ValueError("credentials for the TURN server hold for 60 to 86400 seconds")


def _is_url(text: str) -> bool:
    return len(text) <= _URL_LIMIT and text.isascii() and text.isprintable() and " " not in text
