"""The connection between gateway and adapter: requests to adapters, profiles of adapters, and wrong messages."""

from typing import Any, Final

from openrois_conformance.checks.execute import EXECUTE
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.probe import Probe, new_engine_id
from openrois_conformance.probe_engine import SILENCE, Answer, ProbeEngine
from openrois_conformance.probe_profiles import component_profiles, profile_result
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

PROFILE: Final = "rois.system.get_profile"
_OWN: Final = ("connect", "disconnect", "search", "bind", "bind_any", "release")
"""Methods that a gateway answers itself and never passes on."""


@CHECKS("adapter-asked-first", Needs.ADAPTER)
async def _adapter_asked_first(stage: Stage) -> None:
    """The gateway asks an adapter that has dialled in for its profile, with an empty condition, by itself."""
    second = await stage.adapter()
    await second.until(lambda: bool(second.asked), "ask for the profile")
    method, params = second.asked[0]
    expect("what it asks first", method, PROFILE)
    expect("the params", params, {"condition": ""}, {})


@CHECKS("adapter-path", Needs.ADAPTER)
async def _adapter_path(stage: Stage) -> None:
    """A connection to the path /adapter is an adapter's, and every other an application's."""
    app = await stage.application()
    await app.granted("rois.system.connect")
    second = await stage.attached()
    await second.send('{"jsonrpc":"2.0","id":1,"method":"rois.command.search"}')
    await app.granted("rois.query.query", query_type="view", condition=f"component_ref = '{second.ref('eye')}'")
    codes = [code for code in second.refusals if code != -32601]
    expect("errors other than -32601 to a request of the adapter", codes, [])


@CHECKS("adapter-execute", Needs.ADAPTER)
async def _adapter_execute(stage: Stage) -> None:
    """An adapter is asked to execute one unit at a time, without delay_time, with the arguments as they were."""
    app = await stage.application()
    eye = stage.ref("eye")
    argument = {"name": "label", "data_type_ref": "string", "value": "hi"}
    units = [
        {"component_ref": eye, "command_type": "echo", "command_id": name, "arguments": [argument], "delay_time": 1}
        for name in ("a", "b")
    ]
    await app.granted(EXECUTE, command_unit_list=[units[0], {"command_list": [units[1]]}])
    await app.completed("a", "b")
    asked = [params["command_unit_list"] for params in stage.probe.params_of(EXECUTE)]
    expect("how many units each execute has", [len(listed) for listed in asked], [1, 1])
    for (unit,) in asked:
        expect("the delay_time", unit.get("delay_time"), None)
        expect("the component and command", (unit["component_ref"], unit["command_type"]), (eye, "echo"))
        expect("the arguments", unit["arguments"], [argument])


@CHECKS("adapter-without-hello", Needs.ADAPTER)
async def _adapter_without_hello(stage: Stage) -> None:
    """An adapter that answers nothing but get_profile is attached as one of the base wire."""
    engine_id = new_engine_id()
    engine = ProbeEngine(engine_id, component_profiles(engine_id))
    engine.answers["openrois.hello"] = SILENCE
    silent = await stage.adapter(engine)
    await stage.until_there(silent.ref("eye"))
    app = await stage.application()
    await app.granted("rois.query.query", query_type="view", condition=f"component_ref = '{silent.ref('eye')}'")


@CHECKS("adapter-command-id", Needs.ADAPTER)
async def _adapter_command_id(stage: Stage) -> None:
    """A command reaches its adapter under the id that the application chose, while that is free there."""
    app, other = await stage.application(), await stage.application()
    unit = {"component_ref": stage.ref("eye"), "command_type": "echo", "command_id": "chosen"}
    await app.granted(EXECUTE, command_unit_list=[unit])
    await app.completed(unit["command_id"])
    if await other.code(EXECUTE, command_unit_list=[unit]) == "OK":
        await other.completed(unit["command_id"])
    else:
        stage.remark("a command_id that one application has used is refused to others")
    sent = [params["command_unit_list"][0]["command_id"] for params in stage.probe.params_of(EXECUTE)]
    expect("the command_id", sent[0], stage.sent_id("chosen"))
    if len(set(sent)) != len(sent):
        raise Deviation("ids at the adapter that are all different", shown(sent))


