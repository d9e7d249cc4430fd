"""Ranks of principals: who goes before whom where both may operate a body. They come from tokens alone. Pure."""

from dataclasses import dataclass
from typing import Final, Self

from openrois.auth.principal import LOCAL, Principal

__all__ = ["DEFAULT_RANKS", "MAX_RANKS", "Ranks"]

DEFAULT_RANKS: Final = ("person", "agent", "script")

MAX_RANKS: Final = 8
"""Ranks that one gateway can tell apart."""

_MAX_NAME: Final = 32


@dataclass(frozen=True, slots=True)
class Ranks:
    """The ranks that a gateway knows.

    Principals of the highest one are persons, all others are programs. A rank that is not known here, such as one that
    another gateway asserts which is configured otherwise, counts as the lowest; so does `LOCAL`, a
    program beside principals with tokens. Without tokens there are no persons, and none is above another.

    Args:
        names: the highest first.

    Raises:
        ValueError: there is none, there are too many, or one is empty, too long, unprintable or named twice.
    """

    names: tuple[str, ...] = DEFAULT_RANKS

    def __post_init__(self) -> None:
        if not 0 < len(self.names) <= MAX_RANKS:
            raise ValueError(f"a gateway knows 1 to {MAX_RANKS} ranks, not {len(self.names)}")
        for name in self.names:
            if not 0 < len(name) <= _MAX_NAME or not name.isprintable() or name != name.strip():
                raise ValueError(f"{name[:80]!r} is no rank: it must have 1 to {_MAX_NAME} printable characters")
        if len(set(self.names)) < len(self.names):
            raise ValueError(f"a rank is named twice in {','.join(self.names)}")

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the ranks that are named in a text, separated by commas.

        Raises:
            ValueError: as for the class.
        """
        return cls(tuple(name.strip() for name in text.split(",")))

    def __contains__(self, name: object) -> bool:
        return name in self.names

    @property
    def lowest(self) -> str:
        """The rank of a token without one."""
        return self.names[-1]

    def is_above(self, one: Principal, other: Principal) -> bool:
        """Tell whether `one` goes before `other`; equals do not."""
        return self._level(one) < self._level(other)

    def is_person(self, principal: Principal) -> bool:
        """Tell whether a principal is of the highest rank."""
        return principal is not LOCAL and self._level(principal) == 0

    def is_program(self, principal: Principal) -> bool:
        """Tell whether a principal is of another rank than the highest; so is one without a token."""
        return principal is LOCAL or self._level(principal) > 0

    def may_hand_back(self, principal: Principal, stopped_by: str) -> bool:
        """Tell whether a principal may hand an engine back to programs: it takes a person.

        A gateway without tokens has no persons; what none has stopped may be handed back there as ever.

        Args:
            principal: asks for it.
            stopped_by: the person that has stopped the engine; empty where none has.
        """
        return self.is_person(principal) or (principal is LOCAL and not stopped_by)

    def _level(self, principal: Principal) -> int:
        return self.names.index(principal.rank) if principal.rank in self.names else len(self.names) - 1
