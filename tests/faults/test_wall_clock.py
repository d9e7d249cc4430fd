"""F21: the wall clock of gateway and adapters jumps by an hour or a year: what follows it, and what does not."""

import asyncio
import random
import re
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, Final

import pytest
from websockets.exceptions import InvalidStatus

from openrois.adapter.dialer import serve_parent
from openrois.adapter.running import hosted
from openrois.aio.tasks import TaskScope
from openrois.component.authoring.marks import command
from openrois.component.component import Component
from openrois.gateway import applications, server, token_expiry
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.leases.model import Rules
from tests.support.components import Bell, Lamp, Rover
from tests.support.ground import Ground, ground, turns
from tests.support.invariants import Book, Witness, calm
from tests.support.seeds import SOME
from tests.support.tokens import issue, key_file
from tests.support.wall import WallClock

ROOT: Final = Path(__file__).parents[2]
HOUR: Final = 3600.0
YEAR: Final = 365 * 86_400.0
LAMP, BELL, SPARE, ROVER, SLOTH = (f"robot/{name}" for name in ("lamp", "bell", "spare", "rover", "sloth"))

FOLLOWS: Final = {
    "openrois/auth/command.py": "a token that is made is good from now on",
    "openrois/session/session.py": "the times that are told with faults and events",
    "openrois/observability/audit.py": "the times of records",
    "openrois/cluster/postgres/examination.py": "the doctor compares it with that of the database",
    "openrois/component/authoring/signatures.py": "the time of a message that says none",
    "openrois/session/events.py": "how long the details of an event last is read once, when it is told",
    "openrois/engine/faults.py": "the times of faults",
    "openrois/gateway/auth_setup.py": "when tokens begin and end",
    "openrois/gateway/page_tokens.py": "tokens of pages are good from now on",
    "openrois/gateway/server.py": "TURN credentials, and the first epoch of a process",
    "openrois/journal/file.py": "what a former process left is forgotten after a week",
    "openrois/journal/sqlite_journal.py": "the times of records",
    "openrois/engine/registry.py": "the end that an event says of itself",
    "openrois/remote/faults.py": "the time of a fault that comes without one",
}
"""Modules that may read the wall clock, and what for. Deadlines, leases, pings, quotas and switches may not."""

_READING: Final = re.compile(r"\btime\.(?:time|time_ns|gmtime|localtime|ctime)\b|\bdatetime\.(?:now|utcnow|today)\b")


def test_only_listed_modules_read_the_wall_clock() -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in sorted((ROOT / "openrois").rglob("*.py"))}
    assert not [path for path, text in texts.items() if re.search(r"^from time import .*\btime\b", text, re.MULTILINE)]
    readers = {path.relative_to(ROOT).as_posix() for path, text in texts.items() if _READING.search(text)}
    assert readers == set(FOLLOWS)


class Sloth(Component, authority="Test", function="actuation"):
    """Takes longer than it may."""

    @command(timeout=0.05)
    async def dawdle(self) -> None:
        """Take for ever."""
        await asyncio.Event().wait()


class Place:
    """A gateway with a robot, whose wall clocks and its applications' are one."""

    def __init__(self, on: Ground, wall: WallClock, rover: Rover) -> None:
        self.on = on
        self.wall = wall
        self.rover = rover

    async def jump(self, *choice: float) -> None:
        """Set the clock, and let pass what a polling test waits for."""
        self.wall.ahead = self.on.chance.choice(choice or (HOUR, -HOUR, YEAR, -YEAR))
        await turns(self.on.chance)


@asynccontextmanager
async def place(seed: int, folder: Path, log: pytest.LogCaptureFixture, **settings: Any) -> AsyncIterator[Place]:
    """Run a gateway and a robot on a wall clock that jumps."""

    async def briefly(_seconds: float) -> None:
        await asyncio.sleep(0.002)

    wall, rover = WallClock(), Rover()
    with wall.everywhere():
        async with ground(seed, folder, log, quick=True, audited=False, **settings) as on:
            parts = (on.lamp, on.bell, Lamp("spare"), rover, Sloth("sloth"))
            host = await on.stack.enter_async_context(hosted("robot", *parts))
            dialling = await on.stack.enter_async_context(TaskScope())
            dialling.start(serve_parent(host, on.adapter_url, sleep=briefly))
            await on.attached()
            yield Place(on, wall, rover)
            assert wall.read


async def position(app: Witness, component_ref: str) -> tuple[str, int]:
    """Return how an application stands with a component, and which place it has in the line."""
    lease = (await app.ask("openrois.lease.query", component_ref=component_ref))["lease"]
    return lease["state"], lease["position"]


