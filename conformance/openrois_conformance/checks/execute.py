"""The Command interface: running commands, one by one and in sequences, and their ends and results."""

from typing import Any, Final

from openrois_conformance.application import COMPLETED, Application
from openrois_conformance.checks.command import BIND, MISFITS
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.probe_profiles import FATES, PARAMETERS, sample
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

EXECUTE: Final = "rois.command.execute"
RESULT: Final = "rois.command.get_command_result"


def _unit(command_id: str, ref: str, command: str = "echo", **more: Any) -> dict[str, Any]:
    return {"component_ref": ref, "command_type": command, "command_id": command_id, **more}


def _argument(name: str, value: str, code: str = "whatever") -> dict[str, str]:
    return {"name": name, "data_type_ref": code, "value": value}


async def _accepted(app: Application, *units: dict[str, Any]) -> None:
    await app.granted(EXECUTE, command_unit_list=list(units))


async def _refused(app: Application, code: str, *units: dict[str, Any]) -> None:
    await app.refused(EXECUTE, code, command_unit_list=list(units))


async def _ended(app: Application, **wanted: str) -> None:
    expect("how the commands completed", await app.completed(*wanted), wanted)


async def _results(app: Application, command_id: str) -> list[dict[str, str]]:
    found: list[dict[str, str]] = (await app.granted(RESULT, command_id=command_id))["results"]
    return found


@CHECKS("execute-order", Needs.ADAPTER)
async def _execute_order(stage: Stage) -> None:
    """`execute` is answered first; `completed` comes afterwards, once."""
    app = await stage.application()
    for number in range(20):
        command_id = f"c{number}"
        request_id = await app.begin(EXECUTE, command_unit_list=[_unit(command_id, stage.ref("eye"))])
        first = await app.hear()
        if first.get("id") != request_id:
            raise Deviation("the reply of execute before its `completed`", shown(first))
        expect("the reply of execute", first.get("result"), {"return_code": "OK"})
        expect("how it completed", (await app.next(COMPLETED)), {"command_id": command_id, "status": "OK"})
    await stage.settle(app)


@CHECKS("execute-asynchronous", Needs.ADAPTER)
async def _execute_asynchronous(stage: Stage) -> None:
    """`execute` is answered while the command still runs."""
    app = await stage.application()
    eye = stage.ref("eye")
    await _accepted(app, _unit("c", eye, "hang"))
    await stage.probe.hangs(eye)
    await stage.settle(app)
    await stage.probe.finish(eye)
    await _ended(app, c="OK")


@CHECKS("execute-to-its-sender", Needs.ADAPTER)
async def _execute_to_its_sender(stage: Stage) -> None:
    """`completed` goes to the application that started the command and to no other."""
    app, other = await stage.application(), await stage.application()
    await _accepted(app, _unit("c", stage.ref("eye")))
    await _ended(app, c="OK")
    await stage.settle(other)


@CHECKS("execute-results", Needs.ADAPTER)
async def _execute_results(stage: Stage) -> None:
    """`get_command_result` answers the command's results: values of every type, as text, unchanged."""
    app = await stage.application()
    arguments = [_argument(name, sample(code), code) for name, code, _ in PARAMETERS]
    await _accepted(app, _unit("c", stage.ref("eye"), arguments=arguments))
    await _ended(app, c="OK")
    for _ in range(2):
        expect("the results", await _results(app, "c"), arguments)


@CHECKS("execute-statuses", Needs.ADAPTER)
async def _execute_statuses(stage: Stage) -> None:
    """A command that a component ends with ERROR, ABORT, OUT_OF_RESOURCES or TIMEOUT completes so, without results."""
    app = await stage.application()
    for command, status in FATES.items():
        await _accepted(app, _unit(command, stage.ref("eye"), command))
        expect(f"how {command} completed", await app.completed(command), {command: status})
        expect(f"the results of {command}", await _results(app, command), [])


@CHECKS("execute-adapter-refuses", Needs.ADAPTER)
async def _execute_adapter_refuses(stage: Stage) -> None:
    """A command that the adapter refuses, or fails over, completes OUT_OF_RESOURCES or ERROR: execute was accepted."""
    app = await stage.application()
    eye = stage.ref("eye")
    await _accepted(app, _unit("refused", eye, "refuse"))
    await _ended(app, refused="OUT_OF_RESOURCES")
    await _accepted(app, _unit("crashed", eye, "crash"))
    await _ended(app, crashed="ERROR")


