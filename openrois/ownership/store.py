"""Where ownership is kept: the contract of a store, which gateways share. Pure."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

from openrois.ownership.claims import Owner
from openrois.ownership.rules import Reading, Record

__all__ = ["Digest", "Hint", "OwnershipStore", "Renewed", "digest_of"]


Digest = Mapping[str, tuple[int, int]]
"""What tells two states of a store apart: of each gateway how many engines it owns, and the sum of their epochs."""


@dataclass(frozen=True, slots=True)
class Renewed:
    """The claims of a gateway hold for another while.

    Attributes:
        run: the number of the process that runs as this gateway.
        former_expires_ms: when they would have expired without that; 0 where the store did not know the gateway.
        now_ms: the store's clock.
        digest: of all owners.
    """

    run: int
    former_expires_ms: int
    now_ms: int
    digest: Digest


Hint = Callable[[Iterable[str] | None], None]
"""Called with the engines whose owner may have changed, or with None: any of them."""


class OwnershipStore(Protocol):
    """What is asked of a store. Each method is one step that happens whole or not at all, and none is repeated.

    Each may raise `StoreUnreachable`; then it is not known whether the step was made.

    Attributes:
        name: of the store, for sentences; without credentials.
    """

    name: str

    async def register(self, gateway_id: str, ttl_ms: int) -> Renewed:
        """Begin as a gateway: what a former process under this id owned is released, and it owns nothing any more."""
        ...

    async def renew(self, gateway_id: str, run: int, ttl_ms: int) -> Renewed | None:
        """Prolong all claims of a gateway; None where a later process runs under its id.

        A store that does not know the gateway, because it lost its last commits, learns it.
        """
        ...

    async def read(self, engine_id: str, gateway_id: str) -> Reading:
        """Return what a gateway has to know to claim an engine."""
        ...

    async def write(self, record: Record, run: int, seen: Record | None, expired_ms: int | None) -> bool:
        """Write a claim if the store still has what was read, and tell whether it did.

        Args:
            record: the claim; its gateway owns the engine from then on.
            run: the number of the process; the claim is void where a later one runs as this gateway.
            seen: the record that was read.
            expired_ms: the expiry of the former owner that was read; void where it has renewed. None: it may have.
        """
        ...

    async def release(self, record: Record, run: int) -> None:
        """Release an engine, where the store has just this claim on it."""
        ...

    async def leave(self, gateway_id: str, run: int) -> None:
        """Release all engines of a gateway."""
        ...

    async def owners(self, engine_ids: Iterable[str] | None) -> list[Owner]:
        """Return the owners of these engines, or of all; engines without one are left out."""
        ...

    def listen(self, hint: Hint) -> Callable[[], None]:
        """Call `hint` when owners may have changed; return a function that ends that. Hints may be lost."""
        ...


def digest_of(owners: Iterable[Owner]) -> Digest:
    """Return the digest of these owners."""
    found: dict[str, tuple[int, int]] = {}
    for owner in owners:
        engines, epochs = found.get(owner.gateway_id, (0, 0))
        found[owner.gateway_id] = engines + 1, epochs + owner.epoch
    return found
