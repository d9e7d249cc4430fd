"""Conditions of a measurement: figures of another machine, or of a busier one, cannot be compared."""

import os
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict

__all__ = ["Conditions", "busy", "conditions", "load"]

_LIBRARIES: Final = ("openrois", "aiohttp", "pydantic", "uvloop", "websockets", "aiortc", "aioice", "av", "numpy")


class Conditions(BaseModel):
    """The machine, and how busy it was.

    A load is the number of processes that ran or wanted to, on average over the last minute, this bench included.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    cpus: int
    processor: str
    system: str
    python: str
    versions: dict[str, str]
    load_before: float
    load_after: float

    def __str__(self) -> str:
        versions = ", ".join(f"{name} {number}" for name, number in self.versions.items())
        return (
            f"{self.cpus} CPUs ({self.processor}), load {self.load_before:.1f} before and {self.load_after:.1f} after\n"
            f"Python {self.python}, {versions}; {self.system}"
        )


def load() -> float:
    """The load of this machine over the last minute."""
    return round(os.getloadavg()[0], 2)


def busy(stat: Path = Path("/proc/stat")) -> float | None:
    """CPU seconds since its start that this machine spent on any program, or its host on others; None off Linux.

    The fields of the line `cpu` are those of proc(5): user, nice, system, idle, iowait, irq, softirq, steal; those that
    follow are contained in the first two.
    """
    if not stat.is_file():
        return None
    fields = [int(field) for field in stat.read_text().split(maxsplit=9)[1:9]]
    return (sum(fields) - fields[3] - fields[4]) / os.sysconf("SC_CLK_TCK")


def conditions(load_before: float, more_versions: dict[str, str] | None = None) -> Conditions:
    """The conditions of a bench that ends now and began when the load was `load_before`."""
    return Conditions(
        cpus=os.cpu_count() or 1,
        processor=processor(Path("/proc/cpuinfo")),
        system=platform.platform(terse=True),
        python=platform.python_version(),
        versions={name: version(name) for name in _LIBRARIES} | (more_versions or {}),
        load_before=load_before,
        load_after=load(),
    )


def processor(cpuinfo: Path) -> str:
    """The processor's name as Linux tells it, or else its architecture."""
    if cpuinfo.is_file():
        for line in cpuinfo.read_text().splitlines():
            name, _, value = line.partition(":")
            if name.strip() == "model name":
                return value.strip()
    return platform.machine()