@CHECKS("execute-running-result", Needs.ADAPTER)
async def _execute_running_result(stage: Stage) -> None:
    """`get_command_result` of a command that runs is OK and empty."""
    app = await stage.application()
    eye = stage.ref("eye")
    await _accepted(app, _unit("c", eye, "hang"))
    await stage.probe.hangs(eye)
    expect("the results of a command that runs", await _results(app, "c"), [])
    await stage.probe.finish(eye)
    await _ended(app, c="OK")


@CHECKS("command-result-refused", Needs.ADAPTER)
async def _command_result_refused(stage: Stage) -> None:
    """`get_command_result` of an unknown id, or with a condition, is answered BAD_PARAMETER."""
    app = await stage.application()
    await _accepted(app, _unit("c", stage.ref("eye")))
    await _ended(app, c="OK")
    await app.refused(RESULT, "BAD_PARAMETER", command_id="unknown")
    await app.refused(RESULT, "BAD_PARAMETER", command_id="")
    await app.refused(RESULT, "BAD_PARAMETER", command_id="c", condition="component_ref = 'x'")


@CHECKS("command-result-of-others", Needs.ADAPTER)
async def _command_result_of_others(stage: Stage) -> None:
    """The results of a command are its application's: to another its id is unknown."""
    app, other = await stage.application(), await stage.application()
    await _accepted(app, _unit("conformance-theirs", stage.ref("eye")))
    await app.completed("conformance-theirs")
    if await other.code(RESULT, command_id="conformance-theirs") == "OK":
        stage.remark("any application that guesses a command_id reads its results, as at the reference engine")


@CHECKS("execute-unknown", Needs.ADAPTER)
async def _execute_unknown(stage: Stage) -> None:
    """A unit for a component or a command type that is not there is answered UNSUPPORTED."""
    app = await stage.application()
    eye = stage.ref("eye")
    for unit in (
        _unit("c", "conformance-nowhere/eye"),
        _unit("c", f"{stage.probe.engine.engine_id}/absent"),
        _unit("c", eye, "explode"),
        _unit("c", eye, ""),
        _unit("c", eye, "get_parameter"),
        _unit("c", stage.ref("person_detecter"), "set_parameter"),
    ):
        await _refused(app, "UNSUPPORTED", unit)
    expect("the commands that reached the adapter", stage.probe.params_of(EXECUTE), [])


@CHECKS("execute-needs-bind", Needs.ADAPTER)
async def _execute_needs_bind(stage: Stage) -> None:
    """A command of an actuation is answered OUT_OF_RESOURCES unless the application has bound it; others are open."""
    app, other = await stage.application(), await stage.application()
    arm = stage.ref("arm")
    await _refused(app, "OUT_OF_RESOURCES", _unit("c", arm))
    await other.granted(BIND, component_ref=arm)
    await _refused(app, "OUT_OF_RESOURCES", _unit("c", arm))
    await _refused(app, "OUT_OF_RESOURCES", _unit("o", stage.ref("eye")), _unit("c", arm))
    expect("the commands that reached the adapter", stage.probe.params_of(EXECUTE), [])
    await _accepted(other, _unit("c", arm))
    await _ended(other, c="OK")
    for name in ("eye", "tool", "thing"):
        await _accepted(app, _unit(name, stage.ref(name)))
        expect("how it completed", await app.completed(name), {name: "OK"})


@CHECKS("execute-misfit", Needs.ADAPTER)
async def _execute_misfit(stage: Stage) -> None:
    """An argument that is not in the profile or does not fit its type is answered BAD_PARAMETER."""
    app = await stage.application()
    for name, value in MISFITS:
        await _refused(app, "BAD_PARAMETER", _unit("c", stage.ref("eye"), arguments=[_argument(name, value)]))
    expect("the commands that reached the adapter", stage.probe.params_of(EXECUTE), [])


@CHECKS("execute-ids", Needs.ADAPTER)
async def _execute_ids(stage: Stage) -> None:
    """A command_id that is empty, repeated, in use, remembered, or led by an engine's id is answered BAD_PARAMETER."""
    app = await stage.application()
    eye, engine_id = stage.ref("eye"), stage.probe.engine.engine_id
    gateway = (await app.tree()).identifier.code
    for units in (
        [_unit("", eye)],
        [_unit("a", eye), _unit("a", eye)],
        [_unit("a", eye), {"command_list": [_unit("b", eye), _unit("a", eye)]}],
        [_unit(f"{engine_id}/1", eye)],
        [_unit(f"{gateway}/1", eye)],
    ):
        await _refused(app, "BAD_PARAMETER", *units)
    await _accepted(app, _unit("a", eye, "hang"))
    await stage.probe.hangs(eye)
    await _refused(app, "BAD_PARAMETER", _unit("a", eye))
    await stage.probe.finish(eye)
    await _ended(app, a="OK")
    await _refused(app, "BAD_PARAMETER", _unit("a", eye))