@pytest.mark.parametrize("seed", SOME)
async def test_f21_nothing_is_due_before_its_time(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with place(seed, tmp_path, caplog, lease_grace=30.0, lease_answer=30.0) as here:
        on = here.on
        holder, asker = await on.witness(extended=True), await on.witness(extended=True)
        for component_ref in (LAMP, ROVER):
            assert await holder.bind(component_ref) == "OK"
            assert await holder.execute(f"runs {component_ref}", "start", component_ref) == "OK"
        await holder.subscribe("rang", BELL)
        async with asyncio.timeout(5):
            await here.rover.driving.wait()
            await on.lamp.glowing.wait()
        assert (await asker.ask("openrois.lease.request", component_ref=LAMP))["return_code"] == "OK"
        async with on.book.witness(on.gateway.url, extended=True) as absent:
            assert await absent.bind(SPARE) == "OK"
            token = (await absent.ask("openrois.lease.token"))["token"]
            absent.socket.transport.abort()
            await absent.gone.wait()
        for number in range(1, 7):
            await here.jump()
            on.bell.ring(str(here.wall.ahead))
            # Longer than a sign of life and half a ping take.
            await asyncio.sleep(0.02)
            for each in (holder, asker):
                await each.ask("rois.system.connect")
            async with asyncio.timeout(5):
                while len(holder.events) < number:
                    await turns(on.chance)
            details = holder.events[on.chance.randrange(number)]["event_id"]
            assert await holder.code("rois.event.get_event_detail", event_id=details, condition="") == "OK"
            assert await asker.bind(SPARE) == "OUT_OF_RESOURCES"
            assert await position(asker, LAMP) == ("HELD", 1)
        assert not here.rover.stopped.is_set()
        assert holder.unfinished() == [f"runs {LAMP}", f"runs {ROVER}"]
        again = await on.witness(extended=True)
        on.book.holders.pop(SPARE)
        assert (await again.ask("openrois.lease.resume", token=token))["return_code"] == "OK"
        assert await again.code("rois.command.release", component_ref=SPARE) == "OK"
        on.lamp.may_end.set()
        assert await holder.end_of(f"runs {LAMP}") == "OK"
        assert await holder.execute("halt", "stop", ROVER) == "OK"
        assert await holder.end_of(f"runs {ROVER}") == "ABORT"
        assert (holder.errors, asker.errors) == ([], [])


@pytest.mark.parametrize("seed", SOME)
async def test_f21_what_is_due_comes_in_time(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "Rules", lambda _grace, _answer, _loan: Rules(0.05, 0.05))
    async with place(seed, tmp_path, caplog) as here:
        on = here.on
        other = await on.witness(extended=True)
        async with on.book.witness(on.gateway.url, extended=True) as holder:
            for component_ref in (LAMP, ROVER, SLOTH):
                assert await holder.bind(component_ref) == "OK"
            assert (await holder.ask("openrois.lease.token"))["return_code"] == "OK"
            # A command's time.
            assert await holder.execute("dawdles", "dawdle", SLOTH) == "OK"
            await here.jump()
            assert await holder.end_of("dawdles") == "TIMEOUT"
            # The time for an answer.
            assert (await other.ask("openrois.lease.request", component_ref=LAMP))["return_code"] == "OK"
            await here.jump()
            async with asyncio.timeout(5):
                while not other.declined:
                    await turns(on.chance)
            assert await other.code("openrois.lease.leave", component_ref=LAMP) == "OK"
            # The dead man's switch, and the grace of a lease.
            assert await holder.execute("drives", "start", ROVER) == "OK"
            async with asyncio.timeout(5):
                await here.rover.driving.wait()
            holder.socket.transport.abort()
            await here.jump()
            await holder.gone.wait()
        on.book.holders.clear()
        async with asyncio.timeout(5):
            await here.rover.stopped.wait()
            while await other.bind(LAMP) != "OK":
                await turns(on.chance)
        # Pings.
        on.relay.half_open()
        await here.jump()
        await on.attached(there=False)
        on.relay.cut()


@pytest.mark.parametrize("seed", SOME)
async def test_f21_quotas(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with place(seed, tmp_path, caplog) as here:
        monkeypatch.setattr(applications, "REQUESTS_AT_ONCE", 5)
        monkeypatch.setattr(applications, "REQUESTS_PER_SECOND", 1e-6)
        slow = await here.on.witness()
        monkeypatch.setattr(applications, "REQUESTS_PER_SECOND", 1e6)
        quick = await here.on.witness()
        for _ in range(5):
            assert await slow.code("rois.system.connect") == "OK"
        for _ in range(10):
            await here.jump()
            assert await slow.code("rois.system.connect") == "OUT_OF_RESOURCES"
            for _ in range(10):
                assert await quick.code("rois.system.connect") == "OK"


@pytest.mark.parametrize("seed", SOME)
async def test_f21_tokens_follow_the_wall_clock(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(token_expiry, "CHECK_INTERVAL", 0.01)
    chance, book, wall, real = random.Random(seed), Book(), WallClock(), time.time()
    settings = GatewaySettings(port=0, auth_keys=(key_file(tmp_path),))
    with wall.everywhere():
        async with calm(caplog), run_gateway(settings) as gateway:

            async def admitted(token: str) -> bool:
                try:
                    async with book.witness(gateway.url, **bearer(token)) as app:
                        return await app.code("rois.system.get_profile", condition="") == "OK"
                except InvalidStatus as refusal:
                    return refusal.response.status_code != 401

            token = issue(real, exp=real + HOUR / 2)
            async with book.witness(gateway.url, **bearer(token)) as app:
                # Of a token that is not good yet the session that it has made goes on, and no new one is made.
                wall.ahead = chance.choice((-HOUR, -YEAR))
                await asyncio.sleep(0.03)
                assert await app.code("rois.system.get_profile", condition="") == "OK"
                assert not await admitted(token)
                wall.ahead = chance.uniform(-20, HOUR / 2 - 20)
                assert await admitted(token)
                assert await app.code("rois.system.get_profile", condition="") == "OK"
                wall.ahead = chance.choice((HOUR, YEAR))
                async with asyncio.timeout(5):
                    await app.gone.wait()
                assert app.close_code == 4401
                assert not await admitted(token)
    book.check()


def bearer(token: str) -> dict[str, Any]:
    return {"additional_headers": {"Authorization": f"Bearer {token}"}}


async def test_all_of_the_product_reads_the_clock_that_jumps() -> None:
    wall = WallClock()
    with wall.everywhere():
        wall.ahead = YEAR
        async with hosted("robot", Bell()) as host:
            assert host.wall_clock is wall
        assert time.time is wall
    assert time.time is not wall
    async with hosted("robot", Bell()) as host:
        assert host.wall_clock is time.time
