"""A session that goes on over another connection, at another gateway, or at an engine that another gateway has now."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from tests.support.deployment import Application, patience
from tests.support.nats import NatsServer
from tests.support.place import Place, owned_by, place_of, unit
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")


@pytest.fixture
async def place(shared_nats: NatsServer, postgres_server: Server) -> AsyncIterator[Place]:
    async with place_of(shared_nats, postgres_server, "a", "b", "c") as here:
        yield here


async def bound(app: Application, ref: str = "robot/lamp") -> str:
    """Bind a component, and return the token that resumes the session."""
    assert await app.code("rois.command.bind", component_ref=ref) == "OK"
    answer = await app.ask("openrois.lease.token")
    assert answer["return_code"] == "OK"
    return str(answer["token"])


async def lost(app: Application) -> None:
    """Lose the connection without a word."""
    app.socket.transport.abort()
    await app.socket.wait_closed()


async def lease_of(app: Application, state: str, ref: str = "robot/lamp") -> int:
    """Wait until a lease is in a state, and return its epoch."""
    async with patience():
        while True:
            lease = (await app.ask("openrois.lease.query", component_ref=ref))["lease"]
            if lease is not None and lease["state"] == state:
                return int(lease["epoch"])


class TestAtAnotherGateway:
    async def test_what_was_held_is_held_again(self, place: Place) -> None:
        await place.attach("a")
        app = await place.app("b")
        token = await bound(app)
        assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "start")]) == "OK"
        await place.robot.lamp.glowing.wait()
        await lost(app)
        again, other = await place.app("c"), await place.app("a")
        answer = await again.ask("openrois.lease.resume", token=token, command_ids=["1", "never"])
        assert (answer["return_code"], [each["component_ref"] for each in answer["leases"]]) == ("OK", ["robot/lamp"])
        assert answer["forgotten"] == ["never"]
        assert await other.code("rois.command.bind", component_ref="robot/lamp") == "OUT_OF_RESOURCES"
        place.robot.lamp.may_end.set()
        assert await again.completed("1") == {"1": "OK"}
        switch = unit("robot/lamp", "switch", "2")
        assert await again.code("rois.command.execute", command_unit_list=[switch]) == "OK"
        assert await again.completed("2") == {"2": "OK"}

    async def test_a_sequence_runs_on_where_the_application_alone_was_lost(self, place: Place) -> None:
        await place.attach("a")
        app = await place.app("b")
        token = await bound(app)
        sequence = [unit("robot/lamp", "start"), unit("robot/lamp", "switch", "2")]
        assert await app.code("rois.command.execute", command_unit_list=sequence) == "OK"
        await place.robot.lamp.glowing.wait()
        await lost(app)
        again = await place.app("c")
        assert await again.code("openrois.lease.resume", token=token, command_ids=["1", "2"]) == "OK"
        place.robot.lamp.may_end.set()
        assert await again.completed("1", "2") == {"1": "OK", "2": "OK"}

    async def test_what_was_held_when_its_gateway_is_told_to_stop(
        self, shared_nats: NatsServer, postgres_server: Server
    ) -> None:
        async with place_of(shared_nats, postgres_server, "a", "b", "c", drain=0) as place:
            await place.attach("a")
            app = await place.app("b")
            token = await bound(app)
            assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "start")]) == "OK"
            await place.robot.lamp.glowing.wait()
            await place.gateway("b").drain()
            await app.socket.wait_closed()
            assert app.socket.close_code == 1012
            # Others are there, and it need not wait until this one is again.
            assert 0.5 <= float((app.socket.close_reason or "").removeprefix("retry_after=")) < 0.6
            place.robot.lamp.may_end.set()
            again = await place.app("c")
            answer = await again.ask("openrois.lease.resume", token=token, command_ids=["1"])
            assert ([each["component_ref"] for each in answer["leases"]], answer["forgotten"]) == (["robot/lamp"], [])
            assert await again.completed("1") == {"1": "OK"}

    async def test_its_gateway_waits_for_what_runs_elsewhere_and_begins_nothing_there(
        self, shared_nats: NatsServer, postgres_server: Server
    ) -> None:
        async with place_of(shared_nats, postgres_server, "a", "b", drain=600) as place:
            await place.attach("a")
            app = await place.app("b")
            await bound(app)
            assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "start")]) == "OK"
            await place.robot.lamp.glowing.wait()
            draining = asyncio.ensure_future(place.gateway("b").drain())
            await asyncio.sleep(0)
            refused = "the gateway is about to restart, and begins nothing new"
            switch = unit("robot/lamp", "switch", "2")
            assert await app.why("rois.command.execute", command_unit_list=[switch]) == ("OUT_OF_RESOURCES", refused)
            setting = {"component_ref": "robot/lamp", "parameters": []}
            assert await app.why("rois.command.set_parameter", **setting) == ("OUT_OF_RESOURCES", refused)
            assert not draining.done()
            place.robot.lamp.may_end.set()
            assert await app.completed("1") == {"1": "OK"}
            await draining

    async def test_at_the_owner_itself(self, place: Place) -> None:
        await place.attach("a")
        app = await place.app("b")
        token = await bound(app)
        await lost(app)
        again = await place.app("a")
        answer = await again.ask("openrois.lease.resume", token=token)
        assert [each["component_ref"] for each in answer["leases"]] == ["robot/lamp"]
        assert await again.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "switch")]) == "OK"

    async def test_a_connection_that_is_not_known_to_be_lost_is_put_out(self, place: Place) -> None:
        await place.attach("a")
        app = await place.app("a")
        token = await bound(app)
        epoch = await lease_of(app, "MINE")
        again = await place.app("b")
        answer = await again.ask("openrois.lease.resume", token=token)
        assert [each["component_ref"] for each in answer["leases"]] == ["robot/lamp"]
        assert answer["leases"][0]["epoch"] > epoch
        async with patience():
            await app.socket.wait_closed()
        assert app.socket.close_code == 4409

    async def test_a_token_that_comes_twice_is_refused_at_every_gateway(self, place: Place) -> None:
        await place.attach("a")
        app = await place.app("a")
        token = await bound(app)
        await lost(app)
        again = await place.app("b")
        following = (await again.ask("openrois.lease.resume", token=token))["token"]
        thief = await place.app("c")
        why = await thief.why("openrois.lease.resume", token=token)
        assert why == ("UNSUPPORTED", "the resume token is not valid")
        assert (await thief.why("openrois.lease.resume", token=following))[0] == "UNSUPPORTED"


class TestAnEngineThatChangesItsGateway:
    async def test_its_holder_has_it_on_where_its_gateway_is_told_to_stop(self, place: Place) -> None:
        await place.wander("a", "b")
        await owned_by(place, "a")
        app = await place.app("a")
        token = await bound(app)
        epoch = await lease_of(app, "MINE")
        await place.cluster.gateways["a"].drain()
        await owned_by(place, "b")
        other = await place.app("b")
        assert await other.code("rois.command.bind", component_ref="robot/lamp") == "OUT_OF_RESOURCES"
        again = await place.app("c")
        answer = await again.ask("openrois.lease.resume", token=token)
        assert [each["component_ref"] for each in answer["leases"]] == ["robot/lamp"]
        assert answer["leases"][0]["epoch"] > epoch

    async def test_its_holder_at_a_third_gateway_has_it_on(self, place: Place) -> None:
        await place.wander("a", "b")
        await owned_by(place, "a")
        app = await place.app("c")
        await bound(app)
        epoch = await lease_of(app, "MINE")
        await place.cluster.stop("a")
        await owned_by(place, "b")
        assert await lease_of(app, "MINE") > epoch
        other = await place.app("b")
        assert await other.code("rois.command.bind", component_ref="robot/lamp") == "OUT_OF_RESOURCES"
        assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "switch")]) == "OK"
        assert await app.completed("1") == {"1": "OK"}

    async def test_its_commands_have_their_one_end(self, place: Place) -> None:
        await place.wander("a", "b")
        await owned_by(place, "a")
        app = await place.app("c")
        await bound(app)
        assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "start")]) == "OK"
        await place.robot.lamp.glowing.wait()
        await place.cluster.stop("a")
        ended = await app.completed("1")
        assert ended["1"] in ("ERROR", "ABORT")
        await owned_by(place, "b")
        assert "rois.command.completed" not in await app.settled()

    async def test_its_holder_at_the_gateway_that_it_leaves_has_it_on(self, place: Place) -> None:
        await place.wander("a", "b")
        await owned_by(place, "a")
        app = await place.app("a")
        await bound(app)
        epoch = await lease_of(app, "MINE")
        await place.move("b")
        await owned_by(place, "b")
        assert await lease_of(app, "MINE") > epoch
        assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "switch")]) == "OK"
        assert await app.completed("1") == {"1": "OK"}
