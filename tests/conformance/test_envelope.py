"""JSON-RPC as the base wire speaks it: what an error says, how long it may be, and what it does not give away."""

import json

import pytest

from openrois.errors import ComponentFailed
from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.deployment import Application, Robot
from tests.support.plain import TOY, attached, plain_adapter


async def test_a_method_that_is_not_known_is_named(app: Application) -> None:
    assert (await app.refused("rois.stream.pause"))["message"] == "Method not found: rois.stream.pause"
    assert (await app.refused("x" * 5000))["message"] == f"Method not found: {'x' * 100}..."
    assert (await app.refused("rois.command.bind"))["message"] == "Invalid params of rois.command.bind"


async def test_streams_of_a_component_without_streams_are_a_result_of_rois(gateway: Gateway) -> None:
    async with plain_adapter(gateway), deployment.application(gateway) as app:
        await attached(gateway)
        for ref in (TOY, "plain/nothing"):
            answer = await app.ask("rois.stream.connect_stream", component_ref=ref)
            assert answer == {"return_code": "UNSUPPORTED", "stream_id": ""}


async def test_a_refusal_is_small_however_much_is_wrong(app: Application) -> None:
    error = await app.refused("rois.command.search", **{"x" * 500 + str(number): 1 for number in range(100)})
    assert len(json.dumps(error)) < 8000


ANY = "component_ref LIKE '%'"


async def test_a_bug_shows_nothing_of_itself(app: Application, robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot.door, "view", None)
    assert await app.ask("rois.query.query", query_type="view") == {"return_code": "ERROR", "results": []}

    def fail(*_arguments: object) -> None:
        raise ComponentFailed("the secret") from ZeroDivisionError("the secret")

    monkeypatch.setattr("openrois.engine.tree.Tree.restricted", lambda *_arguments: 1 / 0)
    error = await app.refused("rois.system.get_profile", condition=ANY)
    assert error == {"code": -32603, "message": "Internal error"}
    monkeypatch.setattr("openrois.engine.tree.Tree.restricted", fail)
    assert (await app.ask("rois.system.get_profile", condition=ANY))["return_code"] == "ERROR"
    assert "secret" not in json.dumps(app.heard)
