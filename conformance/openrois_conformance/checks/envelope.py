"""JSON-RPC as the base wire speaks it: requests, errors, and messages that are never answered."""

import json
from typing import Any, Final

from openrois_conformance.application import Application
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

CONNECT: Final = {"jsonrpc": "2.0", "id": "c", "method": "rois.system.connect"}
SEARCH: Final = {**CONNECT, "method": "rois.command.search"}


async def _refused(app: Application, raw: Any, request_id: Any, *codes: int) -> None:
    answer = await app.answer_to(raw)
    if "error" not in answer:
        raise Deviation(f"the error {' or '.join(map(str, codes))} to {shown(raw)}", shown(answer))
    expect(f"the error's code for {shown(raw)}", answer["error"]["code"], *codes)
    expect(f"the id of the answer to {shown(raw)}", answer["id"], request_id)


async def _serves(app: Application) -> None:
    await app.granted("rois.system.connect")


@CHECKS("frame-not-json")
async def _not_json(stage: Stage) -> None:
    """Text that is not JSON is answered -32700 with id null."""
    app = await stage.application()
    for raw in ("{", "", "nonsense", "[" * 20_000):
        await _refused(app, raw, None, -32700)
    await _serves(app)


@CHECKS("frame-not-a-number")
async def _not_a_number(stage: Stage) -> None:
    """NaN, infinite numbers and integers of thousands of digits do not break the connection; they are no JSON."""
    app = await stage.application()
    request = '{{"jsonrpc":"2.0","id":{},"method":"rois.system.connect"}}'
    await _refused(app, request.format("9" * 5000), None, -32700, -32600)
    for number in ("NaN", "Infinity", "-Infinity"):
        answer = await app.answer_to(request.format(number))
        if "error" in answer:
            expect(f"the error's code for the id {number}", answer["error"]["code"], -32700, -32600)
        else:
            stage.remark("NaN and Infinity are taken for numbers, as by the reference engine; they are no JSON")
    await _serves(app)


@CHECKS("frame-not-an-object")
async def _not_an_object(stage: Stage) -> None:
    """JSON that is no object is answered -32600 with id null."""
    app = await stage.application()
    for raw in ('"rois.system.connect"', "5", "true", "null"):
        await _refused(app, raw, None, -32600)
    await _serves(app)


@CHECKS("frame-no-batch")
async def _no_batch(stage: Stage) -> None:
    """A batch is answered with one -32600."""
    app = await stage.application()
    for raw in ("[]", json.dumps([CONNECT]), json.dumps([CONNECT, CONNECT])):
        await _refused(app, raw, None, -32600)
    await _serves(app)


@CHECKS("frame-version")
async def _version(stage: Stage) -> None:
    """A request whose jsonrpc is not "2.0" is answered -32600 with its id."""
    app = await stage.application()
    for version in ("1.0", 2.0, None, "2"):
        await _refused(app, {**CONNECT, "jsonrpc": version}, "c", -32600)
    await _refused(app, {"id": "c", "method": "rois.system.connect"}, "c", -32600)


@CHECKS("frame-method-type")
async def _method_type(stage: Stage) -> None:
    """A method that is no string is answered -32600 with the request's id."""
    app = await stage.application()
    methods: tuple[Any, ...] = (5, None, True, ["rois.system.connect"], {})
    for method in methods:
        await _refused(app, {**CONNECT, "method": method}, "c", -32600)


@CHECKS("frame-id-type")
async def _id_type(stage: Stage) -> None:
    """An id that is neither string, number nor null is answered -32600 with id null."""
    app = await stage.application()
    ids: tuple[Any, ...] = (True, False, {}, ["c"])
    for request_id in ids:
        await _refused(app, {**CONNECT, "id": request_id}, None, -32600)


@CHECKS("frame-id-echo")
async def _id_echo(stage: Stage) -> None:
    """An id comes back as it was: a string as that string, a number as that number, null as null."""
    app = await stage.application()
    for request_id in ("req-1", "", "日本", "7", 7, -1, 0, 2.5, None):
        answer = await app.answer_to({**CONNECT, "id": request_id})
        expect(f"the id of the answer to id {json.dumps(request_id)}", answer["id"], request_id)
        expect("the result of connect", answer.get("result"), {"return_code": "OK"})


@CHECKS("frame-extra-members")
async def _extra_members(stage: Stage) -> None:
    """Further members of a request's envelope are ignored or refused, and do not break the connection."""
    app = await stage.application()
    answer = await app.answer_to({**CONNECT, "trace": "x"})
    if "error" in answer:
        expect("the error's code", answer["error"]["code"], -32600)
        stage.remark("further members of an envelope are refused; the reference engine ignores them")
    await _serves(app)


