"""Where PostgreSQL is, as a URL without a password. Pure."""

from dataclasses import dataclass
from ipaddress import ip_address
from typing import Final
from urllib.parse import parse_qs, unquote, urlencode, urlsplit

__all__ = ["StoreAddress", "parse_store_url"]

_SECRETS: Final = ("password", "sslpassword")
_VERIFYING: Final = ("verify-ca", "verify-full")


@dataclass(frozen=True, slots=True)
class StoreAddress:
    """A database.

    Attributes:
        url: what a connection is made with; no password is in it.
        name: hosts and database, for sentences.
    """

    url: str
    name: str


def parse_store_url(url: str, authorities: str = "") -> StoreAddress:
    """Return the address that a URL of an operator means.

    Behind the database may stand what libpq knows, as `sslmode`, `sslrootcert`, `host` for the folder of a Unix socket,
    and several hosts in a row. A server on another machine is reached by TLS, and its certificate verified by
    the authorities of this system or of `sslrootcert`, unless the URL has an `sslmode`. Of several hosts the one is
    used that accepts changes.

    Args:
        url: such as `postgresql://openrois@db.example.org/openrois`.
        authorities: a file with the authorities that this system trusts; empty where it has none.

    Raises:
        ValueError: it is no such URL, names no database, or has a password.
    """
    parts = urlsplit(url)
    if parts.scheme not in {"postgresql", "postgres"}:
        raise ValueError("the URL of a store begins with postgresql://")
    before, _, listed = parts.netloc.rpartition("@")
    try:
        given = parse_qs(parts.query, keep_blank_values=True, strict_parsing=bool(parts.query))
    except ValueError:
        raise ValueError("behind the ? of the URL of a store stand options as name=value") from None
    options = {name: values[-1] for name, values in given.items()}
    if ":" in before or any(name in options for name in _SECRETS):
        raise ValueError("the URL of a store has no password in it: write the password into a file of its own")
    database = unquote(parts.path[1:]) or options.get("dbname", "")
    if not database:
        raise ValueError("the URL of a store names a database: postgresql://user@host/database")
    hosts = [unquote(host) for host in (options.get("host", "") or listed).split(",") if host]
    if not all(map(_is_local, hosts)):
        options.setdefault("sslmode", "verify-full")
    if authorities and options.get("sslmode") in _VERIFYING:
        options.setdefault("sslrootcert", authorities)
    if len(hosts) > 1:
        options.setdefault("target_session_attrs", "read-write")
    query = f"?{urlencode(options)}" if options else ""
    return StoreAddress(
        url=f"postgresql://{parts.netloc}{parts.path}{query}",
        name=f"PostgreSQL {','.join(hosts) or 'localhost'}/{database}",
    )


def _is_local(host: str) -> bool:
    """Tell whether a host, with its port, is this machine: a Unix socket or a loopback address."""
    if host.startswith("/"):
        return True
    name = host[1:].partition("]")[0] if host.startswith("[") else host.partition(":")[0]
    try:
        return ip_address(name).is_loopback
    except ValueError:
        return name == "localhost"
