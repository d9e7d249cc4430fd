"""The Query interface: which component is asked, and what it may answer."""

import pytest

from openrois.engine.registry import MAX_QUERIES
from openrois.gateway.server import Gateway
from openrois.jsonrpc.request_queue import MAX_RUNNING_REQUESTS
from openrois.types.codes import ComponentStatus
from tests.support import deployment
from tests.support.components import Lamp
from tests.support.deployment import Application, Robot


async def ask(app: Application, query_type: str, condition: str = "") -> tuple[str, list[dict[str, str]]]:
    answer = await app.ask("rois.query.query", query_type=query_type, condition=condition)
    return answer["return_code"], answer["results"]


async def test_one_component_has_to_be_meant(app: Application, subtests: pytest.Subtests) -> None:
    for query_type, condition, code in [
        ("brightness", "", "OK"),
        ("brightness", "component_ref = 'robot/lamp'", "OK"),
        ("brightness", "component_ref LIKE 'robot/%' AND component_type LIKE '%::Lamp'", "OK"),
        ("component_status", "component_ref = 'robot/bell'", "OK"),
        ("component_status", "", "BAD_PARAMETER"),
        ("component_status", "component_ref LIKE 'robot/%'", "BAD_PARAMETER"),
        ("brightness", "component_ref = 'robot/bell'", "UNSUPPORTED"),
        ("brightness", "component_ref = 'robot/x'", "UNSUPPORTED"),
        ("shape", "", "UNSUPPORTED"),
        ("", "", "UNSUPPORTED"),
        ("get_parameter", "component_ref = 'robot/lamp'", "UNSUPPORTED"),
        ("brightness", "component_ref", "BAD_PARAMETER"),
        ("brightness", "level = '5'", "BAD_PARAMETER"),
        ("brightness", "stream_id = 'x'", "BAD_PARAMETER"),
    ]:
        with subtests.test(f"{query_type} {condition}"):
            answered, results = await ask(app, query_type, condition)
            assert answered == code
            assert bool(results) == (code == "OK")


async def test_what_it_answers(app: Application) -> None:
    assert await ask(app, "brightness") == ("OK", [{"name": "level", "data_type_ref": "int", "value": "5"}])


async def test_no_bind_is_needed(app: Application, other: Application) -> None:
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    assert (await ask(other, "brightness"))[0] == "OK"


async def test_a_component_that_cannot_work_tells_its_status_only(app: Application, robot: Robot) -> None:
    for status in (ComponentStatus.UNINITIALIZED, ComponentStatus.WARNING, ComponentStatus.ERROR):
        robot.door.is_in = status
        assert await ask(app, "view") == ("ERROR", [])
        answered, results = await ask(app, "component_status", "component_ref = 'robot/door'")
        assert (answered, results) == (
            "OK",
            [{"name": "status", "data_type_ref": "Component_Status", "value": status.value}],
        )


async def test_two_robots_have_to_be_told_apart(app: Application, gateway: Gateway) -> None:
    async with deployment.adapter(gateway, Lamp(), engine_id="second"):
        await app.next("rois.system.profile_changed")
        assert (await ask(app, "brightness"))[0] == "BAD_PARAMETER"
        assert (await ask(app, "brightness", "component_ref = 'second/lamp'"))[0] == "OK"


async def test_no_answer_in_time(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    sessions = deployment.adapter_sessions(monkeypatch)
    async with (
        deployment.gateway() as gateway,
        deployment.adapter(gateway, *robot.parts()),
        deployment.application(gateway) as app,
    ):
        sessions[0].call_timeout = 0
        assert await ask(app, "view") == ("TIMEOUT", [])
        sessions[0].call_timeout = 10
        assert (await ask(app, "view"))[0] == "OK"


async def test_a_component_that_hangs_blocks_no_other(app: Application, other: Application, robot: Robot) -> None:
    robot.door.may_answer.clear()
    asked = [await app.begin("rois.query.query", query_type="view") for _ in range(MAX_RUNNING_REQUESTS)]
    async with deployment.patience():
        await robot.door.asked.wait()
        assert (await ask(other, "brightness"))[0] == "OK"
        refused = [await app.answer(request_id) for request_id in asked[MAX_QUERIES:]]
    assert {answer["result"]["return_code"] for answer in refused} == {"OUT_OF_RESOURCES"}
    robot.door.may_answer.set()
    answers = [await app.answer(request_id) for request_id in asked[:MAX_QUERIES]]
    assert {answer["result"]["return_code"] for answer in answers} == {"OK"}
