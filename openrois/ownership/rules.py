"""The rules of ownership: whether a claim is granted or has to wait, and which epochs it reserves.

Pure. Milliseconds are of the store's clock alone; clocks of gateways are not compared.
"""

from dataclasses import dataclass
from typing import Final

from openrois.errors import BadParameter
from openrois.ownership.claims import Owner

__all__ = ["BLOCK", "MAX_EPOCH", "TTL", "Granted", "Reading", "Record", "Waiting", "judge_claim"]

BLOCK: Final = 1_000_000
"""Epochs that one claim reserves."""

MAX_EPOCH: Final = 2**53 - 1
"""The greatest epoch: the greatest number that every JSON library reads exactly."""

TTL: Final = 10.0
"""Seconds for which claims hold after a renewal."""


@dataclass(frozen=True, slots=True)
class Record:
    """What a store keeps of an engine.

    Attributes:
        engine_id: the engine.
        gateway_id: its owner; empty where it was released.
        instance: the adapter process that brought it.
        first_epoch: of the last claim. It is kept when the engine is released.
    """

    engine_id: str
    gateway_id: str
    instance: str
    first_epoch: int

    @property
    def owner(self) -> Owner | None:
        """The owner of the engine; None where it was released."""
        if not self.gateway_id:
            return None
        return Owner(self.engine_id, self.gateway_id, self.instance, self.first_epoch)


@dataclass(frozen=True, slots=True)
class Reading:
    """What a store says of an engine to a gateway that is about to claim it.

    Attributes:
        record: what it keeps of it; None for nothing.
        expires_ms: when the claims of its owner expire; 0 where it has none.
        ttl_ms: how long those hold after a renewal.
        run: the number of the process that runs as the gateway which asks, as the store has it.
        own_expires_ms: when the claims of that gateway expire, as the store has it; 0 where it does not know it.
        now_ms: when this was read.
    """

    record: Record | None
    expires_ms: int
    ttl_ms: int
    run: int
    own_expires_ms: int
    now_ms: int


@dataclass(frozen=True, slots=True)
class Granted:
    """A claim may be written.

    Attributes:
        first_epoch: the first number of its block.
        expired_ms: the expiry by which the former owner has lost the engine; the claim is void where that was renewed
            meanwhile. None where the expiry does not matter, or the store does not know the owner.
    """

    first_epoch: int
    expired_ms: int | None


@dataclass(frozen=True, slots=True)
class Waiting:
    """A claim has to wait for the owner.

    Attributes:
        gateway_id: the owner.
        seconds: until a time-out, where the owner does not renew.
    """

    gateway_id: str
    seconds: float


def judge_claim(reading: Reading, instance: str, above: int, contact: float) -> Granted | Waiting:
    """Judge the claim of a gateway on an engine.

    An engine without an owner is granted at once, and so is the same adapter process at whichever gateway: it has one
    connection, and that is the new one. Another process waits until the owner releases the engine, or until its
    claim has expired. A gateway that was out of contact with the store grants itself nothing by a time-out before
    it was in contact for as long as the owner's claims hold: where the store was away, no owner could renew.

    Args:
        reading: what the store says.
        gateway_id: of the gateway that claims.
        instance: the adapter process that it claims for.
        above: the greatest epoch that the adapter has ever seen; 0 for none.
        contact: seconds for which the gateway has been in contact with the store without a break.

    Raises:
        BadParameter: there are no epochs left behind `above`.
    """
    record = reading.record
    stored = record.first_epoch if record is not None else 0
    if record is None or not record.gateway_id or record.instance == instance:
        return Granted(_first_epoch(stored, reading.now_ms, above), None)
    left = max((reading.expires_ms - reading.now_ms) / 1000, reading.ttl_ms / 1000 - contact)
    if left > 0:
        return Waiting(record.gateway_id, left)
    return Granted(_first_epoch(stored, reading.now_ms, above), reading.expires_ms or None)


def _first_epoch(stored: int, now_ms: int, above: int) -> int:
    """Return the first epoch of a block that overlaps no former one.

    A store that has lost its last commits gives `stored` too small. Then `above` lies in the block that was lost, and
    a whole block further on is behind its end.
    """
    first = max(stored + BLOCK, now_ms, above + BLOCK if above > 0 else 0)
    if first + BLOCK - 1 > MAX_EPOCH:
        raise BadParameter(
            f"there are no epochs left behind {max(stored, above)}, which no gateway has given: restart the adapter, "
            "or give the engine another id"
        )
    return first
