"""Principals: roles, the one table of what each role may call, and scopes of components. Pure."""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from fnmatch import translate
from functools import lru_cache
from types import MappingProxyType
from typing import Final

__all__ = ["ALLOWED", "LOCAL", "Principal", "Role", "engines_named", "quota_name"]

_UP_TO_WILDCARD: Final = re.compile(r"[^*?\[]*")


class Role(StrEnum):
    """The roles of a principal."""

    VIEWER = "viewer"
    VISITOR = "visitor"
    LISTENER = "listener"
    MAINTENANCE = "maintenance"
    OPERATOR = "operator"
    ADMINISTRATOR = "administrator"
    ADAPTER = "adapter"


_WATCHERS: Final = frozenset({Role.VIEWER, Role.VISITOR, Role.LISTENER, Role.OPERATOR, Role.ADMINISTRATOR})
_READERS: Final = _WATCHERS | {Role.MAINTENANCE}
_OPERATORS: Final = frozenset({Role.OPERATOR, Role.ADMINISTRATOR})

ALLOWED: Final[Mapping[str, frozenset[Role]]] = MappingProxyType(
    {
        "rois.system.connect": _READERS,
        "rois.system.disconnect": _READERS,
        "rois.system.get_profile": _READERS,
        "rois.system.get_error_detail": _READERS,
        "rois.command.search": _READERS,
        "rois.command.bind": _OPERATORS,
        "rois.command.bind_any": _OPERATORS,
        "rois.command.release": _OPERATORS,
        "rois.command.get_parameter": _READERS,
        "rois.command.set_parameter": _OPERATORS,
        "rois.command.execute": _OPERATORS,
        "rois.command.get_command_result": _READERS,
        "rois.query.query": _READERS,
        "rois.event.subscribe": _READERS,
        "rois.event.unsubscribe": _READERS,
        "rois.event.get_event_detail": _READERS,
        "rois.stream.connect_stream": _WATCHERS,
        "rois.stream.disconnect_stream": _WATCHERS,
        "rois.stream.suspend_stream": _WATCHERS,
        "rois.stream.resume_stream": _WATCHERS,
        "rois.stream.query_stream_status": _WATCHERS,
        "rois.stream.report_playout": _WATCHERS,
        "rois.stream.set_consent": _WATCHERS,
        "signaling.answer": _WATCHERS,
        "signaling.candidate": _WATCHERS,
        "signaling.ice_servers": _WATCHERS,
        "signaling.restart": _WATCHERS,
        "openrois.hello": _READERS,
        "openrois.auth.refresh": _READERS,
        "openrois.directory.list": _READERS,
        "openrois.directory.read": _READERS,
        "openrois.directory.profiles": _READERS,
        "openrois.lease.query": _READERS,
        "openrois.lease.request": _OPERATORS,
        "openrois.lease.leave": _OPERATORS,
        "openrois.lease.grant": _OPERATORS,
        "openrois.lease.decline": _OPERATORS,
        "openrois.lease.borrow": _OPERATORS,
        "openrois.lease.give_back": _OPERATORS,
        "openrois.lease.take": frozenset({Role.ADMINISTRATOR}),
        "openrois.lease.token": _OPERATORS,
        "openrois.lease.resume": _OPERATORS,
        "openrois.stop_all": _OPERATORS,
        "openrois.lease.release_stop": _OPERATORS,
    }
)
"""Every method of the gateway and the roles that may call it. A method that is missing here is refused."""


@dataclass(frozen=True, slots=True)
class Principal:
    """A subject that has proven its identity.

    Attributes:
        subject: its name.
        roles: what it is to the system; it may do what any of them may.
        scope: patterns of component references (`avatar/*`), case-sensitive; `*` stands for any text, slashes too.
        expires: epoch seconds from which on this does not hold any more; None for always.
        token_id: the id of the token that says so; empty where it has none.
        rank: which principals it goes before (`openrois.auth.ranks`); empty counts as the lowest.
    """

    subject: str
    roles: frozenset[Role]
    scope: tuple[str, ...]
    expires: float | None = None
    token_id: str = ""
    rank: str = ""
    _methods: frozenset[str] = field(init=False, repr=False, compare=False)
    _shown: Callable[[str], object] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        # Looked up for every call and every event, so both are cached.
        object.__setattr__(self, "_methods", _methods_of(self.roles))
        object.__setattr__(self, "_shown", _matcher(self.scope))

    def may_call(self, method: str) -> bool:
        """Tell whether a role of this principal may call the method; an unknown method is refused."""
        return method in self._methods

    def sees(self, component_ref: str) -> bool:
        """Tell whether the component is in scope; to this principal a component out of scope does not exist."""
        return self._shown(component_ref) is not None

    @property
    def sees_everything(self) -> bool:
        """Whether nothing is out of its scope."""
        return "*" in self.scope

    @property
    def is_application(self) -> bool:
        """Whether it may connect where applications do."""
        return not self.roles.isdisjoint(_READERS)

    @property
    def is_adapter(self) -> bool:
        """Whether it may connect where adapters do, and offer the components in its scope."""
        return Role.ADAPTER in self.roles or self.is_administrator

    @property
    def is_administrator(self) -> bool:
        """Whether it may take from others what they hold."""
        return Role.ADMINISTRATOR in self.roles

    @property
    def is_visitor(self) -> bool:
        """Whether it may send microphone and camera to bodies that it does not operate."""
        return Role.VISITOR in self.roles

    @property
    def is_listener(self) -> bool:
        """Whether it may receive what visitors send; no other role includes that."""
        return Role.LISTENER in self.roles


def engines_named(scope: Iterable[str]) -> frozenset[str] | None:
    """Return the only engines of which a scope can show a component; None where its patterns name no engine."""
    heads = [_UP_TO_WILDCARD.match(pattern) for pattern in scope]
    literals = [(head[0], head.end() == len(head.string)) for head in heads if head is not None]
    if any("/" not in literal and not is_whole for literal, is_whole in literals):
        return None
    # A pattern without a slash that is all literal is no reference, and shows nothing.
    return frozenset(literal.partition("/")[0] for literal, _ in literals if "/" in literal)


@lru_cache(maxsize=64)
def _methods_of(roles: frozenset[Role]) -> frozenset[str]:
    return frozenset(method for method, allowed in ALLOWED.items() if not allowed.isdisjoint(roles))


@lru_cache(maxsize=1024)
def _matcher(scope: tuple[str, ...]) -> Callable[[str], object]:
    # `(?!)` matches nothing: an empty scope shows nothing.
    return re.compile("|".join(translate(pattern) for pattern in scope) or "(?!)").match


LOCAL: Final = Principal("local", frozenset({Role.ADMINISTRATOR, Role.ADAPTER, Role.VISITOR, Role.LISTENER}), ("*",))
"""Every client of a gateway of this machine that runs without authentication, and the parent of an engine."""


def quota_name(principal: Principal, connection_id: str) -> str:
    """Return the name that a connection's quotas count against: its subject; without tokens it is on its own."""
    return f"connection {connection_id}" if principal is LOCAL else f"subject {principal.subject}"
