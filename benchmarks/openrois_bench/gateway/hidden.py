"""Response times of the gateway for components out of scope and for absent ones, which should be equal.

Run from the repository's root: `python -m openrois_bench.gateway.hidden`.
"""

import argparse
import asyncio
import json
import random
import sys
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from math import erfc, sqrt
from pathlib import Path
from statistics import median
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal, Role
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.contract import Directory
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.applications import serve_application
from openrois.gateway.token_expiry import TokenExpiry
from openrois.session.session import EngineHost
from openrois.transport.memory import memory_pair
from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.result import write_result

ENGINES: Final = 20
ALPHA: Final = 0.01
_SEED: Final = 6


class Described(LocalRegistry):
    """Components that are described and nothing else: what is asked for here never reaches one."""

    async def discover(self) -> Directory:
        """Return all seventeen of the standard's types."""
        profiles = {f"{self.engine_id}/{kind.name}": kind.profile() for kind in BASIC_COMPONENTS}
        engine = HRIEngineProfile(identifier=RoISIdentifier(code=self.engine_id), component_ids=tuple(profiles))
        return Directory(engine, profiles)


@asynccontextmanager
async def gateway() -> AsyncIterator[EngineHost]:
    """Run a gateway with a fleet, of which one engine will be shown."""
    engine = Engine("gateway")
    for number in range(ENGINES):
        await engine.attach(Described(f"engine_{number:02}", ()))
    async with TaskScope() as tasks:
        yield EngineHost(engine, tasks)


def _condition(ref: str) -> str:
    return f"component_ref = '{ref}'"


def _unit(ref: str) -> dict[str, Any]:
    return {"component_ref": ref, "command_type": "start", "command_id": "c"}


ASKED: Final[dict[str, Callable[[str], dict[str, Any]]]] = {
    "rois.command.bind": lambda ref: {"component_ref": ref},
    "rois.command.get_parameter": lambda ref: {"component_ref": ref},
    "rois.command.execute": lambda ref: {"command_unit_list": [_unit(ref)]},
    "rois.command.search": lambda ref: {"condition": _condition(ref)},
    "rois.query.query": lambda ref: {"query_type": "component_status", "condition": _condition(ref)},
    "rois.event.subscribe": lambda ref: {"event_type": "person_detected", "condition": _condition(ref)},
    "rois.stream.connect_stream": lambda ref: {"component_ref": ref},
}


@dataclass(frozen=True, slots=True)
class Compared:
    """Two samples of one method.

    Attributes:
        hidden: median microseconds of the answers for what is out of scope.
        absent: of those for what does not exist.
        p: how likely samples as different as these are where nothing differs (Mann-Whitney, two-sided).
    """

    hidden: float
    absent: float
    p: float


def mann_whitney(one: list[float], other: list[float]) -> float:
    """Return the two-sided p of the rank-sum test, by the normal approximation with ties."""
    both = sorted([(value, 0) for value in one] + [(value, 1) for value in other])
    rank_sum = ties = 0.0
    start = 0
    while start < len(both):
        end = start
        while end < len(both) and both[end][0] == both[start][0]:
            end += 1
        shared = (start + 1 + end) / 2
        rank_sum += shared * sum(1 for _, which in both[start:end] if which == 0)
        ties += (end - start) ** 3 - (end - start)
        start = end
    n, m = len(one), len(other)
    mean = n * (n + m + 1) / 2
    spread = sqrt(n * m / 12 * ((n + m + 1) - ties / ((n + m) * (n + m - 1))))
    return erfc(abs(rank_sum - mean) / spread / sqrt(2)) if spread else 1.0


async def compare(times: int) -> dict[str, Compared]:
    """Ask for hidden and absent refs in random order; return what each method took."""
    chance = random.Random(_SEED)
    names = [kind.name for kind in BASIC_COMPONENTS]
    samples: dict[str, tuple[list[float], list[float]]] = {method: ([], []) for method in ASKED}
    async with gateway() as host:
        near, far = memory_pair()
        operator = Principal("operator", frozenset({Role.OPERATOR}), ("engine_00/*",))
        serving = asyncio.ensure_future(serve_application(host, far, TokenExpiry(operator)))
        number = 0
        for round_number in range(times):
            for method, build in ASKED.items():
                for which in chance.sample((0, 1), 2):
                    engine_id = f"engine_{chance.randrange(1, ENGINES) + 40 * which:02}"
                    params = build(f"{engine_id}/{chance.choice(names)}")
                    number += 1
                    text = json.dumps({"jsonrpc": "2.0", "id": number, "method": method, "params": params})
                    ending = f'"id":{number},'
                    began = time.perf_counter_ns()
                    await near.send(text)
                    while ending not in await near.receive():
                        pass
                    taken = (time.perf_counter_ns() - began) / 1000
                    if round_number >= times // 10:
                        samples[method][which].append(taken)
        await near.close()
        await serving
    return {
        method: Compared(median(one), median(other), mann_whitney(one, other))
        for method, (one, other) in samples.items()
    }


def main() -> int:
    """Compare, print a table, and fail where a method tells one from the other by its time."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.gateway.hidden", description=__doc__)
    parser.add_argument("--times", type=int, default=5000, help="answers of each kind and method")
    parser.add_argument("--json", type=Path, help="write what was measured to this file")
    options = parser.parse_args()
    before = load()
    measured = asyncio.run(compare(options.times))
    # One of so many tests is below ALPHA by chance more often than ALPHA says (Bonferroni).
    limit = ALPHA / len(measured)
    for method, found in measured.items():
        verdict = "differs" if found.p < limit else "alike"
        print(
            f"{method:30} hidden {found.hidden:7.1f} us   absent {found.absent:7.1f} us   p {found.p:.3f}   {verdict}"
        )
    figures = {method: {"hidden_us": f.hidden, "absent_us": f.absent, "p": f.p} for method, f in measured.items()}
    write_result(
        options.json, "openrois_bench.gateway.hidden", conditions(before), times=options.times, methods=figures
    )
    return 1 if any(found.p < limit for found in measured.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
