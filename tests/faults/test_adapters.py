"""F1 to F6, F28, F29: adapters that die, hang, go half open, say nonsense, come back, or are of another age."""

import asyncio
import signal
from pathlib import Path
from typing import Any

import pytest

from openrois.component.authoring.marks import command
from tests.support.components import Bell
from tests.support.ground import Ground, ground, robot_program, turns
from tests.support.invariants import PATIENCE, Witness
from tests.support.newer import with_more
from tests.support.plain import TOY, plain_adapter, profile_result
from tests.support.seeds import ALL, lasting

LAMP, BELL = "robot/lamp", "robot/bell"


async def three(place: Ground) -> tuple[Witness, Witness, Witness]:
    """Connect one that has the lamp and runs commands, one that listens to the bell, and one that does neither."""
    holder, listener, stranger = [await place.witness(extended=place.chance.random() < 0.5) for _ in range(3)]
    for each in (holder, listener, stranger):
        await each.ask("rois.system.connect")
    assert await holder.bind() == "OK"
    await listener.subscribe("rang", BELL)
    return holder, listener, stranger


async def lost(place: Ground, holder: Witness, listener: Witness, stranger: Witness, commands: list[str]) -> None:
    """Check the notifications when the robot has gone without a word."""
    for command_id in commands:
        assert await holder.end_of(command_id) == "ERROR"
    told = [await holder.error(), await listener.error()]
    await place.attached(there=False)
    for each, error in zip((holder, listener), told, strict=True):
        details = await each.ask("rois.system.get_error_detail", error_id=error["error_id"], condition="")
        found = {result["name"]: result["value"] for result in details["results"]}
        assert found["component_ref"] == (LAMP if each is holder else BELL)
        assert await each.status(found["component_ref"]) == "ERROR"
    assert await holder.execute("too late") == "UNSUPPORTED"
    await stranger.ask("rois.system.connect")
    assert stranger.errors == []


async def back(place: Ground, holder: Witness, command_id: str = "again") -> None:
    """Check that a robot that is back works, and that it has no holder before it is bound again."""
    place.relay.mend()
    await place.attached()
    # What it had begun it may still do.
    assert await holder.status() in ("READY", "BUSY")
    assert await holder.execute("unbound") == "OUT_OF_RESOURCES"
    assert await holder.bind() == "OK"
    assert await holder.execute(command_id, "switch") == "OK"
    assert await holder.end_of(command_id) == "OK"


