"""JSON-RPC as the base wire speaks it: what is answered, with which error, and what is never answered."""

import json
from typing import Any

import pytest

from openrois.errors import ComponentFailed
from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.deployment import Application, Robot
from tests.support.plain import TOY, attached, plain_adapter

CONNECT = {"jsonrpc": "2.0", "id": "c", "method": "rois.system.connect"}


LADDER: list[tuple[str, Any, int]] = [
    ("{", None, -32700),
    ("", None, -32700),
    ('{"jsonrpc":"2.0","id":NaN,"method":"rois.system.connect"}', None, -32700),
    ("[" * 20_000, None, -32700),
    ('{"jsonrpc":"2.0","method":"rois.system.connect","id":' + "9" * 5000 + "}", None, -32700),
    ("[]", None, -32600),
    (json.dumps([CONNECT]), None, -32600),
    ('"rois.system.connect"', None, -32600),
    ("5", None, -32600),
    (json.dumps({**CONNECT, "jsonrpc": "1.0"}), "c", -32600),
    (json.dumps({"id": "c", "method": "rois.system.connect"}), "c", -32600),
    (json.dumps({**CONNECT, "method": 5}), "c", -32600),
    (json.dumps({**CONNECT, "id": True}), None, -32600),
    (json.dumps({**CONNECT, "id": {}}), None, -32600),
    (json.dumps({**CONNECT, "id": ["c"]}), None, -32600),
    (json.dumps({"jsonrpc": "2.0", "id": "c"}), "c", -32600),
    (json.dumps({**CONNECT, "method": "rois.system.__init__"}), "c", -32601),
    (json.dumps({**CONNECT, "method": "rois.stream.notify_status"}), "c", -32601),
    (json.dumps({**CONNECT, "method": "rois.system.connect "}), "c", -32601),
    (json.dumps({**CONNECT, "method": "nothing", "params": [1]}), "c", -32601),
    (json.dumps({**CONNECT, "params": [1]}), "c", -32602),
    (json.dumps({**CONNECT, "params": "x"}), "c", -32602),
    (json.dumps({**CONNECT, "params": {"extra": 1}}), "c", -32602),
]


async def test_the_ladder_of_errors(app: Application, subtests: pytest.Subtests) -> None:
    for raw, request_id, code in LADDER:
        with subtests.test(raw[:80]):
            await app.send(raw)
            response = await app.hear()
            assert set(response) == {"jsonrpc", "id", "error"}
            assert (response["id"], response["error"]["code"]) == (request_id, code)
    assert await app.code("rois.system.connect") == "OK"


async def test_an_id_comes_back_as_it_was(app: Application) -> None:
    ids: list[Any] = ["text", "", 7, -1, 2.5, None, "\ud800", "日本"]
    for request_id in ids:
        await app.send(json.dumps({**CONNECT, "id": request_id}))
        response = await app.hear()
        assert response == {"jsonrpc": "2.0", "id": request_id, "result": {"return_code": "OK"}}
        assert type(response["id"]) is type(request_id)


async def test_missing_and_null_params_are_an_empty_object(app: Application) -> None:
    for params in ("", ', "params": null', ', "params": {}'):
        await app.send(f'{{"jsonrpc": "2.0", "id": 1, "method": "rois.command.search"{params}}}')
        assert (await app.hear())["result"]["return_code"] == "OK"


async def test_other_members_of_an_envelope_are_ignored(app: Application) -> None:
    await app.send({**CONNECT, "trace": "x"})
    assert (await app.answer("c"))["result"] == {"return_code": "OK"}


async def test_notifications_and_answers_are_not_answered(app: Application) -> None:
    for message in (
        {"method": "rois.system.connect"},
        {"method": "rois.event.unsubscribe", "params": {"subscribe_id": "x"}},
        {"method": "no such thing", "params": [1]},
        {"id": 1, "result": {}},
        {"id": "x", "error": {"code": 1, "message": "x"}},
    ):
        await app.send({"jsonrpc": "2.0", **message})
    assert await app.settled() == []
    assert len(app.heard) == 1


MISFITS: list[tuple[str, dict[str, Any], list[str]]] = [
    ("rois.command.bind", {}, ["component_ref"]),
    ("rois.command.bind", {"component_ref": 5}, ["component_ref"]),
    ("rois.command.bind", {"component_ref": None}, ["component_ref"]),
    ("rois.command.search", {"condition": None}, ["condition"]),
    ("rois.command.search", {"condition": "", "limit": 5}, ["limit"]),
    ("rois.query.query", {"query_type": "x", "component_ref": "robot/lamp"}, ["component_ref"]),
    ("rois.command.execute", {"command_unit_list": []}, ["command_unit_list"]),
    (
        "rois.command.execute",
        {"command_unit_list": [{"component_ref": "r/x", "command_type": "t", "command_id": 1}]},
        ["command_unit_list.0.command_id"],
    ),
    (
        "rois.command.set_parameter",
        {"component_ref": "r", "parameters": [{"name": "n", "data_type_ref": "s", "value": 1}]},
        ["parameters.0.value"],
    ),
]


async def test_params_that_do_not_fit_are_named(app: Application, subtests: pytest.Subtests) -> None:
    for method, params, paths in MISFITS:
        with subtests.test(f"{method} {params}"):
            error = await app.refused(method, **params)
            assert (error["code"], error["message"]) == (-32602, f"Invalid params of {method}")
            assert [set(problem) for problem in error["data"]] == [{"path", "message"}] * len(paths)
            assert [problem["path"] for problem in error["data"]] == paths


async def test_a_method_that_is_not_known_is_named(app: Application) -> None:
    assert (await app.refused("rois.stream.pause"))["message"] == "Method not found: rois.stream.pause"
    assert (await app.refused("x" * 5000))["message"] == f"Method not found: {'x' * 100}..."


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

    monkeypatch.setattr("openrois.interfaces.system._restrict", lambda *_arguments: 1 / 0)
    error = await app.refused("rois.system.get_profile", condition=ANY)
    assert error == {"code": -32603, "message": "Internal error"}
    monkeypatch.setattr("openrois.interfaces.system._restrict", fail)
    assert (await app.ask("rois.system.get_profile", condition=ANY))["return_code"] == "ERROR"
    assert "secret" not in json.dumps(app.heard)


async def test_replies_come_as_they_are_ready(app: Application, robot: Robot) -> None:
    robot.door.may_answer.clear()
    slow = await app.begin("rois.query.query", query_type="view")
    fast = await app.begin("rois.system.connect")
    await app.answer(fast)
    assert slow not in app.answers
    robot.door.may_answer.set()
    assert (await app.answer(slow))["result"]["results"][0]["value"] == "a garden"
