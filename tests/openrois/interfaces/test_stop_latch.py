"""STOP by a person: programs are refused until a person hands back, and learn by whom; persons go on."""

import asyncio
import json
import random
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import LOCAL, Principal
from openrois.contract import Client
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import Unsupported
from openrois.gateway.token_expiry import TokenExpiry
from openrois.observability.audit import Audit
from openrois.session.session import EngineHost
from openrois.types.streams import HolderNotification
from tests.support.authorization import Place, Wire, principal
from tests.support.components import Bell, Lamp

LAMP = {"component_ref": "robot/lamp"}
ROBOT = {"engine_id": "robot"}
_LAST = "the last line"
WAITS = "robot was stopped by ann: programs wait until a person hands it back"

ANN = principal("operator", "*", subject="ann", rank="person")
BOB = principal("administrator", "*", subject="bob", rank="person")
AGENT = principal("operator", "*", subject="agent", rank="agent")
SCRIPT = principal("administrator", "*", subject="script")


class Told:
    """The extension of an engine, which notes what it is told of holders."""

    def __init__(self) -> None:
        self.holders: list[tuple[str, bool, int]] = []

    def engines(self) -> frozenset[str]:
        return frozenset()

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        raise Unsupported("no streams")

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        self.holders.append((notification.component_ref, notification.holds, notification.epoch))

    async def forget_client(self, client: Client) -> None: ...


@dataclass
class Robot:
    """A gateway with a lamp, and applications at it."""

    here: Place
    stack: AsyncExitStack
    audit: Path
    lamp: Lamp = field(default_factory=Lamp)
    told: Told = field(default_factory=Told)
    numbers: int = 0

    async def app(self, who: Principal | TokenExpiry) -> Wire:
        app = await self.stack.enter_async_context(self.here.application(who))
        assert await app.code("openrois.hello", {"version": "1", "extensions": ["openrois.lease"]}) == "OK"
        return app

    async def execute(self, app: Wire, command_type: str = "switch", **more: Any) -> tuple[str, str]:
        """Ask for a command of the lamp; return the return_code and the command's id."""
        self.numbers += 1
        unit = {**LAMP, "command_type": command_type, "command_id": f"c{self.numbers}", "arguments": [], **more}
        return str(await app.code("rois.command.execute", {"command_unit_list": [unit]})), unit["command_id"]

    async def run(self, app: Wire, command_type: str = "switch") -> str:
        """Run a command of the lamp; return how it was refused, or how it ended."""
        code, command_id = await self.execute(app, command_type)
        return await app.completed(command_id) if code == "OK" else code


@pytest.fixture
async def robot(tmp_path: Path) -> AsyncIterator[Robot]:
    engine = Engine("gateway")
    async with AsyncExitStack() as stack:
        audit = stack.enter_context(Audit(tmp_path / "audit"))
        tasks = await stack.enter_async_context(TaskScope())
        made = Robot(Place(EngineHost(engine, tasks, audit=audit), {}), stack, tmp_path / "audit")
        await engine.attach(LocalRegistry("robot", (made.lamp, Bell()), extension=made.told))
        yield made


async def turn() -> None:
    """Let everything else that is ready run once."""
    await asyncio.sleep(0)


async def why(app: Wire) -> str:
    """Return the reason of the refusal before."""
    return str((await app.until("openrois.reason"))["reason"])


async def test_a_program_that_tries_hundreds_of_times_moves_nothing(robot: Robot) -> None:
    ann, agent = await robot.app(ANN), await robot.app(AGENT)
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    assert await robot.run(agent) == "OK"
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    before = robot.here.host.stops.refused
    for _ in range(300):
        assert await robot.run(agent) == "OUT_OF_RESOURCES"
        assert await why(agent) == WAITS
    assert robot.lamp.total == 1
    assert robot.here.host.stops.refused == before + 300
    assert await ann.code("openrois.lease.release_stop", ROBOT) == "OK"
    assert await robot.run(agent) == "OK"
    assert robot.lamp.total == 2


