"""Commands: handles, sequences, and that each ends exactly once."""

import asyncio
import itertools
import json
from contextlib import suppress
from typing import Any, cast

import pytest

from openrois.client import Client, Command, ComponentProxy, Concurrent, ConnectionLost, concurrent
from openrois.client import commands as commands_module
from openrois.client.commands import Commands
from openrois.errors import Aborted, BadParameter, ComponentFailed, OutOfResources, TimedOut, Unsupported
from openrois.transport.stream import MessageStream, StreamClosed
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Completed
from tests.support.grounds import Ground, Line

pytestmark = pytest.mark.extra(name="base")


@pytest.fixture
async def lamp(client: Client) -> ComponentProxy:
    found = client.component("toys/lamp")
    await found.bind()
    return found


async def test_a_step_runs_to_its_end_and_gives_what_the_command_gave(lamp: ComponentProxy) -> None:
    assert await lamp.command("switch", times=3) == {"total": 3}


async def test_a_step_can_be_run_again(lamp: ComponentProxy) -> None:
    switch = lamp.command("switch", times=2)
    assert [await switch, await switch] == [{"total": 2}, {"total": 4}]


async def test_a_command_can_be_awaited_by_many_and_again_and_again(ground: Ground, lamp: ComponentProxy) -> None:
    command = await lamp.command("start").execute()
    assert [command.done, command.status, command.error] == [False, None, None]
    assert repr(command) == "<Command start of toys/lamp: running>"
    waiting = [asyncio.ensure_future(command.wait()) for _ in range(3)]
    waiting[0].cancel()
    ground.lamp.may_end.set()
    assert await command == {}
    await asyncio.gather(*waiting[1:])
    assert await command == {}
    assert [command.done, command.status, command.error] == [True, CompletedStatus.OK, None]
    assert repr(command) == "<Command start of toys/lamp: OK>"


@pytest.mark.parametrize(
    ("command_type", "error", "status"),
    [("fail", ComponentFailed, CompletedStatus.ERROR), ("time_out", TimedOut, CompletedStatus.TIMEOUT)],
)
async def test_a_command_that_fails_raises(
    lamp: ComponentProxy, command_type: str, error: type[Exception], status: CompletedStatus
) -> None:
    command = await lamp.command(command_type).execute()
    with pytest.raises(error, match=f"{command_type} of toys/lamp ended {status}"):
        await command
    assert command.status is status


async def test_a_command_that_is_stopped_raises_aborted(ground: Ground, lamp: ComponentProxy) -> None:
    command = await lamp.command("start").execute()
    await ground.lamp.glowing.wait()
    await lamp.command("stop")
    with pytest.raises(Aborted):
        await command


async def test_what_does_not_fit_is_said_before_anything_is_sent(ground: Ground, lamp: ComponentProxy) -> None:
    with pytest.raises(BadParameter, match="switch of toys/lamp takes no time; there are: times, note"):
        await lamp.command("switch", time=3)
    with pytest.raises(BadParameter, match="times: 'often' is not of type int"):
        await lamp.command("switch", times="often")
    with pytest.raises(Unsupported, match="toys/lamp has no command 'burn'"):
        await lamp.command("burn")
    assert ground.lamp.total == 0


async def test_a_sequence_runs_in_order_and_stops_at_a_failure(lamp: ComponentProxy) -> None:
    execution = await lamp.client.execute(
        lamp.command("switch", times=1), lamp.command("fail"), lamp.command("switch", times=5).after(seconds=0.5)
    )
    with pytest.raises(ComponentFailed, match="fail of toys/lamp"):
        await execution
    first, failed, skipped = execution.commands
    assert [first.status, failed.status, skipped.status] == ["OK", "ERROR", "ABORT"]
    assert await first == {"total": 1}


async def test_the_steps_of_concurrent_run_at_the_same_time(ground: Ground, lamp: ComponentProxy) -> None:
    together = concurrent(lamp.command("start"), lamp.command("switch", times=2)).after(0.25)
    execution = await lamp.client.execute(together, lamp.command("switch", times=3))
    started, switched, afterwards = execution.commands
    assert await switched == {"total": 2}
    await ground.lamp.glowing.wait()
    assert repr(started) == "<Command start of toys/lamp: running>"
    ground.lamp.may_end.set()
    assert await afterwards == {"total": 5}


async def test_what_is_no_step_is_said_before_anything_is_sent(
    ground: Ground, client: Client, lamp: ComponentProxy
) -> None:
    for wrong in (None, concurrent(lamp.command("start")), asyncio.Event()):
        with pytest.raises(
            TypeError, match=r"concurrent takes steps, such as navigation.start\(\) without await, not "
        ):
            concurrent(lamp.command("start"), cast(Any, wrong))
        if not isinstance(wrong, Concurrent):
            with pytest.raises(TypeError, match=f"a sequence takes .*, not {type(wrong).__name__}"):
                await client.run(lamp.command("switch", times=1), cast(Any, wrong))
    assert ground.lamp.total == 0


