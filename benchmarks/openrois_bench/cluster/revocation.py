"""How soon less rights, and STOP, hold at the gateway that owns a body.

    python -m openrois_bench.cluster.revocation [--rounds N] [--json FILE]

NATS, PostgreSQL and two gateways, each a process of its own; an adapter and applications in this one. An application at
the gateway `front` holds a body of the gateway `owner`. In turn it is revoked at the front alone, which is told so by
SIGHUP or looks at its file by itself; it shows the front a token with a smaller scope; it asks for STOP, while NATS is
there and while NATS stands still. Rights have gone when another application, at the owner, can bind the body.
"""

import argparse
import asyncio
import os
import signal
import tempfile
import time
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from openrois.adapter import Component, command
from openrois.adapter.dialer import serve_parent
from openrois.adapter.running import hosted
from openrois.aio.tasks import TaskScope
from openrois.auth.issuing import issue_token
from openrois.auth.principal import Role
from openrois.jsonrpc.session import RpcSession
from openrois.transport.address import adapter_url
from openrois.transport.credentials import Credentials
from openrois.transport.websocket import dial
from openrois_bench.cluster.postgres import postgres_server
from openrois_bench.cluster.reporting import measure_and_report
from openrois_bench.cluster.stream import nats_server
from openrois_bench.errors import BenchFailed, within
from openrois_bench.measuring.figures import MILLISECONDS, Percentiles
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import Child, child

__all__ = ["CASES", "measure", "printed", "summary"]

PATIENCE: Final = 60.0
REF: Final = "body/arm"
SCOPE: Final = ("body/*",)
NARROWER: Final = ("other/*",)
LIFETIME: Final = 3600
CASES: Final = (
    "revoked at the front, by SIGHUP",
    "revoked at the front, which looks at its file",
    "a token with a smaller scope",
    "STOP by the link between the gateways",
    "STOP while NATS stands still",
)


class Arm(Component, authority="OpenRoIS", function="actuation"):
    """Component to be stopped."""

    def __init__(self) -> None:
        super().__init__("arm")
        self.stopped_at = 0.0

    @command
    async def stop(self) -> None:
        """Note when it was."""
        self.stopped_at = time.perf_counter()


@dataclass(slots=True)
class Case:
    """What was measured of one case.

    Attributes:
        held: seconds until rights had gone, or the body was told to stop.
        replied: seconds until the application was told what had stopped; none for other cases.
    """

    held: list[float] = field(default_factory=list)
    replied: list[float] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _Site:
    """What takes part.

    Attributes:
        folder: with the key, and with what is revoked at the front.
        front: the gateway of the application, and where it is reached.
        nats: the number of its process.
        arm: of the body.
        rival: an application at the owner.
    """

    folder: Path
    front: Child
    front_url: str
    nats: int
    arm: Arm
    rival: RpcSession

    @property
    def revoked(self) -> Path:
        return self.folder / "revoked"

    def token(self, subject: str, scope: tuple[str, ...] = SCOPE, role: Role = Role.OPERATOR) -> str:
        return _token(self.folder, subject, scope, role)


def _token(folder: Path, subject: str, scope: tuple[str, ...], role: Role) -> str:
    return issue_token(folder / "key", subject, (role,), scope, now=int(time.time()), ttl=LIFETIME)


@asynccontextmanager
async def _application(url: str, token: str) -> AsyncIterator[RpcSession]:
    async with TaskScope() as tasks, dial(url.replace("http", "ws", 1), credentials=Credentials(token)) as stream:
        session = RpcSession(stream)
        tasks.start(_run(session))
        await session.call("openrois.hello", {"version": "1", "extensions": ["openrois.lease"]})
        yield session


async def _run(session: RpcSession) -> None:
    await session.run()


async def _until_bound(session: RpcSession) -> float:
    """Bind the body as soon as that is possible; return when it was."""
    async with within(PATIENCE, "the body, as an application sees it"):
        while True:
            answer = await session.call("rois.command.bind", {"component_ref": REF})
            if answer["return_code"] == "OK":
                return time.perf_counter()
            await asyncio.sleep(0.001)