async def test_a_person_goes_on_before_it_hands_back(robot: Robot) -> None:
    ann, bob, agent = await robot.app(ANN), await robot.app(BOB), await robot.app(AGENT)
    assert await bob.code("rois.command.bind", LAMP) == "OK"
    assert await ann.code("openrois.stop_all", LAMP) == "OK"
    assert await robot.run(bob) == "OK"
    assert await bob.code("rois.command.release", LAMP) == "OK"
    # What a program may do: bind, and stop.
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    assert await robot.run(agent, "stop") == "OK"
    assert await robot.run(agent) == "OUT_OF_RESOURCES"
    assert robot.lamp.total == 1


async def test_parameters_are_commands_too_and_what_does_not_act_is_not_concerned(robot: Robot) -> None:
    ann, agent = await robot.app(ANN), await robot.app(AGENT)
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    level = {"name": "level", "data_type_ref": "Integer", "value": "7"}
    params = {**LAMP, "parameters": [level]}
    assert await agent.code("rois.command.set_parameter", params) == "OUT_OF_RESOURCES"
    assert await why(agent) == WAITS
    condition = {"query_type": "brightness", "condition": "component_ref = 'robot/lamp'"}
    assert await agent.code("rois.query.query", condition) == "OK"
    heard = {"event_type": "rang", "condition": "component_ref = 'robot/bell'"}
    assert await agent.code("rois.event.subscribe", heard) == "OK"
    assert robot.lamp.level == 5


async def test_what_was_accepted_before_ends_with_abort_and_who_stopped_it(robot: Robot) -> None:
    ann, agent = await robot.app(ANN), await robot.app(AGENT)
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    code, running = await robot.execute(agent, "start")
    assert code == "OK"
    await robot.lamp.glowing.wait()
    code, later = await robot.execute(agent, "switch", delay_time=3_600_000)
    assert code == "OK"
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    ends = {}
    for _ in range(2):
        reason = await agent.until("openrois.reason")
        assert reason["reason"] == "everything was stopped by ann"
        told = await agent.until("rois.command.completed")
        ends[told["command_id"]] = told["status"]
    assert ends == {running: "ABORT", later: "ABORT"}


async def test_a_command_whose_turn_comes_while_all_is_stopped_does_not_begin(robot: Robot) -> None:
    ann, agent = await robot.app(ANN), await robot.app(AGENT)
    may_stop = asyncio.Event()

    async def stop() -> None:
        await may_stop.wait()

    robot.lamp.stop = stop  # type: ignore[method-assign]
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    units: list[dict[str, Any]] = [
        {**LAMP, "command_type": kind, "command_id": kind, "arguments": []} for kind in ("start", "switch")
    ]
    assert await agent.code("rois.command.execute", {"command_unit_list": units}) == "OK"
    await robot.lamp.glowing.wait()
    stopping = asyncio.ensure_future(ann.code("openrois.stop_all", ROBOT))
    async with asyncio.timeout(10):
        while not robot.here.host.stop_latch.by("robot"):
            await turn()
    robot.lamp.may_end.set()
    assert await agent.completed("start") == "OK"
    assert await agent.completed("switch") == "ABORT"
    may_stop.set()
    assert await stopping == "OK"
    assert robot.lamp.total == 0
    assert robot.here.host.audit.refusals == 1


async def test_adapters_learn_that_programs_hold_nothing_meanwhile(robot: Robot) -> None:
    ann, agent = await robot.app(ANN), await robot.app(AGENT)
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    # Bound again, it is told of again, but for what is stopped.
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    assert await ann.code("openrois.lease.release_stop", ROBOT) == "OK"
    assert await agent.code("openrois.lease.query", LAMP) == "OK"
    (_, _, epoch), *_ = robot.told.holders
    assert robot.told.holders == [("robot/lamp", holds, epoch) for holds in (True, False, True)]


async def test_what_a_person_holds_stays_held(robot: Robot) -> None:
    ann, bob = await robot.app(ANN), await robot.app(BOB)
    assert await bob.code("rois.command.bind", LAMP) == "OK"
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    assert await bob.code("openrois.lease.query", LAMP) == "OK"
    assert [holds for _, holds, _ in robot.told.holders] == [True]


