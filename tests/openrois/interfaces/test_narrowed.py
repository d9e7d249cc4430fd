"""Details of what was notified before a new token with a smaller scope: they are refused."""

import asyncio
import json
from typing import Any

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.token_expiry import TokenExpiry
from openrois.session.session import EngineHost
from tests.support.authorization import Place, principal
from tests.support.components import Lamp

LAMP = "robot/lamp"


async def test_events_errors_and_results_are_of_those_that_are_shown() -> None:
    engine, expiry = Engine("gateway"), TokenExpiry(principal("operator", "*"))
    await engine.attach(LocalRegistry("robot", (Lamp(), Lamp("other"))))
    async with TaskScope() as tasks, Place(EngineHost(engine, tasks), {}).application(expiry) as app:

        async def run(command_type: str, told: str) -> dict[str, Any]:
            """Run a command to its end, and return the notification that comes meanwhile, before or after it."""
            unit = {"component_ref": LAMP, "command_type": command_type, "command_id": command_type}
            assert await app.code("rois.command.execute", {"command_unit_list": [unit]}) == "OK"
            heard: dict[str, dict[str, Any]] = {}
            async with asyncio.timeout(30):
                while not {told, "rois.command.completed"} <= heard.keys():
                    frame = json.loads(app.frames.pop(0) if app.frames else await app.stream.receive())
                    heard[frame["method"]] = frame["params"]
            return heard[told]

        assert await app.code("rois.command.bind", {"component_ref": LAMP}) == "OK"
        subscribed = {"event_type": "switched", "condition": f"component_ref = '{LAMP}'"}
        assert await app.code("rois.event.subscribe", subscribed) == "OK"
        event = await run("switch", "rois.event.notify_event")
        error = await run("crash", "rois.system.notify_error")
        asked = [
            ("rois.event.get_event_detail", {"event_id": event["event_id"]}),
            ("rois.system.get_error_detail", {"error_id": error["error_id"]}),
            ("rois.command.get_command_result", {"command_id": "switch"}),
        ]
        assert [await app.code(*call) for call in asked] == ["OK"] * 3
        expiry.replace(principal("operator", "robot/other"))
        assert [await app.code(*call) for call in asked] == ["BAD_PARAMETER"] * 3
        expiry.replace(principal("operator", "robot/l*"))
        assert [await app.code(*call) for call in asked] == ["OK"] * 3


async def test_what_waits_for_its_turn_is_not_run_for_a_successor_that_is_shown_less() -> None:
    engine, lamp, turn = Engine("gateway"), Lamp(), asyncio.Event()

    async def sleep(_seconds: float) -> None:
        await turn.wait()

    await engine.attach(LocalRegistry("robot", (lamp, Lamp("other"))))
    async with TaskScope() as tasks:
        here = Place(EngineHost(engine, tasks, sleep=sleep), {})
        async with here.application(principal("operator", "*")) as former:
            token = (await former.result("openrois.lease.token", {}))["token"]
            assert await former.code("rois.command.bind", {"component_ref": LAMP}) == "OK"
            unit = {"component_ref": LAMP, "command_type": "switch", "command_id": "c", "delay_time": 5}
            assert await former.code("rois.command.execute", {"command_unit_list": [unit]}) == "OK"
            await former.stream.close(1006)
        async with here.application(principal("operator", "robot/other")) as successor:
            resumed = {"token": token, "command_ids": ["c"]}
            assert await successor.code("openrois.lease.resume", resumed) == "OK"
            turn.set()
            assert await successor.completed("c") == "ERROR"
    assert lamp.total == 0
