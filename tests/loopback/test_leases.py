"""Control over real sockets: a lost connection and its resume, asking, granting, taking, and STOP."""

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Any

import pytest

from openrois.gateway.server import Gateway
from tests.support.deployment import Application, Robot, adapter, application, gateway, patience

LAMP = "robot/lamp"
UNIT = {"component_ref": LAMP, "command_type": "start", "command_id": "glow", "arguments": []}


@dataclass
class House:
    """A gateway with a robot."""

    gateway: Gateway
    robot: Robot


@pytest.fixture
async def house() -> AsyncIterator[House]:
    async with gateway() as running:
        robot = Robot()
        async with adapter(running, *robot.parts(), extension=robot.streams):
            yield House(running, robot)


async def holding(app: Application) -> str:
    """Hold the lamp, let it glow, and return the resume token."""
    token = await app.ask("openrois.lease.token")
    assert await app.code("rois.command.bind", component_ref=LAMP) == "OK"
    assert await app.code("rois.command.execute", command_unit_list=[UNIT]) == "OK"
    return str(token["token"])


async def cut(app: Application, witness: Application) -> None:
    """Break a connection, and wait until the gateway knows it."""
    assert (await witness.ask("openrois.lease.query", component_ref=LAMP))["lease"]["state"] == "HELD"
    app.socket.transport.abort()
    assert (await witness.next("openrois.lease.changed"))["state"] == "ABSENT"


async def glowing(robot: Robot) -> None:
    async with patience():
        await robot.lamp.glowing.wait()