async def test_a_program_that_gets_a_component_meanwhile_operates_it_from_the_hand_back_on(robot: Robot) -> None:
    ann, bob, agent = await robot.app(ANN), await robot.app(BOB), await robot.app(AGENT)
    assert await bob.code("rois.command.bind", LAMP) == "OK"
    assert await agent.code("openrois.lease.request", LAMP) == "OK"
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    assert await bob.code("rois.command.release", LAMP) == "OK"
    assert (await agent.until("openrois.lease.changed", lambda told: told["state"] == "MINE"))["stopped_by"] == "ann"
    assert [holds for _, holds, _ in robot.told.holders] == [True, False]
    assert await ann.code("openrois.lease.release_stop", LAMP) == "OK"
    assert await agent.code("openrois.lease.query", LAMP) == "OK"
    assert [holds for _, holds, _ in robot.told.holders] == [True, False, True]
    assert await robot.run(agent) == "OK"


@pytest.mark.parametrize("who", [AGENT, SCRIPT], ids=["agent", "script"])
async def test_no_program_hands_back(robot: Robot, who: Principal) -> None:
    ann, program = await robot.app(ANN), await robot.app(who)
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    assert await program.code("openrois.lease.release_stop", ROBOT) == "UNSUPPORTED"
    assert await why(program) == "only a person hands back to programs what a person has stopped"
    # And none stops in a person's place.
    assert await program.code("openrois.stop_all", ROBOT) == "OK"
    assert robot.here.host.stop_latch.by("robot") == "ann"


async def test_a_program_that_stops_all_latches_nothing(robot: Robot) -> None:
    script, agent = await robot.app(SCRIPT), await robot.app(AGENT)
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    assert await script.code("openrois.stop_all", ROBOT) == "OK"
    assert await robot.run(agent) == "OK"


@pytest.mark.parametrize(
    ("scope", "params", "code"),
    [
        ("*", {"engine_id": "rover"}, "UNSUPPORTED"),
        ("*", {"component_ref": "robot/none"}, "UNSUPPORTED"),
        ("robot/bell", ROBOT, "UNSUPPORTED"),
        ("rover/*", LAMP, "UNSUPPORTED"),
        ("*", {**LAMP, **ROBOT}, "BAD_PARAMETER"),
        ("*", {}, "BAD_PARAMETER"),
        ("*", LAMP, "OK"),
        ("robot/lamp", ROBOT, "OK"),
    ],
    ids=str,
)
async def test_where_a_person_may_hand_back(robot: Robot, scope: str, params: dict[str, Any], code: str) -> None:
    ann = await robot.app(ANN)
    cleo = await robot.app(principal("operator", scope, subject="cleo", rank="person"))
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    assert await cleo.code("openrois.lease.release_stop", params) == code
    assert robot.here.host.stop_latch.by("robot") == ("" if code == "OK" else "ann")


async def test_all_who_are_concerned_are_notified_and_who_comes_later_may_ask(robot: Robot) -> None:
    ann, agent, bob = await robot.app(ANN), await robot.app(AGENT), await robot.app(BOB)
    stranger = await robot.app(principal("operator", "robot/bell", subject="eve"))
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    assert (await bob.result("openrois.lease.query", LAMP))["lease"]["stopped_by"] == ""
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    for app in (agent, bob):
        told = await app.until("openrois.lease.stopped")
        assert told == {"engine_id": "robot", "by": "ann", "reason": WAITS, "stop_id": told["stop_id"]}
        assert told["stop_id"]
    late = await robot.app(SCRIPT)
    lease = (await late.result("openrois.lease.query", LAMP))["lease"]
    assert (lease["stopped_by"], lease["stop_id"]) == ("ann", told["stop_id"])
    assert await bob.code("openrois.lease.release_stop", ROBOT) == "OK"
    why_back = "robot was handed back to programs by bob"
    back = {"engine_id": "robot", "by": "", "reason": why_back, "stop_id": told["stop_id"]}
    for app in (agent, bob, late):
        assert await app.until("openrois.lease.stopped") == back
    # It was handed back already, which changes nothing.
    assert await bob.code("openrois.lease.release_stop", ROBOT) == "OK"
    for app in (agent, bob, stranger):
        frames = await app.ask("openrois.hello", {"version": "1", "extensions": []})
        assert not any("openrois.lease.stopped" in frame for frame in frames)