@CHECKS("execute-free-ids", Needs.ADAPTER)
async def _execute_free_ids(stage: Stage) -> None:
    """A command_id with a slash that no engine's id leads is accepted."""
    app = await stage.application()
    for command_id in ("x/1", stage.probe.engine.engine_id, "日本", "a" * 200):
        await _accepted(app, _unit(command_id, stage.ref("eye")))
        expect("how it completed", await app.completed(command_id), {command_id: "OK"})


@CHECKS("execute-same-id", Needs.ADAPTER)
async def _execute_same_id(stage: Stage) -> None:
    """Two applications may use the same command_id, and each is notified of its own command."""
    app, other = await stage.application(), await stage.application()
    eye = stage.ref("eye")
    await _accepted(app, _unit("conformance-same", eye, arguments=[_argument("label", "mine")]))
    await app.completed("conformance-same")
    unit = _unit("conformance-same", eye, arguments=[_argument("label", "theirs")])
    code = await other.code(EXECUTE, command_unit_list=[unit])
    if code == "BAD_PARAMETER":
        stage.remark("a command_id is taken for all applications once one has used it, as at the reference engine")
        return
    expect("the return_code of execute", code, "OK")
    await other.completed("conformance-same")
    for session, value in ((app, "mine"), (other, "theirs")):
        expect("the results", [each["value"] for each in await _results(session, "conformance-same")], [value])


@CHECKS("execute-all-or-nothing", Needs.ADAPTER)
async def _execute_all_or_nothing(stage: Stage) -> None:
    """Every unit is checked before any starts: a refusal starts nothing and completes nothing."""
    app = await stage.application()
    eye = stage.ref("eye")
    for last, code in (
        (_unit("z", eye, "explode"), "UNSUPPORTED"),
        (_unit("z", stage.ref("arm")), "OUT_OF_RESOURCES"),
        (_unit("z", eye, arguments=[_argument("count", "many")]), "BAD_PARAMETER"),
        (_unit("a", eye), "BAD_PARAMETER"),
        ({"command_list": [_unit("y", eye), _unit("z", eye, "explode")]}, "UNSUPPORTED"),
    ):
        await _refused(app, code, _unit("a", eye), _unit("b", eye), last)
    expect("the commands that reached the adapter", stage.probe.params_of(EXECUTE), [])
    await stage.settle(app)
    await _accepted(app, _unit("a", eye))
    await _ended(app, a="OK")


@CHECKS("execute-check-order", Needs.ADAPTER)
async def _execute_check_order(stage: Stage) -> None:
    """A unit is checked for its component and type, then the reservation, then its arguments, then its id."""
    app = await stage.application()
    bad = [_argument("count", "many")]
    arm = stage.ref("arm")
    await _refused(app, "UNSUPPORTED", _unit("", arm, "explode", arguments=bad))
    await _refused(app, "OUT_OF_RESOURCES", _unit("", arm, arguments=bad))
    await app.granted(BIND, component_ref=arm)
    await _refused(app, "BAD_PARAMETER", _unit("", arm, arguments=bad))


@CHECKS("execute-empty-concurrent")
async def _execute_empty_concurrent(stage: Stage) -> None:
    """A sequence whose only item runs no command is answered BAD_PARAMETER or -32602."""
    app = await stage.application()
    answer = await app.response(await app.begin(EXECUTE, command_unit_list=[{"command_list": []}]))
    if "error" in answer:
        expect("the error's code", answer["error"]["code"], -32602)
    else:
        expect("the return_code", answer["result"]["return_code"], "BAD_PARAMETER")


@CHECKS("execute-set-parameter", Needs.ADAPTER)
async def _execute_set_parameter(stage: Stage) -> None:
    """A unit `set_parameter` acts as the operation of that name."""
    app = await stage.application()
    eye = stage.ref("eye")
    await _accepted(app, _unit("c", eye, "set_parameter", arguments=[_argument("label", "by unit")]))
    await _ended(app, c="OK")
    parameters = (await app.granted("rois.command.get_parameter", component_ref=eye))["parameters"]
    expect("the label", [each["value"] for each in parameters if each["name"] == "label"], ["by unit"])