async def test_a_cut_connection_is_resumed(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob:
        token = await holding(ann)
        await cut(ann, bob)
        assert await bob.code("rois.command.bind", component_ref=LAMP) == "OUT_OF_RESOURCES"
        async with application(house.gateway) as again:
            resumed = await again.ask("openrois.lease.resume", token=token, command_ids=["glow", "who?"])
            assert [held["component_ref"] for held in resumed["leases"]] == [LAMP]
            assert (resumed["forgotten"], resumed["token"] != token) == (["who?"], True)
            seen = await bob.next("openrois.lease.changed")
            assert (seen["state"], seen["epoch"]) == ("HELD", resumed["leases"][0]["epoch"])
            house.robot.lamp.may_end.set()
            assert await again.completed("glow") == {"glow": "OK"}
            assert await again.code("rois.command.execute", command_unit_list=[{**UNIT, "command_id": "b"}]) == "OK"
            assert await again.completed("b") == {"b": "OK"}


@pytest.mark.parametrize("code", [1011, 4000])
async def test_a_session_whose_application_found_the_gateway_silent_is_resumed(house: House, code: int) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob:
        token = await holding(ann)
        assert (await bob.ask("openrois.lease.query", component_ref=LAMP))["lease"]["state"] == "HELD"
        await ann.socket.close(code, "no answer")
        assert (await bob.next("openrois.lease.changed"))["state"] == "ABSENT"
        async with application(house.gateway) as again:
            resumed = await again.ask("openrois.lease.resume", token=token, command_ids=["glow"])
            assert [held["component_ref"] for held in resumed["leases"]] == [LAMP]
            house.robot.lamp.may_end.set()
            assert await again.completed("glow") == {"glow": "OK"}


async def test_command_ended_meanwhile_is_reported_on_resume(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob:
        token = await holding(ann)
        await glowing(house.robot)
        await cut(ann, bob)
        house.robot.lamp.may_end.set()
        await bob.eventually("OK", "rois.query.query", query_type="brightness", condition=f"component_ref = '{LAMP}'")
        async with application(house.gateway) as again:
            assert await again.code("openrois.lease.resume", token=token, command_ids=["glow"]) == "OK"
            assert await again.completed("glow") == {"glow": "OK"}


async def test_resume_token_restores_the_lease_at_once(house: House) -> None:
    """The gateway does not know yet that the connection is dead, or it is not: the client with the token is the
    holder."""
    async with (
        application(house.gateway) as ann,
        application(house.gateway) as bob,
        application(house.gateway) as dan,
    ):
        token = await holding(ann)
        await glowing(house.robot)
        before = (await bob.ask("openrois.lease.query", component_ref=LAMP))["lease"]["epoch"]
        asked = await bob.ask("openrois.lease.request", component_ref=LAMP)
        resumed = await dan.ask("openrois.lease.resume", token=token, command_ids=["glow"])
        (lease,) = resumed["leases"]
        assert (lease["component_ref"], lease["epoch"] > before, resumed["forgotten"]) == (LAMP, True, [])
        told = await until_state(bob, "HELD", epoch=lease["epoch"])
        assert told["reason"] == "its holder has gone on over another connection"
        assert (await dan.next("openrois.lease.requested"))["request_id"] == asked["request_id"]
        async with patience():
            await ann.socket.wait_closed()
        assert (ann.socket.close_code, ann.socket.close_reason) == (4409, "another connection has resumed this session")
        assert await dan.code("rois.command.execute", command_unit_list=[{**UNIT, "command_id": "b"}]) == "OK"
        assert await dan.completed("glow") == {"glow": "ABORT"}
        house.robot.lamp.may_end.set()
        assert await dan.completed("b") == {"b": "OK"}
        # It is valid once, and its line ends when it is shown again.
        async with application(house.gateway) as thief:
            assert await thief.code("openrois.lease.resume", token=token) == "UNSUPPORTED"
            assert await thief.code("openrois.lease.resume", token=resumed["token"]) == "UNSUPPORTED"
        assert await dan.code("rois.command.release", component_ref=LAMP) == "OK"


async def test_a_session_does_not_resume_itself(house: House) -> None:
    async with application(house.gateway) as ann:
        token = (await ann.ask("openrois.lease.token"))["token"]
        assert await ann.code("openrois.lease.resume", token=token) == "UNSUPPORTED"
        assert await ann.code("rois.command.bind", component_ref=LAMP) == "OK"
        assert await ann.code("openrois.lease.resume", token=token) == "BAD_PARAMETER"


def slow_stop(robot: Robot) -> tuple[asyncio.Event, asyncio.Event]:
    """Let the lamp not stop before an event; return the one that says that it is asked to, and that one."""
    stopping, stopped = asyncio.Event(), asyncio.Event()

    async def stop() -> None:
        stopping.set()
        await stopped.wait()

    robot.lamp.stop = stop  # type: ignore[method-assign]
    return stopping, stopped


async def test_handover_meanwhile_is_notified(house: House) -> None:
    """Who takes a component and changes connections before it is cleared hears when it may operate."""
    async with (
        application(house.gateway) as ann,
        application(house.gateway) as bob,
        application(house.gateway) as dan,
    ):
        token = (await bob.ask("openrois.lease.token"))["token"]
        await holding(ann)
        await glowing(house.robot)
        stopping, stopped = slow_stop(house.robot)
        taking = await bob.begin("openrois.lease.take", component_ref=LAMP)
        async with patience():
            await stopping.wait()
        resumed = await dan.ask("openrois.lease.resume", token=token)
        assert [lease["component_ref"] for lease in resumed["leases"]] == [LAMP]
        assert await dan.code("rois.command.execute", command_unit_list=[UNIT]) == "OUT_OF_RESOURCES"
        stopped.set()
        await until_state(dan, "MINE")
        assert await dan.code("rois.command.execute", command_unit_list=[UNIT]) == "OK"
        del taking


async def test_a_new_holder_that_leaves_before_it_can_operate_is_told_to_those_that_watch(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as eve:
        await holding(ann)
        await glowing(house.robot)
        assert (await eve.ask("openrois.lease.query", component_ref=LAMP))["lease"]["state"] == "HELD"
        stopping, stopped = slow_stop(house.robot)
        async with application(house.gateway) as bob:
            await bob.begin("openrois.lease.take", component_ref=LAMP)
            async with patience():
                await stopping.wait()
        await until_state(eve, "FREE")
        assert await eve.code("rois.command.bind", component_ref=LAMP) == "OK"
        assert await eve.code("rois.command.execute", command_unit_list=[UNIT]) == "OUT_OF_RESOURCES"
        stopped.set()
        await until_state(eve, "MINE")
        assert await eve.code("rois.command.execute", command_unit_list=[UNIT]) == "OK"


async def test_a_token_is_good_once(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob:
        token = await holding(ann)
        await cut(ann, bob)
        async with application(house.gateway) as again, application(house.gateway) as thief:
            assert await again.code("openrois.lease.resume", token=token) == "OK"
            assert (await bob.next("openrois.lease.changed"))["state"] == "HELD"
            assert await thief.code("openrois.lease.resume", token=token) == "UNSUPPORTED"
            assert await thief.code("openrois.lease.resume", token="guess") == "UNSUPPORTED"
            # After that no client can resume that session.
            again.socket.transport.abort()
            assert (await bob.next("openrois.lease.changed"))["state"] == "FREE"


async def test_the_grace_ends() -> None:
    async with (
        gateway(lease_grace=0.05) as running,
        adapter(running, *Robot().parts()),
        application(running) as ann,
        application(running) as bob,
        application(running) as again,
    ):
        token = await holding(ann)
        await cut(ann, bob)
        assert (await bob.next("openrois.lease.changed"))["state"] == "FREE"
        assert await bob.code("rois.command.bind", component_ref=LAMP) == "OK"
        assert await again.code("openrois.lease.resume", token=token) == "UNSUPPORTED"


async def test_without_a_token_nothing_is_kept(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob:
        assert await ann.code("rois.command.bind", component_ref=LAMP) == "OK"
        assert (await bob.ask("openrois.lease.query", component_ref=LAMP))["lease"]["state"] == "HELD"
        ann.socket.transport.abort()
        assert (await bob.next("openrois.lease.changed"))["state"] == "FREE"


async def test_closing_releases_the_lease(house: House) -> None:
    async with application(house.gateway) as bob:
        async with application(house.gateway) as ann:
            await holding(ann)
            assert (await bob.ask("openrois.lease.query", component_ref=LAMP))["lease"]["state"] == "HELD"
        assert (await bob.next("openrois.lease.changed"))["state"] == "FREE"


async def test_asking_and_granting(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob, application(house.gateway) as eve:
        await holding(ann)
        await glowing(house.robot)
        asked = await bob.ask("openrois.lease.request", component_ref=LAMP)
        assert (asked["lease"]["state"], asked["lease"]["position"]) == ("HELD", 1)
        assert (await eve.ask("openrois.lease.request", component_ref=LAMP))["lease"]["position"] == 2
        request = await ann.next("openrois.lease.requested")
        assert (request["request_id"], request["subject"]) == (asked["request_id"], "local")
        assert await eve.code("openrois.lease.grant", request_id=asked["request_id"]) == "UNSUPPORTED"
        assert await ann.code("openrois.lease.grant", request_id=asked["request_id"]) == "OK"
        assert await ann.completed("glow") == {"glow": "ABORT"}
        await until_state(bob, "MINE")
        await until_state(ann, "HELD")
        assert not house.robot.lamp.glowing.is_set()
        assert (await until_state(eve, "HELD", position=1))["waiting"] == 1
        assert await ann.code("rois.command.execute", command_unit_list=[{**UNIT, "command_id": "b"}]) == (
            "OUT_OF_RESOURCES"
        )
        assert await bob.code("rois.command.release", component_ref=LAMP) == "OK"
        await until_state(eve, "MINE")


async def until_state(app: Application, state: str, **more: Any) -> dict[str, Any]:
    """Wait until an application is notified that a component is in a state."""
    while True:
        told = await app.next("openrois.lease.changed")
        if {**told, **more, "state": state} == told:
            return told


async def test_declining_and_leaving(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob:
        await holding(ann)
        asked = await bob.ask("openrois.lease.request", component_ref=LAMP)
        assert await ann.code("openrois.lease.decline", request_id=asked["request_id"]) == "OK"
        assert (await bob.next("openrois.lease.declined"))["request_id"] == asked["request_id"]
        again = await bob.ask("openrois.lease.request", component_ref=LAMP)
        assert again["request_id"] == asked["request_id"]
        assert await bob.code("openrois.lease.leave", component_ref=LAMP) == "OK"
        assert (await ann.next("openrois.lease.withdrawn"))["request_id"] == asked["request_id"]
        assert await ann.code("openrois.lease.grant", request_id=asked["request_id"]) == "UNSUPPORTED"


async def test_take_from_a_plain_rois_client(house: House) -> None:
    async with application(house.gateway) as plain, application(house.gateway) as chief:
        assert await plain.code("rois.command.bind", component_ref=LAMP) == "OK"
        assert await plain.code("rois.command.execute", command_unit_list=[UNIT]) == "OK"
        await glowing(house.robot)
        taken = await chief.ask("openrois.lease.take", component_ref=LAMP)
        assert taken["lease"]["state"] == "MINE"
        assert await plain.completed("glow") == {"glow": "ABORT"}
        assert await plain.code("rois.command.bind", component_ref=LAMP) == "OUT_OF_RESOURCES"
        assert await plain.settled() == []
        assert await chief.code("rois.command.execute", command_unit_list=[UNIT]) == "OK"
        await glowing(house.robot)


async def test_invalid_lease_requests_are_refused(house: House) -> None:
    async with application(house.gateway) as ann:
        for method in ("query", "request", "take", "leave"):
            for component_ref in ("robot/bell", "robot/nobody"):
                assert await ann.code(f"openrois.lease.{method}", component_ref=component_ref) == "UNSUPPORTED"


async def test_stop(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob:
        await holding(ann)
        await glowing(house.robot)
        later = [
            {**UNIT, "command_id": "first", "command_type": "switch"},
            {**UNIT, "command_id": "second", "delay_time": 3_600_000},
        ]
        assert await ann.code("rois.command.execute", command_unit_list=later) == "OK"
        assert await ann.completed("first") == {"first": "OK"}
        assert await bob.ask("openrois.stop_all", engine_id="robot") == {
            "return_code": "OK",
            "stopped": [LAMP],
            "failed": [],
        }
        assert await ann.completed("glow", "second") == {"glow": "ABORT", "second": "ABORT"}
        assert not house.robot.lamp.glowing.is_set()
        assert await ann.code("openrois.stop_all") == "OK"
        assert await ann.code("openrois.stop_all", component_ref=LAMP) == "OK"
        assert await ann.code("openrois.stop_all", component_ref=LAMP, engine_id="robot") == "BAD_PARAMETER"
        assert await ann.code("openrois.stop_all", component_ref="nobody/x") == "UNSUPPORTED"
        assert await ann.code("openrois.stop_all", engine_id="nobody") == "UNSUPPORTED"


async def test_stop_passes_a_flood_of_ones_own(house: House) -> None:
    async with application(house.gateway) as ann:
        await holding(ann)
        await glowing(house.robot)
        house.robot.door.may_answer.clear()
        for _ in range(1000):
            await ann.begin("rois.query.query", query_type="view", condition="component_ref = 'robot/door'")
        stopping = await ann.begin("openrois.stop_all")
        assert (await ann.answer(stopping))["result"]["return_code"] == "OK"
        assert not house.robot.lamp.glowing.is_set()
        house.robot.door.may_answer.set()
        assert await ann.completed("glow") == {"glow": "ABORT"}


async def test_a_holder_that_named_the_extension_in_its_hello_is_asked(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob:
        await ann.ask("openrois.hello", version="1", extensions=["openrois.lease"])
        assert await ann.code("rois.command.bind", component_ref=LAMP) == "OK"
        asked = await bob.ask("openrois.lease.request", component_ref=LAMP)
        assert (await ann.next("openrois.lease.requested"))["request_id"] == asked["request_id"]