async def test_each_stop_of_the_same_person_is_told_and_reaches_the_body(robot: Robot) -> None:
    ann, agent, bob = await robot.app(ANN), await robot.app(AGENT), await robot.app(BOB)
    stops: list[None] = []

    async def stop() -> None:
        stops.append(None)

    robot.lamp.stop = stop  # type: ignore[method-assign]
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    assert (await bob.result("openrois.lease.query", LAMP))["lease"]["stopped_by"] == ""
    for times in range(1, 4):
        assert await ann.code("openrois.stop_all", ROBOT) == "OK"
        assert len(stops) == times
        for app in (agent, bob):
            assert (await app.until("openrois.lease.stopped"))["by"] == "ann"
    assert [holds for _, holds, _ in robot.told.holders] == [True, False, False, False]
    assert await records(robot) == [("ann", "openrois.stop_all", "robot", "programs wait")] * 3


async def test_a_hand_back_that_comes_late_ends_no_later_stop(robot: Robot) -> None:
    ann, bob, agent = await robot.app(ANN), await robot.app(BOB), await robot.app(AGENT)
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    stop_ids = []
    for app in (ann, bob):
        assert await app.code("openrois.stop_all", ROBOT) == "OK"
        stop_ids.append((await agent.until("openrois.lease.stopped"))["stop_id"])
    assert len(set(stop_ids)) == 2
    late, current = ({**ROBOT, "stop_id": stop_id} for stop_id in stop_ids)
    assert await ann.code("openrois.lease.release_stop", late) == "OUT_OF_RESOURCES"
    assert await why(ann) == "robot was stopped again meanwhile, by bob: hand it back anew"
    assert await robot.run(agent) == "OUT_OF_RESOURCES"
    assert await ann.code("openrois.lease.release_stop", current) == "OK"
    assert await robot.run(agent) == "OK"
    # What has ended is not stopped: that is no error.
    assert await ann.code("openrois.lease.release_stop", late) == "OK"


async def test_copies_of_one_stop_are_told_once(robot: Robot) -> None:
    ann, agent = await robot.app(ANN), await robot.app(AGENT)
    assert await agent.code("rois.command.bind", LAMP) == "OK"
    for stop_id in ("one", "one", "two"):
        assert await ann.code("openrois.stop_all", {**ROBOT, "stop_id": stop_id}) == "OK"
    assert [(await agent.until("openrois.lease.stopped"))["stop_id"] for _ in range(2)] == ["one", "two"]
    assert await ann.code("openrois.stop_all", {**ROBOT, "stop_id": "x" * 65}) == -32602


async def test_without_tokens_stop_is_no_latch(robot: Robot) -> None:
    one, other = await robot.app(LOCAL), await robot.app(LOCAL)
    assert await one.code("rois.command.bind", LAMP) == "OK"
    assert await other.code("openrois.stop_all", ROBOT) == "OK"
    assert await robot.run(one) == "OK"
    assert await other.code("openrois.lease.release_stop", ROBOT) == "OK"


async def test_a_program_without_a_token_waits_where_persons_have_some(robot: Robot) -> None:
    program, ann = await robot.app(LOCAL), await robot.app(ANN)
    assert await program.code("rois.command.bind", LAMP) == "OK"
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    assert await robot.run(program) == "OUT_OF_RESOURCES"
    assert await program.code("openrois.lease.release_stop", ROBOT) == "UNSUPPORTED"
    assert await ann.code("openrois.lease.release_stop", ROBOT) == "OK"
    assert await robot.run(program) == "OK"


