"""The settings of a gateway: one model for each group, and each setting in one of them only."""

from pathlib import Path
from typing import ClassVar, Final, Literal, Self

from pydantic import model_validator

from openrois.auth.loopback import is_loopback
from openrois.auth.subject_quotas import CONNECTIONS_OF_SUBJECT, SESSIONS_OF_SUBJECT, STREAMS_OF_SUBJECT
from openrois.gateway.access_settings import Authentication, Encryption
from openrois.gateway.connection_limits import MAX_ADAPTERS, MAX_APPLICATIONS, MAX_PER_ADDRESS, MOST
from openrois.gateway.settings_group import SettingsGroup, require_between, setting
from openrois.gateway.stalling import STALL_TIMEOUT
from openrois.http_limits.header_timeout import MAX_SILENT, MAX_SILENT_PER_ADDRESS
from openrois.jsonrpc.session import CALL_TIMEOUT
from openrois.jsonrpc.unread import MAX_UNREAD
from openrois.leases.model import GRACE, LOAN, PATIENCE
from openrois.metrics.server import metrics_address
from openrois.types.leases import MAX_LOAN_MS
from openrois.types.references import flaw_of_name

__all__ = ["GROUPS", "SECRET_LENGTH", "GatewaySettings"]

SECRET_LENGTH = 16
"""Characters that a secret has at least, so that it cannot be guessed."""

_URL_LIMIT = 512
_LEAST_UNREAD = 1 << 20


class Listening(SettingsGroup):
    """The gateway's address and name."""

    table: ClassVar[str] = "listen"

    host: str = setting("127.0.0.1", "address to listen on; one that is not loopback needs authentication and TLS")
    port: int = setting(8765, "TCP port, 0 for any free one")
    engine_id: str = setting("gateway", "the gateway's own id in references and profiles", metavar="ID")
    most_applications: int = setting(MAX_APPLICATIONS, "applications at a time, of about 90 KiB each", metavar="COUNT")
    most_adapters: int = setting(MAX_ADAPTERS, "adapters at a time, of about 70 KiB each", metavar="COUNT")
    per_address: int = setting(MAX_PER_ADDRESS, "applications from one address at a time", metavar="COUNT")

    silent: int = setting(MAX_SILENT, "connections at a time that have sent no request yet", metavar="COUNT")
    silent_per_address: int = setting(MAX_SILENT_PER_ADDRESS, "of those from one address", metavar="COUNT")

    @model_validator(mode="after")
    def _check_listening(self) -> Self:
        require_between("--port", self.port, 0, 65535)
        require_between("--most-applications", self.most_applications, 1, MOST)
        require_between("--most-adapters", self.most_adapters, 1, MOST)
        if self.per_address < 1:
            raise ValueError(f"--per-address must be at least 1, not {self.per_address}")
        if self.silent < 1:
            raise ValueError(f"--silent must be at least 1, not {self.silent}")
        require_between("--silent-per-address", self.silent_per_address, 1, self.silent)
        if flaw := flaw_of_name(self.engine_id):
            raise ValueError(f"--engine-id {self.engine_id!r} is not valid: {flaw}")
        return self


class Streams(SettingsGroup):
    """Networking of streams, for both of their ends."""

    table: ClassVar[str] = "streams"

    ice_servers: tuple[str, ...] = setting((), "a STUN server for streams, stun:HOST:PORT", metavar="URL")
    turn: tuple[str, ...] = setting((), "a TURN server for streams, turn:HOST:PORT or turns:HOST:PORT", metavar="URL")
    turn_secret: str = setting("", "what the TURN server's credentials are made with", secret=True)
    turn_ttl: int = setting(600, "seconds that each credential for the TURN server holds", metavar="SECONDS")

    @model_validator(mode="after")
    def _check_streams(self) -> Self:
        for url in self.ice_servers:
            if not url.startswith("stun:") or not _is_url(url):
                raise ValueError(f"{url[:80]!r} is no STUN address: write it as stun:stun.example.org:3478")
        for url in self.turn:
            if not url.startswith(("turn:", "turns:")) or not _is_url(url):
                raise ValueError(f"{url[:80]!r} is no TURN address: write it as turn:turn.example.org:3478")
        if bool(self.turn) != bool(self.turn_secret):
            raise ValueError("--turn and --turn-secret-file must be given together")
        if self.turn and len(self.turn_secret) < SECRET_LENGTH:
            raise ValueError(
                f"the TURN secret must have at least {SECRET_LENGTH} characters, not {len(self.turn_secret)}"
            )
        require_between("--turn-ttl", self.turn_ttl, 60, 86400, "seconds")
        return self


class Adapters(SettingsGroup):
    """The treatment of adapters."""

    table: ClassVar[str] = "adapters"

    adapter_timeout: float = setting(CALL_TIMEOUT, "seconds that an adapter has for each answer", metavar="SECONDS")

    @model_validator(mode="after")
    def _check_adapters(self) -> Self:
        if not 0 < self.adapter_timeout < 3600:
            raise ValueError(
                f"--adapter-timeout must be more than 0 and less than 3600 seconds, not {self.adapter_timeout:g}"
            )
        return self


