"""A gateway before a fleet: what the next body costs, and what applications learn of it.

`python -m openrois_bench.gateway.fleet`, in the repository. Bodies of 17 components are attached to a gateway, a
process of its own, over loopback: most of them stubs of one process, three of them adapters of real components, each a
process. At each size of the fleet it is measured

* what CPU of the gateway the next hundred bodies take, for each of them, without what all others take while idle;
* the same while so many applications are connected that each see another body (`--scopes`; their tokens say so);
* how much memory the gateway has taken, for each body;
* how many bytes an application gets of one change, if it speaks `openrois.directory`, and what it takes to list all;
* how long searches with at most 100 hits take, asked one by one.
"""

import argparse
import asyncio
import json
import secrets
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from websockets.asyncio.client import ClientConnection, connect

from openrois.auth.issuing import issue_token
from openrois.auth.principal import Role
from openrois_bench.errors import BenchFailed, within
from openrois_bench.gateway.fleet.stubs import TOKEN_VARIABLE, body_name
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.result import write_result
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import Child, child
from openrois_bench.processes.files import allow_files

SIZES: Final = (100, 1_000, 10_000)
NEXT: Final = 100
"""Bodies whose attaching is measured at each size."""
REAL: Final = 3
_PATIENCE: Final = 600.0
_IDLE: Final = 8.0
"""Seconds for which the gateway is left alone: connections are asked for signs of life less often."""
_TOGETHER: Final = 1_000
"""Bodies of one process."""
_ASKED: Final = 20
"""How often each search is asked."""


class Asker:
    """An application of the gateway; `run` has to run.

    Attributes:
        received: bytes of all notifications, since it was set to 0.
        told: the methods of these.
    """

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self._answers: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._number = 0
        self._notified = asyncio.Event()
        self.received = 0
        self.told: list[str] = []

    async def run(self) -> None:
        """Read until the connection ends; a gateway cuts an application that does not."""
        async for text in self._socket:
            message = json.loads(text)
            if "id" in message:
                self._answers.pop(message["id"]).set_result(message["result"])
            else:
                self.received += len(text)
                self.told.append(message["method"])
                self._notified.set()

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Ask, and return the result."""
        self._number += 1
        answer: asyncio.Future[dict[str, Any]] = asyncio.get_running_loop().create_future()
        self._answers[self._number] = answer
        request = {"jsonrpc": "2.0", "id": self._number, "method": method, "params": params}
        await self._socket.send(json.dumps(request))
        async with within(_PATIENCE, f"the answer to {method}"):
            return await answer

    async def until_engines(self, count: int) -> None:
        """Wait until there are so many engines."""
        while True:
            self._notified.clear()
            if (await self.ask("openrois.directory.list", limit=1))["count"] >= count:
                return
            await self._notified.wait()


@asynccontextmanager
async def _asker(url: str, token: str) -> AsyncIterator[Asker]:
    headers = {"Authorization": f"Bearer {token}"}
    async with connect(
        url, compression=None, max_size=None, ping_interval=None, proxy=None, additional_headers=headers
    ) as socket:
        asker = Asker(socket)
        reading = asyncio.ensure_future(asker.run())
        try:
            await asker.ask("rois.system.connect")
            await asker.ask("openrois.hello", version="1", extensions=["openrois.directory"])
            yield asker
        finally:
            reading.cancel()
            await asyncio.wait((reading,))


class Fleet:
    """A fleet that grows.

    Args:
        gateway: its process.
        key: file of the key for tokens.
    """

    def __init__(self, gateway: Child, key: Path, asker: Asker, stack: AsyncExitStack) -> None:
        self.gateway = gateway
        self.url = gateway.said.rpartition(" ")[2].replace("http", "ws", 1)
        self.asker = asker
        self._key = key
        self._stack = stack
        self._stubs = 0
        self._adapter_token = self.token(Role.ADAPTER, "*")
        self.real = 0

    @property
    def size(self) -> int:
        """How many bodies there are."""
        return self._stubs + self.real

    def token(self, role: Role, *scope: str) -> str:
        """Return a token."""
        return _token(self._key, role, *scope)

    async def attach(self, count: int) -> None:
        """Attach stubs, and wait until they are part of the tree."""
        first, self._stubs = self._stubs, self._stubs + count
        while first < self._stubs:
            # One process of stubs after another: each has to answer in time.
            last = min(first + _TOGETHER, self._stubs)
            stubs = ("-P", "-m", "openrois_bench.gateway.fleet.stubs", f"{self.url}adapter", str(first), str(last))
            await self._stack.enter_async_context(child(*stubs, environment={TOKEN_VARIABLE: self._adapter_token}))
            first = last
            await self.until_attached(self.real + first)

    async def until_attached(self, count: int) -> None:
        """Wait until so many bodies are part of the tree; the main engine is one more."""
        async with within(_PATIENCE, f"attaching {count} bodies"):
            await self.asker.until_engines(count + 1)

    async def milliseconds_each(self) -> float:
        """Attach the next bodies; return the milliseconds of the gateway's CPU for each, without what is idle."""
        idle = await self.idle_share()
        before, began = self.gateway.cpu(), time.perf_counter()
        await self.attach(NEXT)
        used, took = self.gateway.cpu() - before, time.perf_counter() - began
        return (used - idle * took) / NEXT * 1000

    async def idle_share(self) -> float:
        """Return the share of a processor that the gateway takes while nothing but signs of life is exchanged."""
        before, began = self.gateway.cpu(), time.perf_counter()
        await asyncio.sleep(_IDLE)
        return (self.gateway.cpu() - before) / (time.perf_counter() - began)


