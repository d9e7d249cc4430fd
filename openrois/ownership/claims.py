"""Claims of gateways on engines, and the owners that follow from them. Pure."""

from dataclasses import dataclass, field

__all__ = ["Claim", "Owner"]


@dataclass(frozen=True, slots=True)
class Claim:
    """An engine that a gateway owns, with a block of epochs that no other claim on this engine has.

    The gateway numbers the holders of the engine's components from `first_epoch` on. Where it reaches `last_epoch` it
    claims again, with `above=last_epoch`.

    Attributes:
        engine_id: the engine.
        gateway_id: its owner.
        instance: the random text of the adapter process that brought the engine.
        first_epoch: the first number of the block.
        last_epoch: the last number of the block; it belongs to the block.
        until: monotonic seconds of the owner's clock until which the claim holds at least; every renewal prolongs that.
    """

    engine_id: str
    gateway_id: str
    instance: str = field(repr=False)
    first_epoch: int
    last_epoch: int
    until: float


@dataclass(frozen=True, slots=True)
class Owner:
    """The gateway that owns an engine, as every gateway sees it.

    Attributes:
        engine_id: the engine.
        gateway_id: the gateway that has the connection of its adapter.
        instance: the random text of the adapter process that brought the engine.
        epoch: the first epoch of the claim; a later claim on the same engine has a greater one.
    """

    engine_id: str
    gateway_id: str
    instance: str = field(repr=False)
    epoch: int