@CHECKS("adapter-never-asked", Needs.ADAPTER)
async def _adapter_never_asked(stage: Stage) -> None:
    """connect, disconnect, search, bind, bind_any and release are the gateway's own: no adapter is asked."""
    app = await stage.application()
    arm = stage.ref("arm")
    await app.granted("rois.system.connect")
    await app.granted("rois.command.search")
    await app.granted("rois.command.bind", component_ref=arm)
    await app.granted("rois.command.bind_any", condition=f"component_ref = '{arm}'")
    unit = {"component_ref": arm, "command_type": "echo", "command_id": "c"}
    await app.granted(EXECUTE, command_unit_list=[unit])
    expect("how the command completed", await app.completed("c"), {"c": "OK"})
    await app.granted("rois.command.release", component_ref=arm)
    await app.granted("rois.system.disconnect")
    await stage.settle(app)
    strange = [method for method, _ in stage.probe.asked if method.rpartition(".")[2] in _OWN]
    expect("what the adapter was asked of these", strange, [])


@CHECKS("adapter-conditions", Needs.ADAPTER)
async def _adapter_conditions(stage: Stage) -> None:
    """Queries and subscriptions reach the adapter with the condition component_ref = '...' of the chosen component."""
    app = await stage.application()
    await app.granted("rois.query.query", query_type="view_of_deep")
    await app.granted("rois.event.subscribe", event_type="happened_to_deep")
    expect("conditions that name no component", stage.probe.engine.violations, [])
    for method in ("rois.query.query", "rois.event.subscribe"):
        condition = f"component_ref = '{stage.ref('deep')}'"
        expect(f"the condition of {method}", stage.probe.last(method)["condition"], condition)


async def _rejected(stage: Stage, engine: ProbeEngine, why: str) -> None:
    adapter = await stage.adapter(engine)
    code, reason = await adapter.closed()
    expect(f"the close code for {why}", code, 1008)
    if not reason:
        stage.remark(f"the connection is closed without a reason for {why}")


def _engine(**changes: Any) -> ProbeEngine:
    engine = ProbeEngine(new_engine_id(), {})
    engine.answers[PROFILE] = Answer({**profile_result(engine.engine_id, {}), **changes})
    return engine


@CHECKS("adapter-bad-id", Needs.ADAPTER)
async def _adapter_bad_id(stage: Stage) -> None:
    """An adapter with an engine id that is empty or has a slash is closed with 1008."""
    for engine_id in ("", "a/b"):
        engine = _engine()
        engine.answers[PROFILE] = Answer(profile_result(engine_id, {}))
        await _rejected(stage, engine, f"the engine id {engine_id!r}")


@CHECKS("adapter-taken-id", Needs.ADAPTER)
async def _adapter_taken_id(stage: Stage) -> None:
    """An adapter with an engine id that the tree has already is closed with 1008, and the first one stays."""
    app = await stage.application()
    gateway = (await app.tree()).identifier.code
    mine = stage.probe.engine.engine_id
    for engine_id in (mine, f"{mine}-below", gateway):
        await _rejected(stage, ProbeEngine(engine_id, {}), f"the taken engine id {engine_id}")
    await stage.settle(app)


@CHECKS("adapter-twice-in-itself", Needs.ADAPTER)
async def _adapter_twice_in_itself(stage: Stage) -> None:
    """An adapter in whose own tree an engine id stands twice is closed with 1008."""
    engine = _engine()
    profile = profile_result(engine.engine_id, {})["profile"]
    engine.answers[PROFILE] = Answer(
        {**profile_result(engine.engine_id, {}), "profile": {**profile, "sub_profiles": [profile]}}
    )
    await _rejected(stage, engine, "an engine id that stands twice")


@CHECKS("adapter-foreign-component", Needs.ADAPTER)
async def _adapter_foreign_component(stage: Stage) -> None:
    """An adapter that lists a component of an engine that is not its own is closed with 1008."""
    engine = _engine()
    result = profile_result(engine.engine_id, {})
    foreign = "conformance-nowhere/eye"
    result["profile"]["component_ids"] = [foreign]
    eye = stage.probe.engine.profiles[stage.ref("eye")].model_dump(mode="json")
    engine.answers[PROFILE] = Answer({**result, "component_profiles": {foreign: eye}})
    await _rejected(stage, engine, "a component of another engine")


@CHECKS("adapter-missing-profile", Needs.ADAPTER)
async def _adapter_missing_profile(stage: Stage) -> None:
    """An adapter that lists a component and gives no profile of it is closed with 1008."""
    engine = _engine()
    result = profile_result(engine.engine_id, {})
    result["profile"]["component_ids"] = [f"{engine.engine_id}/eye"]
    engine.answers[PROFILE] = Answer(result)
    await _rejected(stage, engine, "a component without a profile")