@CHECKS("sequence-order", Needs.ADAPTER)
async def _sequence_order(stage: Stage) -> None:
    """The items of a sequence run one after another, each when the one before has completed."""
    app = await stage.application()
    eye, tool = stage.ref("eye"), stage.ref("tool")
    await _accepted(app, _unit("first", eye, "hang"), _unit("second", tool, "hang"), _unit("third", eye))
    await stage.probe.hangs(eye)
    await stage.settle(app)
    expect("how many commands have started", len(stage.probe.params_of(EXECUTE)), 1)
    await stage.probe.finish(eye)
    await _ended(app, first="OK")
    await stage.probe.hangs(tool)
    expect("how many commands have started", len(stage.probe.params_of(EXECUTE)), 2)
    await stage.probe.finish(tool)
    await _ended(app, second="OK", third="OK")


@CHECKS("sequence-concurrent", Needs.ADAPTER)
async def _sequence_concurrent(stage: Stage) -> None:
    """The commands of a concurrent item run side by side, and the next item waits for all of them."""
    app = await stage.application()
    eye, tool, thing = stage.ref("eye"), stage.ref("tool"), stage.ref("thing")
    await _accepted(app, {"command_list": [_unit("a", eye, "hang"), _unit("b", tool, "hang")]}, _unit("c", thing))
    await stage.probe.hangs(eye)
    await stage.probe.hangs(tool)
    await stage.probe.finish(eye)
    await _ended(app, a="OK")
    await stage.settle(app)
    expect("how many commands have started", len(stage.probe.params_of(EXECUTE)), 2)
    await stage.probe.finish(tool)
    await _ended(app, b="OK", c="OK")


@CHECKS("sequence-delay", Needs.ADAPTER)
async def _sequence_delay(stage: Stage) -> None:
    """A delay_time passes before its command starts, in items, concurrent items and the commands in them."""
    app = await stage.application()
    eye = stage.ref("eye")
    concurrent = {"command_list": [_unit("b", eye, delay_time=60)], "delay_time": 60}
    await _accepted(app, _unit("a", eye, delay_time=60), concurrent, _unit("c", eye, delay_time=None))
    await _ended(app, a="OK", b="OK", c="OK")
    at = [frame.at for frame in stage.setting.transcript.frames if frame.who == "adapter" and EXECUTE in frame.text]
    began = next(frame.at for frame in stage.setting.transcript.frames if frame.outgoing and EXECUTE in frame.text)
    if at[0] - began < 0.055 or at[1] - at[0] < 0.11:
        raise Deviation("delays of 60 and 120 ms", f"{(at[0] - began) * 1000:.0f} and {(at[1] - at[0]) * 1000:.0f} ms")


@CHECKS("sequence-abort", Needs.ADAPTER)
async def _sequence_abort(stage: Stage) -> None:
    """Commands after one that did not end OK complete ABORT without having run; their results are OK and empty."""
    app = await stage.application()
    eye, tool = stage.ref("eye"), stage.ref("tool")
    await _accepted(
        app,
        _unit("first", eye),
        {"command_list": [_unit("fails", eye, "fail"), _unit("beside", tool)]},
        _unit("after", eye),
        {"command_list": [_unit("later", eye), _unit("latest", tool)]},
    )
    await _ended(app, first="OK", fails="ERROR", beside="OK", after="ABORT", later="ABORT", latest="ABORT")
    expect("how many commands have started", len(stage.probe.params_of(EXECUTE)), 3)
    expect("the results of a command that never ran", await _results(app, "later"), [])
    await stage.settle(app)


@CHECKS("sequence-of-who-left", Needs.ADAPTER)
async def _sequence_of_who_left(stage: Stage) -> None:
    """The commands of an application whose connection ended go on."""
    leaving = await stage.application()
    eye, tool = stage.ref("eye"), stage.ref("tool")
    await _accepted(leaving, _unit("a", eye, "hang"), _unit("b", tool, "hang"))
    await stage.probe.hangs(eye)
    await leaving.socket.close()
    app = await stage.application()
    await stage.settle(app)
    await stage.probe.finish(eye)
    await stage.probe.hangs(tool)


@CHECKS("sequence-adapter-lost", Needs.ADAPTER)
async def _sequence_adapter_lost(stage: Stage) -> None:
    """The running commands of an adapter that is lost complete ERROR, once; what follows them ABORT."""
    app = await stage.application()
    second = await stage.attached()
    eye = second.ref("eye")
    await _accepted(app, _unit("runs", eye, "hang"), _unit("waits", eye))
    await second.hangs(eye)
    await second.socket.close()
    await _ended(app, runs="ERROR", waits="ABORT")
    await stage.until_there(eye, there=False)
    await _refused(app, "UNSUPPORTED", _unit("late", eye))
    await stage.settle(app)
