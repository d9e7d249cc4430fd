"""A reserved body, as the application that holds it sees it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar, cast, overload

from openrois.catalog.component_type import ComponentType
from openrois.client.body_directory import Kind, code_of, urn_of
from openrois.client.component import ComponentProxy
from openrois.errors import OutOfResources

__all__ = ["Body", "Reservation", "Wanted"]

Proxy = TypeVar("Proxy", bound=ComponentProxy)


@dataclass(frozen=True, slots=True)
class Wanted:
    """What an application needs of a body.

    Attributes:
        required, optional: the component types, by their URNs.
    """

    required: Mapping[str, Kind]
    optional: Mapping[str, Kind]

    @classmethod
    def of(cls, required: Iterable[Kind], optional: Kind | Iterable[Kind]) -> "Wanted":
        """Return it for component types as `Client.body` takes them.

        Raises:
            ValueError: no type is required, or one is named twice.
            TypeError: one is no component type.
        """
        is_one = isinstance(optional, type | ComponentType | str)
        others = (cast(Kind, optional),) if is_one else cast(Iterable[Kind], optional)
        wanted = [(urn_of(kind), kind) for kind in required]
        extra = [(urn_of(kind), kind) for kind in others]
        if not wanted:
            raise ValueError("name at least one component type that the body must have: body(Navigation)")
        named = [urn for urn, _ in (*wanted, *extra)]
        if twice := sorted({code_of(urn) for urn in named if named.count(urn) > 1}):
            raise ValueError(f"{', '.join(twice)}: named twice, and a body is reserved with one component of a type")
        return cls(dict(wanted), dict(extra))

    def __str__(self) -> str:
        return " and ".join(code_of(urn) for urn in self.required)


@dataclass(eq=False, slots=True)
class Reservation:
    """Components of one engine that are reserved together.

    Attributes:
        engine_id: the engine.
        optional: the URNs of the types that may be missing.
        bound: the references of the components that are bound, by the URNs of their types.
        complete: whether the application has the body.
        error: why it is lost; None while it is not.
    """

    engine_id: str
    optional: frozenset[str]
    bound: dict[str, str] = field(default_factory=dict)
    complete: bool = False
    error: Exception | None = None

    def require_held(self) -> None:
        """Raise `OutOfResources` where a required part was lost again while others were bound."""
        if self.error is not None:
            raise OutOfResources(f"a part of {self.engine_id} was lost again: {self.error}") from self.error


class Body:
    """A reserved body: components of one engine that this application holds until the block of `Client.body` ends.

    `body[Navigation]` is its component of a type; `body.get(Reaction)` is the same for an optional one, and None where
    the body has none that was free.

    Args:
        reservation: what is bound.
        proxies: a proxy for each component that was bound, by the URN of its type.
    """

    def __init__(self, reservation: Reservation, proxies: Mapping[str, ComponentProxy]) -> None:
        self._reservation = reservation
        self._proxies = proxies

    def __repr__(self) -> str:
        return f"<Body {self.engine_id}: {', '.join(map(code_of, self._proxies))}>"

    @property
    def engine_id(self) -> str:
        """The engine that the body is; `client.control.stop_all` takes it."""
        return self._reservation.engine_id

    @property
    def error(self) -> Exception | None:
        """Why the body is lost, as the operation that found out would have raised it; None while it is held."""
        return self._reservation.error

    @overload
    def __getitem__(self, kind: type[Proxy]) -> Proxy: ...
    @overload
    def __getitem__(self, kind: ComponentType | str) -> ComponentProxy: ...
    def __getitem__(self, kind: Any) -> ComponentProxy:
        """Return the component of a type. It stays what it was when the body is lost.

        Raises:
            KeyError: the body was reserved without one.
        """
        found = self._proxies.get(urn_of(kind))
        if found is None:
            has = ", ".join(map(code_of, self._proxies))
            raise KeyError(f"{self.engine_id} is reserved without {code_of(urn_of(kind))}: there is {has}")
        return found

    @overload
    def get(self, kind: type[Proxy]) -> Proxy | None: ...
    @overload
    def get(self, kind: ComponentType | str) -> ComponentProxy | None: ...
    def get(self, kind: Any) -> ComponentProxy | None:
        """Return the component of a type that is bound now, or None."""
        urn = urn_of(kind)
        return self._proxies[urn] if urn in self._reservation.bound else None
