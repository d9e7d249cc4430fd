"""Rules for web pages that connect, by their whole origin, and for the names that the gateway answers to. Pure."""

import re
from dataclasses import dataclass
from typing import Final

from openrois.auth.loopback import is_loopback

__all__ = ["Origin", "OriginRules", "parse_origin"]

_ORIGIN: Final = re.compile(r"(https?)://(\[[0-9a-f:.]{2,45}\]|[a-z0-9_.-]{1,253})(?::([0-9]{1,5}))?")
_PORTS: Final = {"http": 80, "https": 443}


@dataclass(frozen=True, slots=True)
class Origin:
    """A web site: all three have to be the same.

    Attributes:
        scheme: `http` or `https`.
        host: in lower case, as browsers write it; an IPv6 address without brackets.
        port: the port, also where it was left out.
    """

    scheme: str
    host: str
    port: int


def parse_origin(text: str) -> Origin | None:
    """Read an origin as browsers send it, such as `https://app.example.org:8443`; None for whatever else it is."""
    found = _ORIGIN.fullmatch(text)
    if found is None:
        return None
    scheme, host, port = found.groups()
    number = _PORTS[scheme] if port is None else int(port)
    return Origin(scheme, host.strip("[]"), number) if 0 < number < 65536 else None


@dataclass(frozen=True, slots=True)
class OriginRules:
    """The origins and host names that are allowed.

    Attributes:
        origins: the sites that may connect.
        hosts: the names that the gateway is called by, in lower case, beside those of this machine.
        local: whether every page of this machine may connect: no token is needed, and being here is all there is.
        scheme: how pages of the gateway itself are reached.
    """

    origins: frozenset[Origin]
    hosts: frozenset[str]
    local: bool
    scheme: str

    def answers_to(self, host: str) -> bool:
        """Tell whether the gateway is called `host`, a request's `Host`: any other name was rebound to its address."""
        own = parse_origin(f"{self.scheme}://{host.lower()}")
        return own is not None and (is_loopback(own.host) or own.host in self.hosts)

    def admits(self, origin: str, host: str) -> bool:
        """Tell whether a page of `origin` may connect to the gateway, which it calls `host`."""
        site = parse_origin(origin)
        if site is None:
            return False
        if site in self.origins or (self.local and is_loopback(site.host)):
            return True
        return not self.local and site == parse_origin(f"{self.scheme}://{host.lower()}")
