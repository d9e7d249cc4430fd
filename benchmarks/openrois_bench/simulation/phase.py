"""What one phase of a campaign took. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass

__all__ = ["Phase", "Spent"]


@dataclass(frozen=True, slots=True)
class Spent:
    """Processor seconds between two times.

    Attributes:
        gateways: of each gateway.
        adapters, applications, hops: of all of them for connections of that kind; a real gateway does not tell these
            apart, and has all under `applications`.
        total: of all gateways, and in a simulation of all peers and the garbage collector, too.
    """

    gateways: tuple[float, ...]
    adapters: float
    applications: float
    hops: float
    total: float


@dataclass(frozen=True, slots=True)
class Phase:
    """What one phase took.

    Attributes:
        name: of the phase.
        seconds: virtual ones.
        counts: what happened in it, by name.
        spent: processor seconds.
        resident: bytes that the process has in memory at its end.
    """

    name: str
    seconds: float
    counts: Mapping[str, int]
    spent: Spent
    resident: int

    @property
    def cpu(self) -> float:
        """Processor seconds of all gateways for bodies and sessions that they own."""
        return self.spent.adapters + self.spent.applications

    @property
    def busiest(self) -> float:
        """The share of a processor that the busiest gateway took."""
        return max(self.spent.gateways) / self.seconds if self.seconds else 0.0