@CHECKS("frame-notifications")
async def _notifications(stage: Stage) -> None:
    """A message with a method and no id is not answered, whatever it says."""
    app = await stage.application()
    for message in (
        {"method": "rois.system.connect"},
        {"method": "rois.event.unsubscribe", "params": {"subscribe_id": "x"}},
        {"method": "no such thing", "params": [1]},
        {"method": "rois.command.bind", "params": {"wrong": 1}},
    ):
        await app.send({"jsonrpc": "2.0", **message})
    await app.silent("notifications of an application have no answer")


@CHECKS("frame-stray-answers")
async def _stray_answers(stage: Stage) -> None:
    """A response without a request is ignored or answered -32600, and does not break the connection."""
    app = await stage.application()
    await app.send({"jsonrpc": "2.0", "id": 99, "result": {}})
    app.expect_answer_to("after")
    answer = await app.answer_to({**CONNECT, "id": "after"})
    if "error" in answer:
        expect("the error's code", answer["error"]["code"], -32600)
        stage.remark("a response that was not asked for is answered with an error; ours is silent")
        await app.response("after")
    await _serves(app)


@CHECKS("frame-unknown-method")
async def _unknown_method(stage: Stage) -> None:
    """A method that is not in the catalog is answered -32601, with the id and whatever the params."""
    app = await stage.application()
    for method in (
        "",
        "connect",
        "rois.system.connect ",
        "rois.System.connect",
        "rois.system.__init__",
        "rpc.discover",
    ):
        await _refused(app, {**CONNECT, "method": method}, "c", -32601)
    await _refused(app, {**CONNECT, "method": "nothing", "params": [1]}, "c", -32601)


@CHECKS("frame-notification-names")
async def _notification_names(stage: Stage) -> None:
    """The names of notifications are no methods: a request with one is answered -32601."""
    app = await stage.application()
    for method in (
        "rois.command.completed",
        "rois.event.notify_event",
        "rois.system.notify_error",
        "rois.system.profile_changed",
        "rois.event.notify",
        "rois.stream.notify_status",
    ):
        await _refused(app, {**CONNECT, "method": method}, "c", -32601)


@CHECKS("frame-params-object")
async def _params_object(stage: Stage) -> None:
    """Params that are no object are answered -32602."""
    app = await stage.application()
    for params in ([1], "x", 5, True):
        await _refused(app, {**CONNECT, "params": params}, "c", -32602)


@CHECKS("frame-params-absent")
async def _params_absent(stage: Stage) -> None:
    """Params that are absent or null are an empty object."""
    app = await stage.application()
    for message in (SEARCH, {**SEARCH, "params": None}, {**SEARCH, "params": {}}):
        answer = await app.answer_to(message)
        if answer.get("result", {}).get("return_code") != "OK":
            raise Deviation(f"OK to {shown(message)}", shown(answer))


_MISFITS: Final[tuple[tuple[str, dict[str, Any], str], ...]] = (
    ("rois.system.connect", {"extra": 1}, "extra"),
    ("rois.system.get_profile", {"condition": 5}, "condition"),
    ("rois.system.get_error_detail", {}, "error_id"),
    ("rois.command.search", {"condition": None}, "condition"),
    ("rois.command.search", {"condition": "", "limit": 5}, "limit"),
    ("rois.command.bind", {}, "component_ref"),
    ("rois.command.bind", {"component_ref": 5}, "component_ref"),
    ("rois.command.bind", {"component_ref": None}, "component_ref"),
    ("rois.command.bind_any", {"component_ref": "x"}, "component_ref"),
    ("rois.command.release", {"component_ref": ["x"]}, "component_ref"),
    ("rois.command.get_parameter", {}, "component_ref"),
    ("rois.command.set_parameter", {"component_ref": "x"}, "parameters"),
    ("rois.command.set_parameter", {"component_ref": "x", "parameters": None}, "parameters"),
    (
        "rois.command.set_parameter",
        {"component_ref": "x", "parameters": [{"name": "n", "data_type_ref": "s", "value": 1}]},
        "parameters.0.value",
    ),
    ("rois.command.execute", {"command_unit_list": []}, "command_unit_list"),
    (
        "rois.command.execute",
        {"command_unit_list": [{"component_ref": "x/y", "command_type": "t", "command_id": 1}]},
        "command_unit_list.0.command_id",
    ),
    (
        "rois.command.execute",
        {"command_unit_list": [{"component_ref": "x/y", "command_type": "t", "command_id": "c", "priority": 1}]},
        "command_unit_list.0.priority",
    ),
    ("rois.command.get_command_result", {}, "command_id"),
    ("rois.query.query", {"query_type": "x", "component_ref": "x/y"}, "component_ref"),
    ("rois.event.subscribe", {"condition": ""}, "event_type"),
    ("rois.event.unsubscribe", {"subscribe_id": 1}, "subscribe_id"),
    ("rois.event.get_event_detail", {"event_id": True}, "event_id"),
)


