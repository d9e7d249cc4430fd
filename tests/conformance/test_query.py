"""The Query interface: components that cannot work or hang, and conditions that name a stream."""

from openrois.engine.registry import MAX_QUERIES
from openrois.jsonrpc.request_queue import MAX_RUNNING_REQUESTS
from openrois.types.codes import ComponentStatus
from tests.support import deployment
from tests.support.deployment import Application, Robot


async def ask(app: Application, query_type: str, condition: str = "") -> tuple[str, list[dict[str, str]]]:
    answer = await app.ask("rois.query.query", query_type=query_type, condition=condition)
    return answer["return_code"], answer["results"]


async def test_a_component_that_cannot_work_tells_its_status_only(app: Application, robot: Robot) -> None:
    for status in (ComponentStatus.UNINITIALIZED, ComponentStatus.WARNING, ComponentStatus.ERROR):
        robot.door.is_in = status
        assert await ask(app, "view") == ("ERROR", [])
        answered, results = await ask(app, "component_status", "component_ref = 'robot/door'")
        assert (answered, results) == (
            "OK",
            [{"name": "status", "data_type_ref": "Component_Status", "value": status.value}],
        )


async def test_a_condition_names_a_stream_where_its_status_is_asked_alone(app: Application) -> None:
    assert await ask(app, "brightness", "stream_id = 'x'") == ("BAD_PARAMETER", [])
    assert await app.code("rois.system.get_profile", condition="stream_id = 'x'") == "BAD_PARAMETER"


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
