"""Every operation of the four interfaces, on every kind of gateway."""

import asyncio
from collections.abc import Awaitable

import pytest

from openrois.client import Client, ConnectionLost, Fault, RpcError, where
from openrois.client.components import Navigation
from openrois.errors import BadParameter, OutOfResources, RoISError, Unsupported
from openrois.types.codes import CompletedStatus, ErrorType
from openrois.types.messages import Argument, CommandUnit, ConcurrentCommands, Parameter
from tests.support.grounds import Ground

pytestmark = pytest.mark.extra(name="base")

LAMP = "toys/lamp"


def unit(command_type: str, command_id: str, **arguments: str) -> CommandUnit:
    written = tuple(Argument(name=name, data_type_ref="string", value=value) for name, value in arguments.items())
    return CommandUnit(component_ref=LAMP, command_type=command_type, command_id=command_id, arguments=written)


async def test_what_the_gateway_speaks_beyond_rois_is_known(ground: Ground, client: Client) -> None:
    spoken = {"rois.stream", "signaling", "openrois.directory", "openrois.lease"}
    assert client.extensions == (spoken if ground.extended else set())


async def test_the_profile_is_that_of_every_engine(client: Client) -> None:
    answer = await client.get_profile()
    assert answer.profile is not None
    assert answer.profile.engine_ids() == ("gateway", "robot", "toys")
    assert len(answer.component_profiles) == 19
    assert list((await client.get_profile(where(component_ref=LAMP))).component_profiles) == [LAMP]


async def test_search_is_by_condition(client: Client) -> None:
    assert len(await client.search()) == 19
    assert await client.search(where(component_ref=LAMP)) == (LAMP,)
    assert await client.search(where(component_ref="toys/o'clock")) == ()
    with pytest.raises(BadParameter, match=r"the condition cannot be read|is expected at character"):
        await client.search("component_ref")


async def test_a_component_belongs_to_the_first_that_bound_it(ground: Ground, client: Client) -> None:
    async with ground.client() as other:
        await client.bind(LAMP)
        await client.bind(LAMP)
        with pytest.raises(OutOfResources, match="another application"):
            await other.bind(LAMP)
        with pytest.raises(OutOfResources, match="bound first"):
            await other.execute(unit("switch", "1"))
        await client.release(LAMP)
        await other.bind(LAMP)
    with pytest.raises(Unsupported):
        await client.bind("toys/nothing")


async def test_leaving_releases_what_was_bound(ground: Ground, client: Client) -> None:
    async with ground.client() as other:
        await other.bind(LAMP)
    await client.bind(LAMP)


async def test_bind_any_returns_what_it_bound(ground: Ground, client: Client) -> None:
    condition = where(component_type="urn:x-rois:def:component:OMG::Navigation")
    assert await client.bind_any(condition) == "robot/navigation"
    async with ground.client() as other:
        with pytest.raises(OutOfResources):
            await other.bind_any(condition)
        with pytest.raises(Unsupported):
            await other.bind_any(where(component_type="urn:x-rois:def:component:Test::Nothing"))


async def test_parameters_are_set_and_read(client: Client) -> None:
    await client.bind(LAMP)
    command = await client.set_parameter(LAMP, [Parameter(name="level", data_type_ref="int", value="9")])
    await command
    assert command.status is CompletedStatus.OK
    assert ("level", "9") in [(each.name, each.value) for each in await client.get_parameter(LAMP)]
    with pytest.raises(BadParameter, match=r"not of (its )?type"):
        await client.set_parameter(LAMP, [Parameter(name="level", data_type_ref="int", value="bright")])


async def test_units_of_the_wire_are_executed_as_they_are(client: Client) -> None:
    await client.bind(LAMP)
    execution = await client.execute(
        unit("switch", "one", times="2"),
        ConcurrentCommands(command_list=(unit("switch", "two"), unit("switch", "three")), delay_time=5),
    )
    await execution
    assert [command.command_id for command in execution.commands] == ["one", "two", "three"]
    assert [each.value for each in await execution.commands[0]] == ["2"]
    assert [each.value for each in await client.get_command_result("one")] == ["2"]
    with pytest.raises(BadParameter):
        await client.execute(unit("switch", "one"))
    with pytest.raises(BadParameter):
        await client.get_command_result("never")


