"""What can be set on a gateway: one model for each group of settings, and each setting in one of them only."""

from pathlib import Path
from typing import ClassVar, Final, Literal, Self

from pydantic import model_validator

from openrois.auth.loopback import is_loopback
from openrois.auth.subject_quotas import CONNECTIONS_OF_SUBJECT, SESSIONS_OF_SUBJECT, STREAMS_OF_SUBJECT
from openrois.gateway.access_settings import Authentication, Encryption
from openrois.gateway.connection_limits import MAX_PER_ADDRESS
from openrois.gateway.settings_group import SettingsGroup, setting
from openrois.gateway.stalling import STALL_TIMEOUT
from openrois.http_limits.header_timeout import MAX_SILENT, MAX_SILENT_PER_ADDRESS
from openrois.jsonrpc.session import CALL_TIMEOUT
from openrois.jsonrpc.unread import MAX_UNREAD
from openrois.leases.model import GRACE, PATIENCE
from openrois.metrics.server import metrics_address
from openrois.types.references import flaw_of_name

__all__ = ["GROUPS", "SECRET_LENGTH", "GatewaySettings"]

SECRET_LENGTH = 16
"""Characters that a secret has at least; whoever guesses it has what it keeps."""

_URL_LIMIT = 512
_LEAST_UNREAD = 1 << 20


class Listening(SettingsGroup):
    """Where the gateway is found, and its name."""

    table: ClassVar[str] = "listen"

    host: str = setting("127.0.0.1", "address to listen on; one that is not loopback needs authentication and TLS")
    port: int = setting(8765, "TCP port, 0 for any free one")
    engine_id: str = setting("gateway", "the gateway's own id in references and profiles", metavar="ID")
    per_address: int = setting(MAX_PER_ADDRESS, "applications from one address at a time", metavar="COUNT")

    silent: int = setting(MAX_SILENT, "connections at a time that have sent no request yet", metavar="COUNT")
    silent_per_address: int = setting(MAX_SILENT_PER_ADDRESS, "of those from one address", metavar="COUNT")

    @model_validator(mode="after")
    def _check_listening(self) -> Self:
        if not 0 <= self.port <= 65535:
            raise ValueError(f"{self.port} is no TCP port")
        if self.per_address < 1:
            raise ValueError("one address has at least one connection")
        if not 1 <= self.silent_per_address <= self.silent:
            raise ValueError("silent_per_address must be between 1 and silent")
        if flaw := flaw_of_name(self.engine_id):
            raise ValueError(f"{self.engine_id!r} is no engine id: {flaw}")
        return self


class Streams(SettingsGroup):
    """What both ends of every stream use to find each other."""

    table: ClassVar[str] = "streams"

    ice_servers: tuple[str, ...] = setting((), "a STUN server for streams, stun:HOST:PORT", metavar="URL")
    turn: tuple[str, ...] = setting((), "a TURN server for streams, turn:HOST:PORT or turns:HOST:PORT", metavar="URL")
    turn_secret: str = setting("", "what the TURN server's credentials are made with", secret=True)
    turn_ttl: int = setting(600, "seconds that each credential for the TURN server holds", metavar="SECONDS")

    @model_validator(mode="after")
    def _check_streams(self) -> Self:
        for url in self.ice_servers:
            if not url.startswith("stun:") or not _is_url(url):
                raise ValueError(f"{url[:80]!r} is no address of a STUN server, such as stun:stun.example.org:3478")
        for url in self.turn:
            if not url.startswith(("turn:", "turns:")) or not _is_url(url):
                raise ValueError(f"{url[:80]!r} is no address of a TURN server, such as turn:turn.example.org:3478")
        if bool(self.turn) != bool(self.turn_secret):
            raise ValueError("a TURN server and the secret that it shares with the gateway are given together")
        if self.turn and len(self.turn_secret) < SECRET_LENGTH:
            raise ValueError(f"the secret of the TURN server has at least {SECRET_LENGTH} characters")
        if not 60 <= self.turn_ttl <= 86400:
            raise ValueError("credentials for the TURN server hold for 60 to 86400 seconds")
        return self


class Adapters(SettingsGroup):
    """How adapters are treated."""

    table: ClassVar[str] = "adapters"

    adapter_timeout: float = setting(CALL_TIMEOUT, "seconds that an adapter has for each answer", metavar="SECONDS")

    @model_validator(mode="after")
    def _check_adapters(self) -> Self:
        if not 0 < self.adapter_timeout < 3600:
            raise ValueError("an adapter has more than 0 and less than 3600 seconds for an answer")
        return self


