"""What is left of a cluster while NATS or PostgreSQL is away, and what comes back by itself."""

from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest
from aiohttp import ClientSession

from openrois.client import Client, ComponentFailed, Unsupported
from tests.openrois.federation.test_resuming import bound, lost
from tests.support.cluster import seen_by
from tests.support.deployment import patience
from tests.support.nats import NatsServer, nats_server
from tests.support.place import Place, place_of, unit
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")


@pytest.fixture
def own_nats(nats: None, tmp_path: Path) -> Iterator[NatsServer]:
    with nats_server(tmp_path) as server:
        yield server


@pytest.fixture
async def place(own_nats: NatsServer, postgres_server: Server) -> AsyncIterator[Place]:
    async with place_of(own_nats, postgres_server, "a", "b") as here:
        await here.attach("a")
        yield here


async def lacking(place: Place, gateway_id: str) -> list[str]:
    """Return what /readyz of a gateway lacks."""
    async with ClientSession() as http, http.get(f"{place.gateway(gateway_id).url}readyz") as answer:
        return list((await answer.json()).get("lacking", []))


class TestNats:
    async def test_what_is_owned_goes_on_and_what_is_not_is_refused_with_the_reason(
        self, place: Place, own_nats: NatsServer
    ) -> None:
        here, there = await place.app("a"), await place.app("b")
        await here.ask("rois.command.bind", component_ref="robot/lamp")
        assert await there.code("rois.query.query", query_type="view", condition="component_ref = 'robot/door'") == "OK"
        own_nats.kill()
        assert await here.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "switch")]) == "OK"
        assert await here.completed("1") == {"1": "OK"}
        async with patience():
            while not await lacking(place, "b"):
                pass
        assert await lacking(place, "b") == ["NATS, which joins the gateways"]
        code, why = await there.why("rois.command.bind", component_ref="robot/lamp")
        assert code == "ERROR"
        assert "robot belongs to gateway a, which is not reached" in why
        own_nats.start()
        await seen_by(there, "robot")
        code, why = await there.why("rois.command.bind", component_ref="robot/lamp")
        assert (code, why) == ("OUT_OF_RESOURCES", "robot/lamp is bound by another application")
        assert place.robot.lamp.total == 1
        async with patience():
            while await lacking(place, "b"):
                pass

    async def test_a_client_says_why_a_component_of_another_gateway_does_nothing(
        self, place: Place, own_nats: NatsServer
    ) -> None:
        await place.app("b")
        async with Client(place.gateway("b").url.replace("http", "ws")) as client:
            lamp = client.component("robot/lamp")
            await lamp.profile()
            own_nats.kill()
            async with patience():
                while not await lacking(place, "b"):
                    pass
            asked = (
                client.bind("robot/lamp"),
                lamp.profile(),
                lamp.command("switch").execute(),
                lamp.query("brightness"),
                lamp.get_parameter(),
                aiter(lamp.event("switched")).__anext__(),
            )
            for each in asked:
                with pytest.raises(ComponentFailed, match=r"robot belongs to gateway a, which is not reached: .*NATS"):
                    await each
            with pytest.raises(Unsupported, match="there is no component other/lamp"):
                await client.component("other/lamp").command("switch").execute()

    async def test_a_command_that_ran_has_one_end_and_its_lease_is_found_again(
        self, place: Place, own_nats: NatsServer
    ) -> None:
        app = await place.app("b")
        await bound(app)
        assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "start")]) == "OK"
        await place.robot.lamp.glowing.wait()
        own_nats.kill()
        assert await app.completed("1") == {"1": "ERROR"}
        assert app.reasons["1"] == "gateway a, at which it ran, is not reached any more; what had begun may go on"
        assert (await app.next("rois.system.notify_error"))["error_type"] == "COMPONENT_NOT_RESPONDING"
        own_nats.start()
        await seen_by(app, "robot")
        place.robot.lamp.may_end.set()
        switch = unit("robot/lamp", "switch", "2")
        await app.eventually("OK", "rois.command.execute", command_unit_list=[switch])
        assert await app.completed("2") == {"2": "OK"}

    async def test_what_had_not_begun_begins_no_more(self, place: Place, own_nats: NatsServer) -> None:
        app, lamp = await place.app("b"), place.robot.lamp
        token = await bound(app)
        sequence = [unit("robot/lamp", "start"), unit("robot/lamp", "switch", "2")]
        assert await app.code("rois.command.execute", command_unit_list=sequence) == "OK"
        await lamp.glowing.wait()
        own_nats.kill()
        assert await app.completed("1", "2") == {"1": "ERROR", "2": "ERROR"}
        async with patience():
            while not await lacking(place, "a"):
                pass
        lamp.may_end.set()
        await lost(app)
        own_nats.start()
        again = await place.app("a")
        await again.eventually("OK", "openrois.lease.resume", token=token, command_ids=["1", "2"])
        assert await again.completed("1", "2") == {"1": "OK", "2": "ABORT"}
        assert again.reasons["2"] == "the stream to the application's gateway was lost before switch began"
        assert lamp.total == 0

    async def test_stop_goes_by_the_store(self, place: Place, own_nats: NatsServer) -> None:
        app = await place.app("b")
        await bound(app)
        assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "start")]) == "OK"
        await place.robot.lamp.glowing.wait()
        own_nats.kill()
        await app.completed("1")
        assert await app.why("openrois.stop_all", engine_id="robot") == ("OK", "")
        assert not place.robot.lamp.glowing.is_set()

    async def test_stop_of_who_holds_nothing_goes_by_the_store(self, place: Place, own_nats: NatsServer) -> None:
        holder, app = await place.app("b"), await place.app("b")
        await bound(holder)
        assert await holder.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "start")]) == "OK"
        await place.robot.lamp.glowing.wait()
        own_nats.kill()
        await holder.completed("1")
        assert await app.why("openrois.stop_all", engine_id="robot") == ("OK", "")
        assert not place.robot.lamp.glowing.is_set()


class TestPostgres:
    async def test_what_is_owned_goes_on_and_nothing_more_is_claimed(
        self, own_nats: NatsServer, postgres_server: Server
    ) -> None:
        async with place_of(own_nats, postgres_server, "a", "b") as place:
            await place.attach("a")
            app = await place.app("b")
            await bound(app)
            postgres_server.kill()
            try:
                async with patience():
                    while "the store that the gateways share" not in await lacking(place, "a"):
                        pass
                switch = unit("robot/lamp", "switch")
                assert await app.code("rois.command.execute", command_unit_list=[switch]) == "OK"
                assert await app.completed("1") == {"1": "OK"}
                code, why = await app.why("openrois.lease.token")
                assert (code, "PostgreSQL" in why) == ("ERROR", True)
            finally:
                postgres_server.start()
            await place.attach("b", "second")
            await seen_by(app, "second")
            async with patience():
                while await lacking(place, "a"):
                    pass


async def test_stop_that_reaches_the_owner_by_no_way_says_so(own_nats: NatsServer, postgres_server: Server) -> None:
    async with place_of(own_nats, postgres_server, "a", "b") as place:
        await place.attach("a")
        app = await place.app("b")
        await bound(app)
        own_nats.kill()
        postgres_server.kill()
        try:
            code, why = await app.why("openrois.stop_all", engine_id="robot")
            assert code == "ERROR"
            assert why.startswith("STOP has not reached gateway a: ")
        finally:
            postgres_server.start()
            own_nats.start()