@CHECKS("adapter-no-profile", Needs.ADAPTER)
async def _adapter_no_profile(stage: Stage) -> None:
    """An adapter that answers no profile, a failure or an error is closed with 1008."""
    for why, answer in (
        ("no profile", Answer({"return_code": "OK", "profile": None, "component_profiles": {}})),
        ("a failure", Answer({"return_code": "ERROR", "profile": None, "component_profiles": {}})),
        ("a JSON-RPC error", Answer(error=-32603)),
        ("a result that does not fit", Answer({"return_code": "OK", "profile": 5})),
    ):
        engine = _engine()
        engine.answers[PROFILE] = answer
        await _rejected(stage, engine, why)


@CHECKS("adapter-profile-changed", Needs.ADAPTER)
async def _adapter_profile_changed(stage: Stage) -> None:
    """After profile_changed the gateway asks the adapter again, and applications see what it offers now."""
    app = await stage.application()
    second = await stage.attached()
    eye, arm = second.ref("eye"), second.ref("arm")
    second.engine.profiles = {eye: second.engine.profiles[eye]}
    await second.send_notification("rois.system.profile_changed")
    await stage.until_there(arm, there=False)
    await app.granted("rois.query.query", query_type="view", condition=f"component_ref = '{eye}'")
    await app.refused("rois.command.bind", "UNSUPPORTED", component_ref=arm)


@CHECKS("adapter-profile-spoilt", Needs.ADAPTER)
async def _adapter_profile_spoilt(stage: Stage) -> None:
    """An adapter whose later profile is not acceptable is closed with 1008 and its components are gone."""
    second = await stage.attached()
    eye = second.ref("eye")
    second.engine.answers[PROFILE] = Answer(profile_result(stage.probe.engine.engine_id, {}))
    await second.send_notification("rois.system.profile_changed")
    expect("the close code", (await second.closed())[0], 1008)
    await stage.until_there(eye, there=False)


@CHECKS("adapter-garbage", Needs.ADAPTER)
async def _adapter_garbage(stage: Stage) -> None:
    """Messages of an adapter that make no sense are ignored and reach no application."""
    app = await stage.application()
    second = await stage.attached()
    for text in (
        "garbage",
        "[]",
        '{"jsonrpc":"2.0","id":99999,"result":{}}',
        '{"jsonrpc":"2.0","method":"rois.command.completed","params":{"command_id":"unknown","status":"OK"}}',
        '{"jsonrpc":"2.0","method":"rois.command.completed","params":{"command_id":5}}',
        '{"jsonrpc":"2.0","method":"rois.event.notify_event","params":{}}',
        '{"jsonrpc":"2.0","method":"no such thing","params":{}}',
    ):
        await second.send(text)
    await app.granted("rois.query.query", query_type="view", condition=f"component_ref = '{second.ref('eye')}'")
    await app.silent("nothing of it is for an application")


@CHECKS("adapter-foreign-ids", Needs.ADAPTER)
async def _adapter_foreign_ids(stage: Stage) -> None:
    """A subscribe_id or command_id of set_parameter that an adapter mints under another engine's id is an ERROR."""
    app = await stage.application()
    subscribe, change = "rois.event.subscribe", "rois.command.set_parameter"
    for minted in ("", "x", "conformance-nowhere/1"):
        stage.probe.engine.answers[subscribe] = Answer({"return_code": "OK", "subscribe_id": minted})
        await app.refused(subscribe, "ERROR", event_type="happened_to_tool")
        stage.probe.engine.answers[change] = Answer({"return_code": "OK", "command_id": minted})
        answer = await app.ask(change, component_ref=stage.ref("tool"), parameters=[])
        if answer["return_code"] == "OK":
            command_id = answer["command_id"]
            expect("how set_parameter completed", await app.completed(command_id), {command_id: "ERROR"})
        else:
            expect("the return_code of set_parameter", answer["return_code"], "ERROR")


_BROKEN: Final[tuple[dict[str, Any], ...]] = (
    {"return_code": "FINE"},
    {"results": []},
    {"return_code": "OK", "results": None},
    {"return_code": "OK", "results": [{"name": "n", "data_type_ref": "int", "value": 5}]},
)


@CHECKS("adapter-broken-results", Needs.ADAPTER)
async def _adapter_broken_results(stage: Stage) -> None:
    """A result of an adapter that is none is answered ERROR, and the next question is served."""
    app = await stage.application()
    for result in _BROKEN:
        stage.probe.engine.answers["rois.query.query"] = Answer(result)
        await app.refused("rois.query.query", "ERROR", query_type="view_of_eye")
    stage.probe.engine.answers.clear()
    await app.granted("rois.query.query", query_type="view_of_eye")