@CHECKS("params-misfit")
async def _params_misfit(stage: Stage) -> None:
    """Params with a missing, superfluous or wrongly typed field are answered -32602."""
    app = await stage.application()
    for method, params, _ in _MISFITS:
        await _refused(app, {**CONNECT, "method": method, "params": params}, "c", -32602)


@CHECKS("params-misfit-named")
async def _params_misfit_named(stage: Stage) -> None:
    """The data of a -32602 is a list of path and message, and the dotted path names the field that is wrong."""
    app = await stage.application()
    for method, params, path in _MISFITS:
        error = await app.error(method, -32602, **params)
        problems = error.get("data")
        fits = isinstance(problems, list) and all(
            isinstance(problem, dict) and set(problem) == {"path", "message"} for problem in problems
        )
        if not fits or not problems:
            raise Deviation(f"data of a -32602 to {method} as a list of path and message", shown(error))
        paths = [str(problem["path"]) for problem in problems]
        # The error of a union names its members, too, as in command_unit_list.0.CommandUnit.command_id.
        field = path.rpartition(".")[2]
        if not any(found == path or found.rpartition(".")[2] == field for found in paths):
            raise Deviation(f"a problem at {path} of {method}", shown(problems))


@CHECKS("params-integers")
async def _params_integers(stage: Stage) -> None:
    """A delay_time that is no integer of at least 0 is refused, or read as a lax reader does."""
    app = await stage.application()
    for delay in ("20", 20.5, True, -5):
        unit = {"component_ref": "x/y", "command_type": "t", "command_id": "c", "delay_time": delay}
        answer = await app.answer_to(
            {**CONNECT, "method": "rois.command.execute", "params": {"command_unit_list": [unit]}}
        )
        if "error" in answer:
            expect("the error's code", answer["error"]["code"], -32602)
        else:
            expect("the return_code", answer["result"]["return_code"], "UNSUPPORTED", "BAD_PARAMETER")
            stage.remark(f"a delay_time of {json.dumps(delay)} is taken, as by the reference engine; ours refuses it")


@CHECKS("error-small")
async def _error_small(stage: Stage) -> None:
    """A refusal stays small however much is wrong."""
    app = await stage.application()
    error = await app.error("rois.command.search", -32602, **{"x" * 100 + str(number): 1 for number in range(200)})
    if (size := len(json.dumps(error))) > 64 * 1024:
        raise Deviation("an error of at most 64 KiB", f"{size} bytes")


@CHECKS("replies-out-of-order", Needs.ADAPTER)
async def _replies_out_of_order(stage: Stage) -> None:
    """A request that takes long does not keep others from being answered."""
    app = await stage.application()
    slow = await app.begin("rois.query.query", query_type="hang_of_eye")
    await stage.probe.until(lambda: bool(stage.probe.params_of("rois.query.query")), "ask its adapter")
    await app.granted("rois.system.connect")
    await stage.probe.answer_held()
    expect("the return_code of the slow query", (await app.result("rois.query.query", slow))["return_code"], "OK")


@CHECKS("results-strict")
async def _results_strict(stage: Stage) -> None:
    """Every one of the sixteen methods is served, and its result has the fields of the catalog and no other."""
    app = await stage.application()
    nowhere = "conformance-nowhere/nothing"
    unit = {"component_ref": nowhere, "command_type": "start", "command_id": "c"}
    for method, params in (
        ("rois.system.connect", {}),
        ("rois.system.get_profile", {}),
        ("rois.system.get_error_detail", {"error_id": "x"}),
        ("rois.command.search", {}),
        ("rois.command.bind", {"component_ref": nowhere}),
        ("rois.command.bind_any", {"condition": f"component_ref = '{nowhere}'"}),
        ("rois.command.release", {"component_ref": nowhere}),
        ("rois.command.get_parameter", {"component_ref": nowhere}),
        ("rois.command.set_parameter", {"component_ref": nowhere, "parameters": []}),
        ("rois.command.execute", {"command_unit_list": [unit]}),
        ("rois.command.get_command_result", {"command_id": "unknown"}),
        ("rois.query.query", {"query_type": "nothing"}),
        ("rois.event.subscribe", {"event_type": "nothing"}),
        ("rois.event.unsubscribe", {"subscribe_id": "unknown"}),
        ("rois.event.get_event_detail", {"event_id": "unknown"}),
        ("rois.system.disconnect", {}),
    ):
        await app.ask(method, **params)