@pytest.mark.parametrize("seed", ALL)
async def test_f1_f4_a_connection_that_breaks(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with ground(seed, tmp_path, caplog) as place:
        await place.robot()
        who = await three(place)
        commands = [f"c{number}" for number in range(place.chance.randint(1, 5))]
        for command_id in commands[:-1]:
            assert await who[0].execute(command_id, "stop" if place.chance.random() < 0.3 else "start") == "OK"
        assert await who[0].execute(commands[-1]) == "OK"
        await place.running(1)
        await turns(place.chance)
        async with asyncio.timeout(PATIENCE):
            # How the others have ended may be on its way.
            while who[0].unfinished() != commands[-1:]:
                await turns(place.chance)
        place.relay.cut(refuse=True)
        await lost(place, *who, commands[-1:])
        await back(place, who[0])


@pytest.mark.parametrize("seed", lasting(0))
async def test_f1_f2_f28_a_process_that_blocks_stands_still_and_dies(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with (
        ground(seed, tmp_path, caplog, quick=True) as place,
        robot_program(place.adapter_url, log=tmp_path / "robot.log") as robot,
    ):
        await place.attached()
        who = await three(place)
        seconds = {"name": "seconds", "data_type_ref": "double", "value": str(0.9 + place.chance.random() * 0.3)}
        unit = {"component_ref": BELL, "command_type": "block", "command_id": "b", "arguments": [seconds]}
        assert await who[1].code("rois.command.execute", command_unit_list=[unit]) == "OK"
        assert await who[1].end_of("b") == "ERROR"
        await lost(place, *who, [])
        await back(place, who[0])
        assert "this call blocks the adapter" in robot.log()
        await who[1].subscribe("rang", BELL)
        assert await who[0].execute("c") == "OK"
        await asyncio.sleep(place.chance.random() * 0.1)
        robot.signal(signal.SIGSTOP)
        await lost(place, *who, ["c"])
        # What it says now is for a connection that is over.
        robot.signal(signal.SIGCONT)
        await back(place, who[0], "once more")
        await who[1].subscribe("rang", BELL)
        assert await who[0].execute("d") == "OK"
        await turns(place.chance, 200)
        robot.signal(signal.SIGKILL)
        await lost(place, *who, ["d"])


@pytest.mark.parametrize("seed", lasting(0))
async def test_f10_a_half_open_connection(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with ground(seed, tmp_path, caplog, quick=True) as place:
        await place.robot()
        who = await three(place)
        assert await who[0].execute("c") == "OK"
        await asyncio.sleep(place.chance.random() * 0.1)
        place.relay.half_open()
        place.lamp.may_end.set()
        await lost(place, *who, ["c"])


@pytest.mark.parametrize("seed", ALL)
async def test_f3_answers_that_come_twice_late_or_for_nothing(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with ground(seed, tmp_path, caplog) as place:
        plain = await place.stack.enter_async_context(plain_adapter(place.gateway))
        await place.attached("plain")
        plain.hold_completed = True
        app = await place.witness()
        assert await app.bind(TOY) == "OK"
        commands = [f"c{number}" for number in range(4)]
        for command_id in commands:
            assert await app.execute(command_id, "start", TOY) == "OK"
        async with asyncio.timeout(PATIENCE):
            while [name for name, _ in plain.asked].count("rois.command.execute") < len(commands):
                await turns(place.chance)
        theirs = [
            params["command_unit_list"][0]["command_id"]
            for name, params in plain.asked
            if name == "rois.command.execute"
        ]
        said = [(command_id, "OK") for command_id in theirs] + [(command_id, "ERROR") for command_id in theirs]
        said += [("unknown", "OK"), (commands[0], "OK")]
        firsts: dict[str, str] = {}
        place.chance.shuffle(said)
        for command_id, status in said:
            firsts.setdefault(command_id, status)
            await plain.tell_completed(command_id, status)
            await plain.answer({"id": place.chance.randrange(10_000)}, return_code="OK")
            await turns(place.chance, 5)
        for command_id, its in zip(commands, theirs, strict=True):
            assert await app.end_of(command_id) == firsts[its]
        await app.ask("rois.system.connect")


class Sluggish(Bell):
    @command(timeout=0.01)
    async def dawdle(self) -> None:
        try:
            await asyncio.Event().wait()
        finally:
            await asyncio.sleep(0)


@pytest.mark.parametrize("seed", ALL)
async def test_f5_a_command_that_takes_too_long(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with ground(seed, tmp_path, caplog) as place:
        await place.robot(Sluggish("sloth"))
        app = await place.witness()
        count = place.chance.randint(1, 4)
        for number in range(count):
            assert await app.execute(f"c{number}", "dawdle", "robot/sloth") == "OK"
            await turns(place.chance)
        for number in range(count):
            assert await app.end_of(f"c{number}") == "TIMEOUT"
        await app.error()
        assert await app.status("robot/sloth") == "READY"


@pytest.mark.parametrize("seed", ALL)
async def test_f6_a_stop_while_others_run_beside_it(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with ground(seed, tmp_path, caplog) as place:
        await place.robot()
        app = await place.witness(extended=True)
        assert await app.bind() == "OK"

        def unit(command_id: str, command_type: str) -> dict[str, object]:
            return {"component_ref": LAMP, "command_type": command_type, "command_id": command_id, "arguments": []}

        beside = {"command_list": [unit("start", "start"), unit("beside", "switch")]}
        after = [unit(f"after{number}", "switch") for number in range(place.chance.randint(1, 3))]
        assert await app.code("rois.command.execute", command_unit_list=[beside, *after]) == "OK"
        async with asyncio.timeout(PATIENCE):
            await place.lamp.glowing.wait()
        await turns(place.chance)
        for number in range(place.chance.randint(1, 3)):
            assert await app.execute(f"stop{number}", "stop") == "OK"
        # What ran beside goes on; what was to come after does not begin.
        assert await app.end_of("start") == "ABORT"
        assert await app.end_of("beside") == "OK"
        for each in after:
            assert await app.end_of(str(each["command_id"])) == "ABORT"
        await app.settled()
        assert place.lamp.total == 1
        assert await app.status() == "READY"


@pytest.mark.parametrize("seed", ALL)
async def test_f29_adapters_of_other_ages_beside_each_other(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with ground(seed, tmp_path, caplog) as place:
        later = {"version": "99", "extensions": ["rois.future", "openrois.more"], "engines": ["later"], "colour": "red"}
        ages: list[tuple[str, dict[str, Any]]] = [
            ("older", {}),
            ("old", {"openrois__hello": {"return_code": "UNSUPPORTED"}}),
            ("later", {"openrois__hello": {"return_code": "OK", **later}}),
        ]
        place.chance.shuffle(ages)
        app = await place.witness(extended=True)
        await place.robot()
        for engine_id, answers in ages:
            profile = profile_result("toy", engine_id=engine_id)
            if engine_id == "later":
                profile = with_more(profile)
            adapter = await place.stack.enter_async_context(plain_adapter(place.gateway, profile, **answers))
            adapter.answers["rois.event.subscribe"] = {"return_code": "OK", "subscribe_id": f"{engine_id}/sub"}
            await place.attached(engine_id)
            await turns(place.chance)
        for engine_id, _ in ages:
            ref = f"{engine_id}/toy"
            assert await app.bind(ref) == "OK"
            assert await app.execute(f"c-{engine_id}", "start", ref) == "OK"
            assert await app.end_of(f"c-{engine_id}") == "OK"
            assert await app.code("rois.stream.connect_stream", component_ref=ref) == "UNSUPPORTED"
        assert await app.bind() == "OK"