class Leases(SettingsGroup):
    """Duration of an application's control of a component."""

    table: ClassVar[str] = "leases"

    lease_grace: float = setting(
        GRACE, "seconds that a lease survives a lost connection, 0 for not at all", metavar="SECONDS"
    )
    lease_answer: float = setting(
        PATIENCE, "seconds that a holder has to answer who asks for its component", metavar="SECONDS"
    )

    lease_loan: float = setting(
        LOAN, "seconds for which a part is taken from a holder of lower rank", metavar="SECONDS"
    )

    @model_validator(mode="after")
    def _check_leases(self) -> Self:
        require_between("--lease-grace", self.lease_grace, 0, 30, "seconds")
        require_between("--lease-answer", self.lease_answer, 1, 3600, "seconds")
        require_between("--lease-loan", self.lease_loan, 1, MAX_LOAN_MS / 1000, "seconds")
        return self


class Quotas(SettingsGroup):
    """Limits of connections, each and together."""

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
        for option, count in (
            ("--subject-connections", self.subject_connections),
            ("--subject-streams", self.subject_streams),
        ):
            if count < 1:
                raise ValueError(f"{option} must be at least 1, not {count}")
        if self.subject_sessions < self.subject_connections:
            raise ValueError(
                f"--subject-sessions must be at least --subject-connections ({self.subject_connections}), "
                f"not {self.subject_sessions}: each connection has a session"
            )
        if self.unread < _LEAST_UNREAD:
            raise ValueError(f"--unread must be at least {_LEAST_UNREAD}, which one reply may take, not {self.unread}")
        require_between("--stall-timeout", self.stall_timeout, 1, 3600, "seconds")
        return self


class Operation(SettingsGroup):
    """Reports of the gateway to its operators, and its end."""

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
        require_between("--drain", self.drain, 0, 3600, "seconds")
        if self.metrics is not None and not is_loopback(metrics_address(self.metrics)[0]) and not self.metrics_token:
            raise ValueError(f"--metrics {self.metrics} is beyond this machine: give a token with --metrics-token-file")
        if self.metrics_token and len(self.metrics_token) < SECRET_LENGTH:
            raise ValueError(
                f"the token of the figures must have at least {SECRET_LENGTH} characters, not {len(self.metrics_token)}"
            )
        return self


class Clustering(SettingsGroup):
    """The other gateways, and what they share."""

    table: ClassVar[str] = "cluster"

    gateway_id: str = setting("", "this gateway's own id among those of its cluster", metavar="ID")
    cluster: tuple[str, ...] = setting((), "NATS that joins the gateways, nats://HOST:PORT or tls://", metavar="URL")
    cluster_name: str = setting("openrois", "tells this cluster from others at the same NATS", metavar="NAME")
    cluster_credentials: Path | None = setting(
        None, "a token for NATS in one line, or a user and a password in two", metavar="FILE"
    )
    cluster_ca: Path | None = setting(None, "authorities (PEM) that signed NATS's certificate", metavar="FILE")
    cluster_cert: Path | None = setting(None, "a certificate (PEM) that NATS is shown", metavar="FILE")
    cluster_key: Path | None = setting(None, "its key (PEM)", metavar="FILE")
    store: str = setting("", "PostgreSQL that the gateways share, postgresql://USER@HOST/DATABASE", metavar="URL")
    store_password: Path | None = setting(None, "its password; without it libpq's own file counts", metavar="FILE")

    @model_validator(mode="after")
    def _check_cluster(self) -> Self:
        if bool(self.cluster) != bool(self.store):
            raise ValueError("--cluster and --store must be given together: gateways share NATS and PostgreSQL")
        if self.cluster and not self.gateway_id:
            raise ValueError("--cluster needs --gateway-id: a name of its own for each gateway, for ever")
        if not self.cluster and self.gateway_id:
            raise ValueError("--gateway-id is of no use without --cluster")
        return self


class GatewaySettings(Listening, Authentication, Encryption, Streams, Adapters, Leases, Quotas, Operation, Clustering):
    """The settings of one gateway.

    Raises:
        ValueError: one of them cannot be used; the message says why.
    """

    @model_validator(mode="after")
    def _check_journal(self) -> Self:
        if self.store and self.journal is not None:
            raise ValueError("--journal is of no use with --store, which keeps what runs")
        return self

    @model_validator(mode="after")
    def _check_exposure(self) -> Self:
        if self.auth_local and self.cluster:
            raise ValueError("--auth-local cannot be used with --cluster: no other gateway knows the key")
        if self.tls_elsewhere and not self.is_authenticated:
            raise ValueError(
                "--tls-elsewhere needs authentication (--auth-key or --auth-jwks): every client that what is in front "
                "admits could operate every robot behind it"
            )
        if is_loopback(self.host):
            return self
        if self.auth_local:
            raise ValueError(
                f"--host {self.host} is no loopback address: --auth-local, which asks for no token, is for this "
                "machine alone"
            )
        if not self.is_authenticated:
            raise ValueError(
                f"--host {self.host} is no loopback address and needs authentication (--auth-key or --auth-jwks): "
                "every client that reaches it could operate every robot behind it"
            )
        if self.tls_cert is None and not self.tls_elsewhere:
            raise ValueError(
                f"--host {self.host} is no loopback address and needs TLS (--tls-cert and --tls-key): tokens could be "
                "read on their way; give --tls-elsewhere where something in front of the gateway does TLS"
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
    Clustering,
)
"""The tables of the configuration file, in its order."""


def _is_url(text: str) -> bool:
    return len(text) <= _URL_LIMIT and text.isascii() and text.isprintable() and " " not in text