@asynccontextmanager
async def _site() -> AsyncIterator[_Site]:
    async with AsyncExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (folder / "key").write_bytes(os.urandom(32).hex().encode())
        (folder / "key").chmod(0o600)
        (folder / "revoked").touch()
        nats, nats_process = await stack.enter_async_context(nats_server())
        store = await stack.enter_async_context(postgres_server())
        shared = ("--cluster", nats, "--store", store, "--cluster-name", "bench", "--auth-key", str(folder / "key"))
        gateways = []
        for gateway_id, own in (("owner", ()), ("front", ("--auth-revocations", str(folder / "revoked")))):
            words = ("-P", "-m", "openrois.cli", "gateway", "--port", "0", "--gateway-id", gateway_id)
            gateways.append(await stack.enter_async_context(child(*words, *shared, *own)))
        owner_url, front_url = (each.said.rpartition(" ")[2] for each in gateways)
        arm = Arm()
        host = await stack.enter_async_context(hosted("body", arm))
        tasks = await stack.enter_async_context(TaskScope())
        credentials = Credentials(_token(folder, "body", SCOPE, Role.ADAPTER))
        tasks.start(serve_parent(host, adapter_url(owner_url), credentials=credentials))
        rival = await stack.enter_async_context(_application(owner_url, _token(folder, "rival", SCOPE, Role.OPERATOR)))
        await _until_bound(rival)
        await rival.call("rois.command.release", {"component_ref": REF})
        yield _Site(folder, gateways[1], front_url, nats_process, arm, rival)


async def measure(rounds: int, progress: Callable[[str], None]) -> dict[str, Case]:
    """Measure each case so many times, in turn.

    Raises:
        BenchFailed: something that takes part did not do what it should.
    """
    cases = {name: Case() for name in CASES}
    async with _site() as site:
        for number in range(rounds):
            for kind, (name, case) in enumerate(cases.items()):
                subject = f"subject {number} {kind}"
                async with _application(site.front_url, site.token(subject)) as holder:
                    await _until_bound(holder)
                    if name.startswith("STOP"):
                        await _stop(site, holder, case, is_away=name == CASES[-1])
                    else:
                        await _lose_rights(site, holder, case, name, subject)
            progress(f"round {number + 1} of {rounds}")
    return cases


async def _lose_rights(site: _Site, holder: RpcSession, case: Case, name: str, subject: str) -> None:
    refreshing: asyncio.Future[Any] | None = None
    began = time.perf_counter()
    if name == CASES[2]:
        token = site.token(subject, NARROWER)
        began = time.perf_counter()
        refreshing = asyncio.ensure_future(holder.call("openrois.auth.refresh", {"token": token}))
    else:
        with site.revoked.open("a") as revoked:
            revoked.write(f"sub {subject}\n")
        if name == CASES[0]:
            os.kill(site.front.pid, signal.SIGHUP)
    case.held.append(await _until_bound(site.rival) - began)
    if refreshing is not None and (await refreshing)["return_code"] != "OK":
        raise BenchFailed("the front refuses a token with a smaller scope")
    await site.rival.call("rois.command.release", {"component_ref": REF})


async def _stop(site: _Site, holder: RpcSession, case: Case, *, is_away: bool) -> None:
    if is_away:
        os.kill(site.nats, signal.SIGSTOP)
    try:
        began = time.perf_counter()
        answer = await holder.call("openrois.stop_all", {"engine_id": "body"})
        case.replied.append(time.perf_counter() - began)
    finally:
        os.kill(site.nats, signal.SIGCONT)
    if answer["return_code"] != "OK" or site.arm.stopped_at < began:
        raise BenchFailed(f"STOP has not stopped the body: {answer}")
    case.held.append(site.arm.stopped_at - began)


def summary(cases: Mapping[str, Case]) -> dict[str, Any]:
    """Return the figures, times in milliseconds."""
    return {
        name: {
            "held": Percentiles.of(case.held, MILLISECONDS).model_dump(),
            "longest": round(max(case.held) * MILLISECONDS, 1),
            **({"replied": Percentiles.of(case.replied, MILLISECONDS).model_dump()} if case.replied else {}),
        }
        for name, case in cases.items()
    }


def printed(figures: Mapping[str, Any]) -> str:
    """Return the figures as a table."""
    rows = [
        (
            name,
            f"{told['held']['count']}",
            *(f"{told['held'][each]:.1f}" for each in ("p50", "p95")),
            f"{told['longest']:.1f}",
            f"{told['replied']['p50']:.1f}" if "replied" in told else "",
        )
        for name, told in figures.items()
    ]
    head = ("holds at the owner", "times", "p50 ms", "p95 ms", "longest ms", "and the reply, p50 ms")
    return table(head, rows)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.cluster.revocation", description=__doc__)
    parser.add_argument("--rounds", type=int, default=20, help="of all cases (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE")
    chosen = parser.parse_args()

    async def measured(progress: Callable[[str], None]) -> dict[str, Any]:
        return summary(await measure(chosen.rounds, progress))

    measure_and_report("openrois_bench.cluster.revocation", measured, printed, chosen.json)


if __name__ == "__main__":
    main()