async def test_an_empty_sequence_is_refused_here(client: Client) -> None:
    with pytest.raises(ValueError, match="no command in the sequence"):
        await client.execute()


async def test_a_query_is_answered_by_the_one_that_meets_the_condition(client: Client) -> None:
    assert [each.value for each in await client.query("brightness")] == ["5"]
    assert [each.value for each in await client.query("component_status", where(component_ref=LAMP))] == ["READY"]
    with pytest.raises(BadParameter, match=r"components (answer|have) this"):
        await client.query("component_status")
    with pytest.raises(Unsupported, match=r"no component that (meets|satisfies) the condition"):
        await client.query("brightness", where(component_ref="toys/bell"))


async def test_events_come_as_they_are_and_their_details_can_be_asked_for(ground: Ground, client: Client) -> None:
    async with client.subscribe("rang") as events:
        ground.bell.ring("a scale")
        event = await anext(events)
        assert event.event_type == "rang"
        assert [each.value for each in await client.get_event_detail(event.event_id)] == ["a scale"]
    with pytest.raises(BadParameter, match=r"too long ago|no details of an event"):
        await client.get_event_detail("gateway/none")


async def test_a_fault_is_told_and_asked_about(ground: Ground, client: Client) -> None:
    await client.bind(LAMP)
    faults = client.notices(Fault)
    execution = await client.execute(unit("crash", "1"))
    with pytest.raises(
        RoISError, match=r"crash of toys/lamp ended ERROR(; the log of its adapter says why|: lamp: crash failed)"
    ):
        await execution
    fault = await anext(faults)
    assert fault.error_type is ErrorType.COMPONENT_INTERNAL_ERROR
    assert LAMP in [each.value for each in await client.get_error_detail(fault.error_id)]


async def test_what_is_refused_is_named(client: Client) -> None:
    expected: list[tuple[Awaitable[object], str]] = [
        (client.bind("toys/nothing"), r"rois.command.bind\(toys/nothing\): UNSUPPORTED \(there is no"),
        (client.query("mood", where(component_ref=LAMP)), rf"rois.query.query\(mood, component_ref = '{LAMP}'\): UNS"),
        (client.component(Navigation, LAMP).start(), rf"rois.command.execute\(start of {LAMP}\): OUT_OF_RESOURCES"),
        (client.search("x" * 1000), r"rois.command.search\(x{200}\): BAD_PARAMETER"),
        (client.search("component_ref =\n'x"), r"rois.command.search\(component_ref = 'x\): BAD_PARAMETER"),
    ]
    for refused, named in expected:
        with pytest.raises(RoISError, match=named):
            await refused


async def test_any_method_can_be_called(ground: Ground, client: Client) -> None:
    assert await client.call("rois.system.connect") == {"return_code": "OK"}
    with pytest.raises(Unsupported):
        await client.call("rois.command.bind", component_ref="toys/nothing")
    with pytest.raises(RpcError) as refusal:
        await client.call("rois.command.bind", component="toys/lamp")
    assert refusal.value.code == -32602
    with pytest.raises(RpcError) as refusal:
        await client.call("example.method")
    assert refusal.value.code == -32601
    if ground.extended:
        assert (await client.call("signaling.ice_servers"))["ice_servers"] == []


async def test_many_questions_at_once_are_answered_each(client: Client) -> None:
    answers = await asyncio.gather(*(client.search(where(component_ref=LAMP)) for _ in range(500)))
    assert set(answers) == {(LAMP,)}


async def test_a_client_that_is_closed_says_so(ground: Ground) -> None:
    async with ground.client() as client:
        pass
    with pytest.raises(ConnectionLost, match="the client is closed"):
        await client.search()
    with pytest.raises(ConnectionLost, match="the client is closed"):
        await client.execute(unit("switch", "1"))