def _written(file: Path, secret: str) -> Path:
    file.touch(0o600)
    file.write_text(secret)
    return file


def _token(key: Path, role: Role, *scope: str) -> str:
    return issue_token(key, f"bench {role.value}", [role], scope, now=int(time.time()), ttl=3600)


async def _searched(asker: Asker, condition: str) -> tuple[int, float]:
    """Return the hits of a search, and the median of its milliseconds."""
    times, hits = [], 0
    for _ in range(_ASKED):
        began = time.perf_counter()
        hits = len((await asker.ask("rois.command.search", condition=condition))["component_ref_list"])
        times.append((time.perf_counter() - began) * 1000)
    return hits, sorted(times)[_ASKED // 2]


async def _listed(asker: Asker) -> tuple[int, float]:
    """Return the engines that all pages have, and the seconds that they took."""
    began, after, count = time.perf_counter(), "", 0
    while True:
        page = await asker.ask("openrois.directory.list", after=after)
        count += len(page["engines"])
        after = page["next"]
        if not after:
            return count, time.perf_counter() - began


async def _change_bytes(fleet: Fleet) -> int:
    """Return the bytes that an application gets when one more body comes, and reads it."""
    await asyncio.sleep(2)  # Changes before this one may wait to be notified.
    await fleet.asker.ask("openrois.directory.read", engine_ids=[])
    fleet.asker.received, fleet.asker.told = 0, []
    number = fleet.size - fleet.real
    await fleet.attach(1)
    await fleet.asker.ask("openrois.directory.read", engine_ids=[])
    if "openrois.directory.changed" not in fleet.asker.told:
        raise BenchFailed("the application was not notified of a body that came")
    entry = await fleet.asker.ask("openrois.directory.read", engine_ids=[body_name(number)])
    return fleet.asker.received + len(json.dumps(entry))


@asynccontextmanager
async def _scoped(fleet: Fleet, count: int) -> AsyncIterator[None]:
    """Connect applications of which each sees another body."""
    async with AsyncExitStack() as stack:
        for number in range(count):
            token = fleet.token(Role.OPERATOR, f"{body_name(number)}/*")
            await stack.enter_async_context(_asker(fleet.url, token))
        yield


@asynccontextmanager
async def running_fleet(most: int, applications: int) -> AsyncIterator[Fleet]:
    """Run a gateway with the adapters of real components."""
    with TemporaryDirectory(prefix="openrois-bench-") as name:
        key = _written(Path(name, "key"), secrets.token_urlsafe(48))
        adapter_token = _written(Path(name, "token"), _token(key, Role.ADAPTER, "*"))
        options = ("--most-adapters", str(most), "--most-applications", str(applications + 8))
        many = ("--per-address", str(applications + 8), "--subject-connections", str(applications + 8))
        sessions = ("--subject-sessions", str(2 * applications + 16), "--auth-key", str(key))
        arguments = ("-P", "-m", "openrois.cli", "gateway", "--port", "0", *options, *many, *sessions)
        async with AsyncExitStack() as stack:
            gateway = await stack.enter_async_context(child(*arguments))
            url = gateway.said.rpartition(" ")[2].replace("http", "ws", 1)
            asker = await stack.enter_async_context(_asker(url, _token(key, Role.ADMINISTRATOR, "*")))
            fleet = Fleet(gateway, key, asker, stack)
            for number in range(REAL):
                real = ("-P", "-m", "openrois_bench.gateway.gauge", url, f"real-{number}")
                await stack.enter_async_context(child(*real, environment={"OPENROIS_TOKEN_FILE": str(adapter_token)}))
                fleet.real += 1
            await fleet.until_attached(fleet.real)
            yield fleet


async def measured(sizes: tuple[int, ...], scopes: int) -> list[dict[str, Any]]:
    """Measure at each size of the fleet."""
    allow_files(sizes[-1] + scopes + 2 * NEXT * len(sizes) + 256)
    found = []
    async with running_fleet(sizes[-1] + 4 * NEXT, scopes) as fleet:
        empty = fleet.gateway.memory()
        for size in sizes:
            await fleet.attach(size - fleet.size - NEXT)
            idle = await fleet.idle_share()
            attach_ms = await fleet.milliseconds_each()
            memory = fleet.gateway.memory()
            listed, seconds = await _listed(fleet.asker)
            if listed != fleet.size + 1:
                raise BenchFailed(f"the pages have {listed} engines, not {fleet.size + 1}")
            conditions_of_search = (
                f"component_ref LIKE '{body_name(7)}/%'",
                "component_ref LIKE '%-0009%/navigation'",
                "component_ref LIKE '%0071%' AND component_type = 'urn:x-rois:def:component:OMG::Navigation'",
            )
            searches = [await _searched(fleet.asker, condition) for condition in conditions_of_search]
            change = await _change_bytes(fleet)
            scoped_ms = None
            if scopes:
                async with _scoped(fleet, scopes):
                    scoped_ms = await fleet.milliseconds_each()
            found.append(
                {
                    "bodies": size,
                    "attach_ms": round(attach_ms, 2),
                    "attach_with_scopes_ms": None if scoped_ms is None else round(scoped_ms, 2),
                    "idle_share": round(idle, 3),
                    "memory_kib_each": round((memory - empty) * 1024 / size, 1),
                    "change_bytes": change,
                    "list_seconds": round(seconds, 2),
                    "search_hits": [hits for hits, _ in searches],
                    "search_ms": [round(milliseconds, 2) for _, milliseconds in searches],
                }
            )
    return found


def main() -> int:
    """Measure, print what was measured, and return the exit status."""
    parser = argparse.ArgumentParser("python -m openrois_bench.gateway.fleet", description=__doc__)
    parser.add_argument("--bodies", type=int, nargs="+", default=list(SIZES), help="sizes of the fleet, rising")
    parser.add_argument("--scopes", type=int, default=1000, help="applications that each see another body")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    chosen = parser.parse_args()
    before = load()
    found = asyncio.run(measured(tuple(chosen.bodies), chosen.scopes))
    machine = conditions(before)
    print(machine)
    heads = (
        "bodies",
        "attach ms",
        f"with {chosen.scopes} scopes",
        "idle CPU",
        "KiB each",
        "change B",
        "list s",
        "search ms (hits)",
    )
    rows = [
        (
            str(each["bodies"]),
            str(each["attach_ms"]),
            str(each["attach_with_scopes_ms"]),
            str(each["idle_share"]),
            str(each["memory_kib_each"]),
            str(each["change_bytes"]),
            str(each["list_seconds"]),
            ", ".join(f"{ms} ({hits})" for ms, hits in zip(each["search_ms"], each["search_hits"], strict=True)),
        )
        for each in found
    ]
    print(table(heads, rows))
    write_result(chosen.json, "openrois_bench.gateway.fleet", machine, fleet=found)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