async def test_run_waits_for_all(ground: Ground, lamp: ComponentProxy) -> None:
    await lamp.client.run(lamp.set_parameter(level=7), lamp.command("switch", times=2))
    assert ground.lamp.total == 2
    assert (await lamp.get_parameter())["level"] == 7


async def test_a_step_that_is_never_run_is_warned_of(lamp: ComponentProxy) -> None:
    with pytest.warns(RuntimeWarning, match="<Step switch of toys/lamp> was never run: await it"):
        repr(lamp.command("switch"))


async def test_waiting_can_be_given_up_and_the_command_goes_on(ground: Ground, lamp: ComponentProxy) -> None:
    command = await lamp.command("start").execute()
    waiting = asyncio.ensure_future(command.wait())
    await ground.lamp.glowing.wait()
    waiting.cancel()
    await asyncio.wait({waiting})
    assert ground.lamp.glowing.is_set()
    ground.lamp.may_end.set()
    await command


async def test_nothing_is_remembered_of_commands_that_ended_or_were_refused(
    client: Client, lamp: ComponentProxy
) -> None:
    running = client._commands
    for _ in range(50):
        await lamp.command("switch")
    with pytest.raises(OutOfResources):
        await client.component("robot/navigation").command("start")
    with pytest.raises(ComponentFailed):
        await lamp.command("fail")
    assert len(running) == 0


async def read_nothing(_command_id: str) -> None:
    return None


def command(command_id: str) -> Command[Any]:
    return Command("robot/arm", "wave", command_id, read_nothing)


async def test_only_the_first_end_of_a_command_counts() -> None:
    commands, wave = Commands(), command("1")
    commands.expect([wave])
    commands.completed(Completed(command_id="1", status=CompletedStatus.OK))
    commands.completed(Completed(command_id="1", status=CompletedStatus.ERROR))
    commands.completed(Completed(command_id="of another application", status=CompletedStatus.ERROR))
    commands.lost("the connection ended")
    assert wave.status is CompletedStatus.OK
    await wave


async def test_when_the_connection_ends_every_command_that_runs_does() -> None:
    commands, wave = Commands(), command("1")
    commands.expect([wave])
    commands.lost("the connection ended")
    assert wave.done
    assert wave.status is None
    with pytest.raises(ConnectionLost, match="wave of robot/arm: the connection ended"):
        await wave
    commands.completed(Completed(command_id="1", status=CompletedStatus.OK))
    assert wave.status is None


async def test_a_gateway_that_never_completes_does_not_fill_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(commands_module, "MAX_RUNNING", 2)
    commands, refused = Commands(), command("3")
    commands.expect([command("1"), command("2")])
    with pytest.raises(OutOfResources, match="2 commands of this client are unfinished"):
        commands.expect([refused])
    assert len(commands) == 2


async def answer_everything_at_once(_host: Any, stream: MessageStream) -> None:
    """Complete each change of parameters in the same breath as it is accepted, and say much else."""
    nonsense = (
        "no JSON",
        '{"jsonrpc":"2.0","method":"rois.command.completed","params":{"command_id":"c1","status":"PERHAPS"}}',
        '{"jsonrpc":"2.0","method":"rois.command.completed","params":{"command_id":"unknown","status":"OK"}}',
        '{"jsonrpc":"2.0","method":"rois.event.notify_event","params":{"event_id":"e","event_type":"x","subscribe_id":"?"}}',
        '{"jsonrpc":"2.0","method":"rois.system.notify_error","params":{}}',
        '{"jsonrpc":"2.0","id":99,"result":{"return_code":"OK"}}',
        '{"jsonrpc":"2.0","id":1,"method":"rois.system.connect"}',
    )
    numbers = itertools.count(1)
    with suppress(StreamClosed):
        while True:
            request = json.loads(await stream.receive())
            if "method" not in request:
                continue
            result = {"return_code": "OK"}
            if request["method"] == "rois.command.set_parameter":
                result["command_id"] = f"c{next(numbers)}"
            for text in nonsense:
                await stream.send(text)
            await stream.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": result}))
            if "command_id" in result:
                completed = {"command_id": result["command_id"], "status": "OK"}
                told = {"jsonrpc": "2.0", "method": "rois.command.completed", "params": completed}
                await stream.send(json.dumps(told))


async def test_a_command_that_ends_with_its_acceptance_is_not_missed_whatever_else_is_said(line: Line) -> None:
    line.speaks = answer_everything_at_once
    async with asyncio.timeout(60), Client(dial=line.dial) as client:
        for _ in range(20):
            await (await client.set_parameter("robot/arm", []))
        assert len(client._commands) == 0