class Leases(SettingsGroup):
    """How long somebody keeps control of a component."""

    table: ClassVar[str] = "leases"

    lease_grace: float = setting(
        GRACE, "seconds that a lease survives a lost connection, 0 for not at all", metavar="SECONDS"
    )
    lease_answer: float = setting(
        PATIENCE, "seconds that a holder has to answer who asks for its component", metavar="SECONDS"
    )

    @model_validator(mode="after")
    def _check_leases(self) -> Self:
        if not 0 <= self.lease_grace <= 30:
            raise ValueError("a lease survives a lost connection for 0 to 30 seconds")
        if not 1 <= self.lease_answer <= 3600:
            raise ValueError("a holder has 1 to 3600 seconds to answer")
        return self


class Quotas(SettingsGroup):
    """What connections may take of the gateway, each and together."""

    table: ClassVar[str] = "quotas"

    subject_connections: int = setting(
        CONNECTIONS_OF_SUBJECT, "applications at a time that show tokens of one subject", metavar="COUNT"
    )
    subject_sessions: int = setting(
        SESSIONS_OF_SUBJECT, "sessions of one subject, those that may be resumed included", metavar="COUNT"
    )
    subject_streams: int = setting(STREAMS_OF_SUBJECT, "streams of one subject", metavar="COUNT")
    unread: int = setting(
        MAX_UNREAD, "characters that wait to be read on all connections; beyond, the fullest is cut", metavar="COUNT"
    )
    stall_timeout: float = setting(
        STALL_TIMEOUT, "seconds that a connection on which something waits may take no byte", metavar="SECONDS"
    )

    @model_validator(mode="after")
    def _check_quotas(self) -> Self:
        if min(self.subject_connections, self.subject_streams) < 1:
            raise ValueError("subject_connections and subject_streams must be at least 1")
        if self.subject_sessions < self.subject_connections:
            raise ValueError("subject_sessions must be at least subject_connections, each of which has one")
        if self.unread < _LEAST_UNREAD:
            raise ValueError(f"unread must be at least {_LEAST_UNREAD}, which one reply may take")
        if not 1 <= self.stall_timeout <= 3600:
            raise ValueError("stall_timeout must be between 1 and 3600 seconds")
        return self


class Operation(SettingsGroup):
    """What the gateway tells those who operate it."""

    table: ClassVar[str] = "operation"

    verbose: bool = setting(False, "log more")
    log_format: Literal["text", "json"] = setting("text", "log lines for people or JSON objects", metavar="FORMAT")
    log_file: Path | None = setting(None, "append log lines instead of writing them to standard error", metavar="FILE")
    metrics: str | None = setting(None, "serve figures for Prometheus there, at /metrics", metavar="HOST:PORT")
    metrics_token: str = setting("", "the bearer token that readers of the figures have to show", secret=True)
    drain: float = setting(
        20.0, "seconds that what runs has to end when the gateway is told to stop", metavar="SECONDS"
    )
    journal: Path | None = setting(None, "keep what runs, for applications that ask after a restart", metavar="FILE")
    audit_file: Path | None = setting(None, "append who did what and what was refused, as JSON lines", metavar="FILE")

    @model_validator(mode="after")
    def _check_operation(self) -> Self:
        if not 0 <= self.drain <= 3600:
            raise ValueError("drain is 0 to 3600 seconds for what runs")
        if self.metrics is not None and not is_loopback(metrics_address(self.metrics)[0]) and not self.metrics_token:
            raise ValueError(f"figures at {self.metrics!r}, beyond this machine, need a token: --metrics-token-file")
        if self.metrics_token and len(self.metrics_token) < SECRET_LENGTH:
            raise ValueError(f"the token of the figures has at least {SECRET_LENGTH} characters")
        return self


class GatewaySettings(Listening, Authentication, Encryption, Streams, Adapters, Leases, Quotas, Operation):
    """The settings of one gateway.

    Raises:
        ValueError: one of them cannot be used; the message says why.
    """

    @model_validator(mode="after")
    def _check_exposure(self) -> Self:
        if self.tls_elsewhere and not self.is_authenticated:
            raise ValueError(
                "--tls-elsewhere: what is in front lets others in, and without authentication (--auth-key or "
                "--auth-jwks) they could operate every robot behind it"
            )
        if is_loopback(self.host):
            return self
        if not self.is_authenticated:
            raise ValueError(
                f"{self.host!r} is no loopback address: without authentication (--auth-key or --auth-jwks) "
                "anyone who reaches it could operate every robot behind it"
            )
        if self.tls_cert is None and not self.tls_elsewhere:
            raise ValueError(
                f"{self.host!r} is no loopback address: without TLS (--tls-cert and --tls-key) whoever is on the way "
                "could read the tokens; --tls-elsewhere where something in front of the gateway does TLS"
            )
        return self


GROUPS: Final[tuple[type[SettingsGroup], ...]] = (
    Listening,
    Authentication,
    Encryption,
    Streams,
    Adapters,
    Leases,
    Quotas,
    Operation,
)
"""The tables of the configuration file, in its order."""


def _is_url(text: str) -> bool:
    return len(text) <= _URL_LIMIT and text.isascii() and text.isprintable() and " " not in text