async def test_a_token_of_another_rank_counts_at_once(robot: Robot) -> None:
    ann, expiry = await robot.app(ANN), TokenExpiry(principal("operator", "*", subject="dora", rank="person"))
    dora = await robot.app(expiry)
    assert await dora.code("rois.command.bind", LAMP) == "OK"
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    assert await robot.run(dora) == "OK"
    expiry.replace(principal("operator", "*", subject="dora", rank="agent"))
    assert await robot.run(dora) == "OUT_OF_RESOURCES"
    expiry.replace(principal("operator", "*", subject="dora", rank="person"))
    assert await robot.run(dora) == "OK"
    assert [holds for _, holds, _ in robot.told.holders] == [True, False, True]


async def test_it_is_in_the_audit_trail(robot: Robot) -> None:
    ann, bob = await robot.app(ANN), await robot.app(BOB)
    assert await ann.code("openrois.stop_all", ROBOT) == "OK"
    for _ in range(2):
        assert await bob.code("openrois.lease.release_stop", ROBOT) == "OK"
    assert await records(robot) == [
        ("ann", "openrois.stop_all", "robot", "programs wait"),
        ("bob", "openrois.lease.release_stop", "robot", "stopped by ann"),
        ("bob", "openrois.lease.release_stop", "robot", "it was not stopped"),
    ]


async def records(robot: Robot) -> list[tuple[str, str, str, str]]:
    """Wait until a thread has written all lines so far; return who did what about STOP."""
    robot.here.host.audit.require()
    # Lines keep their order: behind the last one of the test comes this one.
    robot.here.host.audit.acted(None, _LAST, "")
    async with asyncio.timeout(10):
        while not (told := written(robot.audit)) or told[-1].get("method") != _LAST:
            await turn()
    return [
        (line["who"], line["method"], line["subject"], line["detail"])
        for line in told
        if "stop" in line.get("method", "")
    ]


def written(audit: Path) -> list[dict[str, Any]]:
    """Return the lines of the audit trail that are there as a whole."""
    return [json.loads(line) for line in audit.read_text().splitlines(keepends=True) if line.endswith("\n")]


@pytest.mark.parametrize("seed", range(4))
async def test_no_command_of_a_program_is_accepted_while_a_person_keeps_the_body_stopped(
    robot: Robot, seed: int
) -> None:
    """Whatever persons, programs and new tokens do: beside the name of the person that has stopped it last."""
    chance = random.Random(seed)
    expiry = TokenExpiry(BOB)
    apps = {"ann": await robot.app(ANN), "agent": await robot.app(AGENT), "bob": await robot.app(expiry)}
    ranks = {"ann": "person", "agent": "agent", "bob": "person"}
    holder, by, runs, refused = "", "", 0, 0
    for _ in range(300):
        who = chance.choice(list(apps))
        app, is_person = apps[who], ranks[who] == "person"
        match chance.choice(("stop", "release_stop", "bind", "release", "run", "run", "run", "rank")):
            case "stop":
                assert await app.code("openrois.stop_all", ROBOT) == "OK"
                by = who if is_person else by
            case "release_stop":
                allowed = "OK" if is_person else "UNSUPPORTED"
                assert await app.code("openrois.lease.release_stop", ROBOT) == allowed
                by = "" if is_person else by
            case "bind":
                allowed = "OK" if holder in ("", who) else "OUT_OF_RESOURCES"
                assert await app.code("rois.command.bind", LAMP) == allowed
                holder = holder or who
            case "release":
                assert await app.code("rois.command.release", LAMP) == "OK"
                holder = "" if holder == who else holder
            case "rank":
                ranks["bob"] = chance.choice(("person", "agent"))
                expiry.replace(principal("operator", "*", subject="bob", rank=ranks["bob"]))
            case _:
                may = holder == who and (is_person or not by)
                assert await robot.run(app) == ("OK" if may else "OUT_OF_RESOURCES")
                runs, refused = runs + may, refused + (holder == who and not may)
        assert robot.lamp.total == runs
        assert robot.here.host.stop_latch.by("robot") == by
    assert refused
    assert runs
