"""Two gateways that share a store: which of them has an adapter, and with which epochs its holders are numbered."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import pytest

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import OutOfResources
from openrois.gateway.adapters import serve_adapter
from openrois.gateway.claims import KEPT, RETRY
from openrois.leases.changes import Why
from openrois.leases.epochs import CountedEpochs
from openrois.ownership.memory_store import MemoryStore
from openrois.ownership.rules import Reading, Record
from openrois.remote.serve import serve_engine
from openrois.session.session import EngineHost
from openrois.transport.memory import memory_pair
from tests.support.clock import Clock
from tests.support.components import Lamp
from tests.support.plain import profile_result
from tests.support.session import settle
from tests.support.sites import Accepted, Robot, Site, World, listening, until
from tests.support.wire import application

pytestmark = pytest.mark.extra(name="gateway")

LAMP = "robot/lamp"


@pytest.fixture
async def world() -> AsyncIterator[World]:
    async with AsyncExitStack() as stack:
        yield World(stack, MemoryStore(Clock(1_900_000_000.0)))


@pytest.fixture
async def a(world: World) -> Site:
    return await world.site("a")


@pytest.fixture
async def b(world: World) -> Site:
    return await world.site("b")


@pytest.fixture
async def robot(world: World) -> Robot:
    return await world.robot()


async def bound(site: Site, component_ref: str = LAMP) -> int:
    """Bind a component by an application that leaves again; return the epoch of its lease."""
    async with application(site.host) as app:
        await app.ask("rois.system.connect")
        assert (await app.ask("rois.command.bind", component_ref=component_ref))["return_code"] == "OK"
        held = site.host.leases.model.holding.holder(component_ref)
        assert held is not None
        return held[1]


class TestAttaching:
    async def test_the_engines_of_an_adapter_are_claimed_and_its_leases_have_the_epochs_of_the_claim(
        self, world: World, a: Site
    ) -> None:
        robot = await world.robot("robot", "arm")
        async with robot.connected(a):
            await until(lambda: a.engines == ("robot", "arm"))
            claims = a.directorate.claims
            assert claims.keys() == {"robot", "arm"}
            assert {each.instance for each in claims.values()} != {robot.host.instance}, "the store has a digest"
            first = claims["robot"].first_epoch
            assert [await bound(a), await bound(a)] == [first, first + 1]
            assert await bound(a, "arm/lamp") == claims["arm"].first_epoch
            await until(lambda: robot.host.epoch_fence.greatest == first + 1)

    async def test_a_claim_lies_above_all_epochs_that_the_adapter_has_seen(self, a: Site, robot: Robot) -> None:
        seen = 3_000_000_000_000
        robot.host.epoch_fence.note("a gateway of before", LAMP, seen)
        async with robot.connected(a):
            await until(lambda: a.engines)
            assert a.directorate.claims["robot"].first_epoch > seen
            assert await bound(a) > seen

    async def test_what_cannot_be_attached_is_not_claimed(self, world: World, a: Site) -> None:
        robot = await world.robot("gateway")
        async with robot.connected(a) as link:
            closed = await link.ended()
            assert (closed.code, "taken already" in closed.reason) == (1008, True)
        assert "write" not in a.store.calls

    async def test_an_adapter_of_the_base_wire_has_another_instance_with_each_connection(self, a: Site) -> None:
        instances = set()
        for _ in range(2):
            near, far = memory_pair()
            serving = asyncio.ensure_future(serve_adapter(a.host, near, ownership=a.claims))
            for _ in range(2):
                request = json.loads(await far.receive())
                outcome: dict[str, Any] = {"error": {"code": -32601, "message": "Method not found"}}
                if request["method"] == "rois.system.get_profile":
                    outcome = {"result": {"return_code": "OK", **profile_result("toy")}}
                await far.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], **outcome}))
            await until(lambda: a.engines == ("plain",))
            instances.add(a.directorate.claims["plain"].instance)
            far.abort()
            await serving
        assert len(instances) == 2


class TestEnding:
    async def test_an_adapter_that_leaves_well_releases_its_engines(self, world: World, a: Site, b: Site) -> None:
        first, second = await world.robot(), await world.robot()
        async with first.connected(a):
            await until(lambda: a.engines)
        await until(lambda: not a.directorate.claims)
        async with second.connected(b):
            await until(lambda: b.engines)

    async def test_a_lost_adapter_that_dials_its_owner_again_needs_no_store(
        self, a: Site, robot: Robot, caplog: pytest.LogCaptureFixture
    ) -> None:
        async with robot.connected(a) as link:
            await until(lambda: a.engines)
            epoch, claim = await bound(a), a.directorate.claims["robot"]
            await link.lose()
        a.store.is_cut = True
        assert (a.engines, a.waits) == ((), [KEPT])
        async with robot.connected(a):
            await until(lambda: a.engines)
            a.store.is_cut = False
            a.wake.set()
            await settle()
            assert a.directorate.claims["robot"] == claim
            assert await bound(a) == epoch + 1
        assert "a task failed" not in caplog.text

    async def test_a_lost_adapter_that_does_not_come_back_is_released_after_a_while(
        self, world: World, a: Site, b: Site, robot: Robot
    ) -> None:
        async with robot.connected(a) as link:
            await until(lambda: a.engines)
            await link.lose()
        a.wake.set()
        await until(lambda: not a.directorate.claims)
        with pytest.raises(OutOfResources, match="does not own robot"):
            a.epochs.next(LAMP)
        async with (await world.robot()).connected(b):
            await until(lambda: b.engines)

    async def test_its_owner_takes_another_process_in_its_place_at_once(
        self, world: World, a: Site, robot: Robot
    ) -> None:
        async with robot.connected(a) as link:
            await until(lambda: a.engines)
            former = a.directorate.claims["robot"]
            await link.lose()
        async with (await world.robot()).connected(a):
            await until(lambda: a.engines)
            assert a.directorate.claims["robot"].first_epoch > former.last_epoch
            a.wake.set()
            assert await bound(a) == a.directorate.claims["robot"].first_epoch

    async def test_a_gateway_that_ends_releases_everything(self, world: World, b: Site) -> None:
        async with AsyncExitStack() as stack:
            other = World(stack, world.store)
            site, robot = await other.site("c"), await other.robot()
            await stack.enter_async_context(robot.connected(site))
            await until(lambda: site.engines)
        async with (await world.robot()).connected(b):
            await until(lambda: b.engines)

    async def test_a_connection_may_end_after_the_claims_of_its_gateway(self, world: World) -> None:
        async with AsyncExitStack() as connections, AsyncExitStack() as stack:
            other = World(stack, world.store)
            site, robot = await other.site("c"), await world.robot()
            link = await connections.enter_async_context(robot.connected(site))
            await until(lambda: site.engines)
            await stack.aclose()
            await link.lose()
            assert link.gateway.exception() is None


class TestRefusing:
    async def test_another_process_is_asked_to_dial_again(self, world: World, a: Site, b: Site, robot: Robot) -> None:
        async with robot.connected(a), (await world.robot()).connected(b) as link:
            await until(lambda: a.engines or link.adapter.done())
            closed = await link.ended()
            assert closed.code == 1013
            assert closed.reason.startswith(f"retry_after={RETRY:.2f} robot is owned by gateway a")
            assert (a.engines, b.engines) == (("robot",), ())
            assert b.host.connection_stats.turned_away == {"ownership": 1}

    async def test_a_second_process_at_the_owner_itself_is_refused(self, world: World, a: Site, robot: Robot) -> None:
        async with robot.connected(a):
            await until(lambda: a.engines)
            async with (await world.robot()).connected(a) as link:
                closed = await link.ended()
            assert (closed.code, "taken already" in closed.reason) == (1008, True)
            assert a.engines == ("robot",)
            assert await bound(a) == a.directorate.claims["robot"].first_epoch

    async def test_two_processes_that_come_at_once(self, world: World, a: Site) -> None:
        one, two = await world.robot(), await world.robot()
        async with one.connected(a) as first, two.connected(a) as second:
            await until(lambda: a.engines and (first.adapter.done() or second.adapter.done()))
            refused = first if first.adapter.done() else second
            assert (await refused.ended()).code == 1008
            assert a.directorate.claims.keys() == {"robot"}

    async def test_a_process_that_comes_while_another_is_being_claimed_is_refused(
        self, world: World, a: Site, robot: Robot, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        asked, may_answer, read = asyncio.Event(), asyncio.Event(), a.store.read

        async def slowly(engine_id: str, gateway_id: str) -> Reading:
            asked.set()
            await may_answer.wait()
            return await read(engine_id, gateway_id)

        monkeypatch.setattr(a.store, "read", slowly)
        async with robot.connected(a):
            await asked.wait()
            async with (await world.robot()).connected(a) as link:
                closed = await link.ended()
            assert (closed.code, "taken already" in closed.reason) == (1008, True)
            may_answer.set()
            await until(lambda: a.engines)

    async def test_an_adapter_that_leaves_while_it_is_being_claimed_leaves_nothing_behind(
        self, a: Site, b: Site, robot: Robot, world: World, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        asked, write = asyncio.Event(), a.store.write

        async def answers_never(record: Record, run: int, seen: Record | None, expired_ms: int | None) -> bool:
            await write(record, run, seen, expired_ms)
            asked.set()
            await asyncio.Event().wait()
            return True

        monkeypatch.setattr(a.store, "write", answers_never)
        async with robot.connected(a) as link:
            await asked.wait()
            await link.lose()
        assert a.engines == ()
        await a.directorate.renew()
        async with (await world.robot()).connected(b):
            await until(lambda: b.engines)

    async def test_where_the_store_is_away_the_adapter_is_told_so(self, a: Site, robot: Robot) -> None:
        a.store.is_cut = True
        async with robot.connected(a) as link:
            closed = await link.ended()
        assert closed.code == 1013
        assert closed.reason.startswith(f"retry_after={RETRY:.2f} ")
        assert "lost" in closed.reason
        assert a.engines == ()

    async def test_an_adapter_that_claims_to_have_seen_the_last_epoch_is_refused(self, a: Site, robot: Robot) -> None:
        robot.host.epoch_fence.note("nonsense", LAMP, 2**53 - 1)
        async with robot.connected(a) as link:
            closed = await link.ended()
        assert (closed.code, "no epochs left" in closed.reason) == (1008, True)


class TestMoving:
    async def test_the_same_process_at_another_gateway_is_let_go_by_the_first(
        self, a: Site, b: Site, robot: Robot
    ) -> None:
        async with robot.connected(a) as former:
            await until(lambda: a.engines)
            async with application(a.host) as app:
                await app.ask("rois.system.connect")
                assert (await app.ask("rois.command.bind", component_ref=LAMP))["return_code"] == "OK"
                async with robot.connected(b):
                    await until(lambda: b.engines)
                    closed = await former.ended()
                    assert (closed.code, closed.reason) == (1012, "robot: gateway b owns it now")
                    assert a.engines == ()
                    assert a.host.leases.model.holding.held() == frozenset()
                    assert a.host.leases.carrier.ended == {Why.GONE: 1}
                    seen = robot.host.epoch_fence.greatest
                    assert await bound(b) > seen > 0
                    assert b.directorate.claims.keys() == {"robot"}

    async def test_a_claim_that_is_kept_is_given_up_where_the_adapter_has_gone_elsewhere(
        self, a: Site, b: Site, robot: Robot, caplog: pytest.LogCaptureFixture
    ) -> None:
        async with robot.connected(a) as link:
            await until(lambda: a.engines)
            await link.lose()
        async with robot.connected(b):
            await until(lambda: b.engines and not a.directorate.claims)
            a.wake.set()
            await settle()
            assert b.directorate.owners["robot"].gateway_id == "b"
        assert "a task failed" not in caplog.text

    async def test_a_second_connection_of_the_same_process_takes_the_place_of_the_first(
        self, a: Site, robot: Robot
    ) -> None:
        async with robot.connected(a) as former:
            await until(lambda: a.engines)
            claim, epoch = a.directorate.claims["robot"], await bound(a)
            async with robot.connected(a):
                closed = await former.ended()
                assert (closed.code, closed.reason) == (1012, "the same adapter has connected again")
                await until(lambda: a.engines)
                assert a.directorate.claims["robot"] == claim
                assert await bound(a) == epoch + 1

    async def test_a_gateway_whose_id_another_process_has_lets_its_adapters_go(
        self, world: World, a: Site, robot: Robot
    ) -> None:
        async with robot.connected(a) as link:
            await until(lambda: a.engines)
            await world.site("a")
            with pytest.raises(Exception, match="another process has started as gateway a"):
                await a.directorate.renew()
            closed = await link.ended()
        assert (closed.code, closed.reason) == (1012, "robot: this gateway has lost it")


class TestChanging:
    async def test_a_new_profile_claims_what_has_come_and_releases_what_has_gone(self, world: World, a: Site) -> None:
        robot = await world.robot("robot", "arm")
        (arm,) = (bus for bus in robot.host.engine.tree.buses() if robot.host.engine.tree.bus_of("arm") is bus)
        async with robot.connected(a):
            await until(lambda: a.engines == ("robot", "arm"))
            robot.host.engine.detach(arm)
            await robot.host.engine.attach(LocalRegistry("head", [Lamp()]))
            await until(lambda: a.engines == ("robot", "head"))
            await until(lambda: a.directorate.claims.keys() == {"robot", "head"})

    async def test_a_new_profile_waits_for_the_store_and_the_old_one_goes_on(self, a: Site, robot: Robot) -> None:
        async with robot.connected(a) as link:
            await until(lambda: a.engines)
            a.store.is_cut = True
            await robot.host.engine.attach(LocalRegistry("head", [Lamp()]))
            await until(lambda: a.directorate.problem)
            assert await bound(a)
            assert not link.adapter.done()
            a.store.is_cut = False
            await until(lambda: a.engines == ("robot", "head"))

    async def test_a_new_profile_with_the_engine_of_another_process_ends_the_connection(
        self, world: World, a: Site, b: Site, robot: Robot
    ) -> None:
        async with robot.connected(a) as link, (await world.robot("head")).connected(b):
            await until(lambda: a.engines and b.engines)
            await robot.host.engine.attach(LocalRegistry("head", [Lamp()]))
            assert (await link.ended()).code == 1013
            await until(lambda: not a.directorate.claims)


class TestEpochs:
    async def test_a_block_that_is_nearly_used_up_is_followed_by_another_in_time(self, a: Site, robot: Robot) -> None:
        async with robot.connected(a):
            await until(lambda: a.engines)
            claim = a.directorate.claims["robot"]
            a.epochs.attach("robot", claim.last_epoch - 5)
            assert await bound(a) == claim.last_epoch - 4
            await until(lambda: a.directorate.claims["robot"].first_epoch > claim.last_epoch)
            assert await bound(a) == a.directorate.claims["robot"].first_epoch
            assert a.engines == ("robot",)

    async def test_without_the_store_a_block_lasts_to_its_end_and_then_says_why(self, a: Site, robot: Robot) -> None:
        async with robot.connected(a), application(a.host) as app:
            await until(lambda: a.engines)
            claim = a.directorate.claims["robot"]
            a.epochs.attach("robot", claim.last_epoch - 1)
            a.store.is_cut = True
            assert await bound(a) == claim.last_epoch
            await until(lambda: a.waits == [RETRY])
            await app.ask("rois.system.connect")
            refused = await app.ask("rois.command.bind", component_ref=LAMP)
            assert refused["return_code"] == "OUT_OF_RESOURCES"
            with pytest.raises(Exception, match=r"used up until it is claimed again: .*lost"):
                a.epochs.next(LAMP)
            a.store.is_cut = False
            a.wake.set()
            await until(lambda: a.directorate.claims["robot"].first_epoch > claim.last_epoch)
            assert await bound(a) > claim.last_epoch

    async def test_a_gateway_that_is_alone_counts_above_what_an_adapter_has_seen(self, robot: Robot) -> None:
        robot.host.epoch_fence.note("a gateway whose clock was ahead", LAMP, 5000)
        async with TaskScope() as tasks:
            host = EngineHost(Engine("gateway"), tasks, epochs=CountedEpochs(100))
            near, far = memory_pair()
            serving = {
                asyncio.ensure_future(serve_adapter(host, near)),
                asyncio.ensure_future(serve_engine(robot.host, far)),
            }
            await until(lambda: host.engine.tree.has_engine("robot"))
            assert host.epochs.next(LAMP) == 5001
            await far.close()
            await asyncio.wait(serving)
            assert host.epochs.next(LAMP) == 101


class TestDialling:
    """The adapter's own dialer, with the addresses of both gateways."""

    @asynccontextmanager
    async def dialling(self, robot: Robot, *urls: str) -> AsyncIterator[None]:
        async def sleep(_seconds: float) -> None:
            await settle()

        async with TaskScope() as tasks:
            tasks.start(serve_parent(robot.host, *urls, sleep=sleep, clock=Clock(), chance=lambda: 0.0))
            yield

    async def test_an_adapter_whose_gateway_drains_is_at_the_other_at_once(
        self, a: Site, b: Site, robot: Robot
    ) -> None:
        streams = list[Accepted]()
        async with listening(a, streams) as first, listening(b, []) as second, self.dialling(robot, first, second):
            await until(lambda: a.engines)
            epoch = await bound(a)
            await until(lambda: robot.host.epoch_fence.greatest == epoch)
            await streams[0].close(1012, "retry_after=60")
            await until(lambda: b.engines)
            assert a.engines == ()
            assert await bound(b) > epoch
            assert b.directorate.claims.keys() == {"robot"}

    async def test_a_second_process_gets_in_when_the_first_has_ended(
        self, world: World, a: Site, b: Site, robot: Robot
    ) -> None:
        async with listening(a, []) as first, listening(b, []) as second:
            async with robot.connected(a):
                await until(lambda: a.engines)
                former = a.directorate.claims["robot"]
                successor = await world.robot()
                async with self.dialling(successor, second):
                    await until(lambda: b.host.connection_stats.turned_away.get("ownership", 0) > 2)
                    assert b.engines == ()
            async with self.dialling(successor, second, first):
                await until(lambda: b.engines)
                assert b.directorate.claims["robot"].first_epoch > former.last_epoch
