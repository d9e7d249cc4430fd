"""The processor time of gateways, whether they are simulated or processes."""

from collections.abc import Callable, Sequence
from typing import Protocol

from openrois.aio.memory_return import resident_memory
from openrois_bench.processes.child import Child
from openrois_bench.simulation.gateways import Gateway
from openrois_bench.simulation.meter import Meter
from openrois_bench.simulation.phase import Spent

__all__ = ["Books", "ProcessBooks", "SimulatedBooks"]


class Books(Protocol):
    """What gateways spend."""

    def open(self) -> Callable[[], Spent]:
        """Begin to measure; return what tells what was spent since."""
        ...

    def resident(self) -> int:
        """Return the bytes in memory of all gateways; in a simulation also those of all peers."""
        ...


class SimulatedBooks:
    """The books of gateways in this process."""

    def __init__(self, meter: Meter, gateways: Sequence[Gateway]) -> None:
        self._meter = meter
        self._gateways = gateways

    def open(self) -> Callable[[], Spent]:
        """Begin to measure."""
        before = self._meter.read()

        def spent() -> Spent:
            now = self._meter.read()
            seconds = now.seconds_since(before)
            kinds = [
                [seconds.get(account, 0.0) for account in (each.of_adapters, each.of_applications, each.of_hops)]
                for each in self._gateways
            ]
            adapters, applications, hops = (sum(kind) for kind in zip(*kinds, strict=True))
            return Spent(tuple(map(sum, kinds)), adapters, applications, hops, now.cpu - before.cpu)

        return spent

    def resident(self) -> int:
        """Return the bytes of this process."""
        return resident_memory()


class ProcessBooks:
    """The books of a gateway that is a process of its own."""

    def __init__(self, process: Child) -> None:
        self._process = process

    def open(self) -> Callable[[], Spent]:
        """Begin to measure."""
        before = self._process.cpu()

        def spent() -> Spent:
            seconds = self._process.cpu() - before
            return Spent((seconds,), 0.0, seconds, 0.0, seconds)

        return spent

    def resident(self) -> int:
        """Return the bytes of the process."""
        return round(self._process.memory() * 1024 * 1024)