@CHECKS("adapter-codes", Needs.ADAPTER)
async def _adapter_codes(stage: Stage) -> None:
    """The return code with which an adapter refuses a query reaches the application."""
    app = await stage.application()
    for code in ("ERROR", "UNSUPPORTED", "OUT_OF_RESOURCES", "TIMEOUT"):
        stage.probe.engine.answers["rois.query.query"] = Answer({"return_code": code, "results": []})
        await app.refused("rois.query.query", code, query_type="view_of_eye")


@CHECKS("adapter-completed-twice", Needs.ADAPTER)
async def _adapter_completed_twice(stage: Stage) -> None:
    """An adapter that says `completed` twice, or with a status that is none, makes one `completed`."""
    app = await stage.application()
    eye = stage.ref("eye")
    unit = {"component_ref": eye, "command_type": "hang", "command_id": "c"}
    await app.granted(EXECUTE, command_unit_list=[unit])
    await stage.probe.hangs(eye)
    ((method, params),) = stage.probe.engine.finish(eye, "OK")
    await stage.probe.send_notification(method, **{**params, "status": "DONE"})
    await stage.probe.send_notification(method, **params)
    await stage.probe.send_notification(method, **{**params, "status": "ERROR"})
    expect("how the command completed", await app.completed("c"), {"c": "OK"})
    await stage.settle(app)


@CHECKS("adapter-silent", Needs.ADAPTER)
async def _adapter_silent(stage: Stage) -> None:
    """An adapter that does not answer makes a TIMEOUT within 30 s; its late answer reaches no application."""
    app = await stage.application()
    probe: Probe = stage.probe
    probe.engine.answers["rois.event.subscribe"] = SILENCE
    waiting = {
        "rois.query.query": await app.begin("rois.query.query", query_type="hang_of_eye"),
        "rois.event.subscribe": await app.begin("rois.event.subscribe", event_type="happened_to_eye"),
    }
    unit = {"component_ref": stage.ref("tool"), "command_type": "ignore", "command_id": "c"}
    await app.granted(EXECUTE, command_unit_list=[unit])
    app.patience = max(app.patience, 30.0)
    for method, request_id in waiting.items():
        result = await app.result(method, request_id)
        expect(f"the return_code of {method}", result["return_code"], "TIMEOUT")
    expect("how the command completed", await app.completed("c"), {"c": "TIMEOUT"})
    late = probe.engine.mint("sub")
    await probe.answer_held({"return_code": "OK", "subscribe_id": late})
    await probe.until(
        lambda: {"subscribe_id": late} in probe.params_of("rois.event.unsubscribe"), "end a subscription that came late"
    )
    # Applications that work with a component that does not answer may be notified of that.
    await stage.settle(app, "rois.system.notify_error")


@CHECKS("adapter-nested", Needs.ADAPTER)
async def _adapter_nested(stage: Stage) -> None:
    """Components of an engine below an adapter are found, queried, commanded and subscribed to by their references."""
    app = await stage.application()
    deep = stage.ref("deep")
    await app.granted("rois.query.query", query_type="view_of_deep")
    await app.granted("rois.event.subscribe", event_type="happened_to_deep")
    event_id = await stage.probe.happen(deep, "happened_to_deep")
    expect("the event", (await app.next("rois.event.notify_event"))["event_id"], event_id)
    unit = {"component_ref": deep, "command_type": "echo", "command_id": "c"}
    await app.granted(EXECUTE, command_unit_list=[unit])
    expect("how the command completed", await app.completed("c"), {"c": "OK"})


@CHECKS("adapter-refs-twice", Needs.ADAPTER)
async def _adapter_refs_twice(stage: Stage) -> None:
    """A second adapter with the same component names is told apart by its engine id."""
    app = await stage.application()
    second = await stage.attached(_twin())
    condition = "component_ref LIKE 'conformance-%/eye'"
    found = (await app.granted("rois.command.search", condition=condition))["component_ref_list"]
    if not {stage.ref("eye"), second.ref("eye")} <= set(found):
        raise Deviation("both components called eye", shown(found))
    await app.refused("rois.query.query", "BAD_PARAMETER", query_type="view_of_eye")
    by_ref = f"component_ref = '{second.ref('eye')}'"
    await app.granted("rois.query.query", query_type="view_of_eye", condition=by_ref)
    expect("what the first was asked", stage.probe.params_of("rois.query.query"), [])


def _twin() -> ProbeEngine:
    engine_id = new_engine_id()
    return ProbeEngine(engine_id, component_profiles(engine_id))
