"""The Command interface: finding and reserving components, and their parameters."""

import asyncio
from typing import Any, Final

from openrois_conformance.application import Application
from openrois_conformance.checks.system import REFUSED_CONDITIONS
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.probe_profiles import PARAMETERS, URN, sample
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

ABSENT: Final = ("conformance-nowhere/arm", "arm", "", "/", "conformance-nowhere/arm/x")
BIND: Final = "rois.command.bind"
RELEASE: Final = "rois.command.release"
SET: Final = "rois.command.set_parameter"
GET: Final = "rois.command.get_parameter"


def _value(name: str, value: str, code: str = "whatever") -> dict[str, str]:
    return {"name": name, "data_type_ref": code, "value": value}


async def _found(app: Application, condition: str) -> list[str]:
    found: list[str] = (await app.granted("rois.command.search", condition=condition))["component_ref_list"]
    return found


@CHECKS("search", Needs.ADAPTER)
async def _search(stage: Stage) -> None:
    """`search` gives the references of the components that satisfy the condition."""
    app = await stage.application()
    engine_id, arm, deep = stage.probe.engine.engine_id, stage.ref("arm"), stage.ref("deep")
    everything = set(await _found(app, ""))
    mine = set(stage.probe.engine.profiles)
    if missing := mine - everything:
        raise Deviation("every component of the adapter to be found", f"all but {shown(sorted(missing))}")
    expect("found by reference", await _found(app, f"component_ref = '{arm}'"), [arm])
    expect("found below the adapter", await _found(app, f"component_ref LIKE '{engine_id}-below/%'"), [deep])
    mine_only = f"component_ref LIKE '{engine_id}/%'"
    probes = [ref for ref, profile in stage.probe.engine.profiles.items() if profile.component_type == URN]
    by_type = await _found(app, f"{mine_only} AND component_type = '{URN}'")
    expect("found by type", sorted(by_type), sorted(ref for ref in probes if ref != deep))
    expect("found by a type without its URN", await _found(app, f"{mine_only} AND component_type = 'Probe'"), [])


@CHECKS("component-type", Needs.ADAPTER)
async def _component_type(stage: Stage) -> None:
    """A type is the URN of authority and code in every condition: search, bind_any, subscribe, query, get_profile."""
    app = await stage.application()
    arm = stage.ref("arm")
    this = f"component_ref = '{arm}' AND component_type"
    for given in (f"{this} = '{URN}'", f"{this} LIKE 'urn:%Conformance::%'"):
        expect(f"what {given} finds", await _found(app, given), [arm])
        bound = await app.granted("rois.command.bind_any", condition=given)
        expect(f"what {given} binds", bound["component_ref"], arm)
        await app.granted("rois.event.subscribe", event_type="happened_to_arm", condition=given)
        await app.granted("rois.query.query", query_type="view_of_arm", condition=given)
        profile = await app.granted("rois.system.get_profile", condition=given)
        expect(f"the components that {given} keeps", list(profile["component_profiles"]), [arm])
    for given in (f"{this} = 'Probe'", f"{this} = 'urn:x-rois:def:component:OMG::Probe'"):
        expect(f"what {given} finds", await _found(app, given), [])
        await app.refused("rois.command.bind_any", "UNSUPPORTED", condition=given)
        await app.refused("rois.event.subscribe", "UNSUPPORTED", event_type="happened_to_arm", condition=given)
        await app.refused("rois.query.query", "UNSUPPORTED", query_type="view_of_arm", condition=given)
        profile = await app.granted("rois.system.get_profile", condition=given)
        expect(f"the components that {given} keeps", list(profile["component_profiles"]), [])


@CHECKS("condition-language", Needs.ADAPTER)
async def _condition_language(stage: Stage) -> None:
    """Conditions are CQL2-Text: = and LIKE, AND, doubled quotes, % and _ and backslash, keywords in any case."""
    app = await stage.application()
    engine_id, arm = stage.probe.engine.engine_id, stage.ref("arm")
    for condition, refs in (
        (f"  component_ref='{arm}'  ", [arm]),
        (f"\"component_ref\" = '{arm}'", [arm]),
        (f"component_ref LIKE '{engine_id}/a_m'", [arm]),
        (f"component_ref like '{engine_id}/a%m' and component_ref Like '%m'", [arm]),
        (f"component_ref LIKE '{engine_id}/a\\_m'", []),
        (f"component_ref LIKE '{engine_id}/ar\\m'", [arm]),
        (f"component_ref LIKE '{engine_id}/ARM'", []),
        (f"component_ref = '{engine_id}/a%m'", []),
        (f"component_ref = '{arm}' AND component_ref = '{stage.ref('leg')}'", []),
        ("component_ref = 'it''s'", []),
    ):
        expect(f"what {condition} finds", await _found(app, condition), refs)


@CHECKS("condition-refused")
async def _condition_refused(stage: Stage) -> None:
    """`search` answers BAD_PARAMETER to a condition that cannot be read or names an unknown property."""
    app = await stage.application()
    for condition in (
        *REFUSED_CONDITIONS,
        "component_ref = x",
        "component_ref = 'x",
        "component_ref <> 'x'",
        "NOT component_ref = 'x'",
        "(component_ref = 'x')",
        "component_ref = 5",
        "component_ref = 'x' AND",
        "name = 'arm'",
    ):
        await app.refused("rois.command.search", "BAD_PARAMETER", condition=condition)


@CHECKS("condition-linear")
async def _condition_linear(stage: Stage) -> None:
    """A LIKE that would make a naive matcher backtrack is answered at once."""
    app = await stage.application()
    await app.ask("rois.command.search", condition="component_ref LIKE '" + "%a" * 1000 + "'")


@CHECKS("bind-unknown")
async def _bind_unknown(stage: Stage) -> None:
    """`bind` and release of a component that is not there are answered UNSUPPORTED."""
    app = await stage.application()
    for ref in ABSENT:
        await app.refused(BIND, "UNSUPPORTED", component_ref=ref)
        await app.refused(RELEASE, "UNSUPPORTED", component_ref=ref)


@CHECKS("bind-exclusive", Needs.ADAPTER)
async def _bind_exclusive(stage: Stage) -> None:
    """An actuation has one holder: others are answered OUT_OF_RESOURCES until it releases."""
    app, other = await stage.application(), await stage.application()
    arm = stage.ref("arm")
    await app.granted(BIND, component_ref=arm)
    await other.refused(BIND, "OUT_OF_RESOURCES", component_ref=arm)
    await app.granted(RELEASE, component_ref=arm)
    await other.granted(BIND, component_ref=arm)


@CHECKS("bind-idempotent", Needs.ADAPTER)
async def _bind_idempotent(stage: Stage) -> None:
    """`bind` by the present holder is OK and changes nothing: one release gives the component back."""
    app, other = await stage.application(), await stage.application()
    arm = stage.ref("arm")
    for _ in range(3):
        await app.granted(BIND, component_ref=arm)
    await app.granted(RELEASE, component_ref=arm)
    await other.granted(BIND, component_ref=arm)


@CHECKS("bind-actuation-only", Needs.ADAPTER)
async def _bind_actuation_only(stage: Stage) -> None:
    """`bind` of a component that is no actuation is OK for every application and reserves nothing."""
    app, other = await stage.application(), await stage.application()
    for name in ("eye", "tool", "thing"):
        await app.granted(BIND, component_ref=stage.ref(name))
        await other.granted(BIND, component_ref=stage.ref(name))


@CHECKS("release-of-others", Needs.ADAPTER)
async def _release_of_others(stage: Stage) -> None:
    """`release` by an application that does not hold the component is OK and has no effect."""
    app, other = await stage.application(), await stage.application()
    arm = stage.ref("arm")
    await other.granted(RELEASE, component_ref=arm)
    await app.granted(BIND, component_ref=arm)
    await other.granted(RELEASE, component_ref=arm)
    await other.refused(BIND, "OUT_OF_RESOURCES", component_ref=arm)


@CHECKS("bind-ends-with-connection", Needs.ADAPTER)
async def _bind_ends_with_connection(stage: Stage) -> None:
    """A component that an application has bound is free again when its connection ends."""
    leaving, other = await stage.application(), await stage.application()
    arm = stage.ref("arm")
    await leaving.granted(BIND, component_ref=arm)
    await leaving.socket.close()
    try:
        async with asyncio.timeout(stage.patience):
            while await other.code(BIND, component_ref=arm) != "OK":
                pass
    except TimeoutError:
        raise Deviation("the component to be free when its holder is gone", "it is still bound") from None


@CHECKS("bind-any", Needs.ADAPTER)
async def _bind_any(stage: Stage) -> None:
    """`bind_any` reserves one of the components that satisfy the condition, and says which."""
    app, other = await stage.application(), await stage.application()
    engine_id = stage.probe.engine.engine_id
    condition = f"component_ref LIKE '{engine_id}/%' AND component_type = '{URN}' AND component_ref LIKE '%/___'"
    wanted = (stage.ref("arm"), stage.ref("leg"), stage.ref("eye"))
    found = await app.granted("rois.command.bind_any", condition=condition)
    expect("what bind_any bound", found["component_ref"], *wanted)
    arm = f"component_ref = '{stage.ref('arm')}'"
    await app.granted(BIND, component_ref=stage.ref("arm"))
    again = await app.granted("rois.command.bind_any", condition=arm)
    expect("what bind_any gives its holder", again["component_ref"], stage.ref("arm"))
    free = await other.granted("rois.command.bind_any", condition=condition)
    expect("what bind_any gives another", free["component_ref"], *wanted[1:])


@CHECKS("bind-any-refused", Needs.ADAPTER)
async def _bind_any_refused(stage: Stage) -> None:
    """bind_any: nothing matches UNSUPPORTED, all held OUT_OF_RESOURCES, an unreadable condition BAD_PARAMETER."""
    app, other = await stage.application(), await stage.application()
    arm = stage.ref("arm")
    await app.granted(BIND, component_ref=arm)
    for condition, code in (
        ("component_ref = 'conformance-nowhere/arm'", "UNSUPPORTED"),
        (f"component_ref = '{arm}'", "OUT_OF_RESOURCES"),
        ("arm", "BAD_PARAMETER"),
    ):
        await other.refused("rois.command.bind_any", code, condition=condition)


@CHECKS("get-parameter", Needs.ADAPTER)
async def _get_parameter(stage: Stage) -> None:
    """`get_parameter` gives the parameters that have a value, with the types of the profile, and needs no bind."""
    app = await stage.application()
    answer = await app.granted(GET, component_ref=stage.ref("arm"))
    wanted = [_value(name, default, code) for name, code, default in PARAMETERS if default]
    expect("the parameters", answer["parameters"], wanted)


@CHECKS("get-parameter-unknown")
async def _get_parameter_unknown(stage: Stage) -> None:
    """`get_parameter` and set_parameter of a component that is not there are answered UNSUPPORTED."""
    app = await stage.application()
    for ref in ABSENT:
        await app.refused(GET, "UNSUPPORTED", component_ref=ref)
        await app.refused(SET, "UNSUPPORTED", component_ref=ref, parameters=[])


async def _set(app: Application, ref: str, *parameters: dict[str, str]) -> tuple[str, str]:
    answer = await app.granted(SET, component_ref=ref, parameters=list(parameters))
    command_id = answer["command_id"]
    if any(name == "rois.command.completed" and notice["command_id"] == command_id for name, notice in app.unread):
        raise Deviation("the reply of set_parameter before its `completed`", shown(app.unread))
    return command_id, (await app.completed(command_id))[command_id]


@CHECKS("set-parameter", Needs.ADAPTER)
async def _set_parameter(stage: Stage) -> None:
    """`set_parameter` is answered with an id of the engine, then `completed` tells how it ended; it is stored."""
    app = await stage.application()
    eye = stage.ref("eye")
    command_id, status = await _set(app, eye, _value("label", "red"), _value("count", "7"))
    expect("how set_parameter completed", status, "OK")
    owner = eye.partition("/")[0]
    expect(f"the engine id that leads the command_id {command_id}", command_id.partition("/")[0], owner)
    stored = {each["name"]: each["value"] for each in (await app.granted(GET, component_ref=eye))["parameters"]}
    expect("the stored values", (stored["label"], stored["count"]), ("red", "7"))
    asked = stage.probe.params_of(SET)
    expect("how many changes reached the adapter", len(asked), 1)
    expect("the component they are for", asked[0]["component_ref"], eye)


@CHECKS("set-parameter-result", Needs.ADAPTER)
async def _set_parameter_result(stage: Stage) -> None:
    """`get_command_result` of a set_parameter is OK."""
    app = await stage.application()
    command_id, _ = await _set(app, stage.ref("eye"), _value("label", "blue"))
    await app.granted("rois.command.get_command_result", command_id=command_id)


@CHECKS("set-parameter-types", Needs.ADAPTER)
async def _set_parameter_types(stage: Stage) -> None:
    """A value of every type is taken as text and given back as it was, with the type of the profile."""
    app = await stage.application()
    eye = stage.ref("eye")
    values = [_value(name, sample(code)) for name, code, _ in PARAMETERS]
    _, status = await _set(app, eye, *values)
    expect("how set_parameter completed", status, "OK")
    wanted = [_value(name, sample(code), code) for name, code, _ in PARAMETERS]
    expect("the parameters", (await app.granted(GET, component_ref=eye))["parameters"], wanted)


@CHECKS("set-parameter-empty", Needs.ADAPTER)
async def _set_parameter_empty(stage: Stage) -> None:
    """`set_parameter` of no parameter is OK and completes."""
    app = await stage.application()
    _, status = await _set(app, stage.ref("eye"))
    expect("how set_parameter completed", status, "OK")


@CHECKS("set-parameter-needs-bind", Needs.ADAPTER)
async def _set_parameter_needs_bind(stage: Stage) -> None:
    """`set_parameter` on an actuation is answered OUT_OF_RESOURCES unless the application has bound it."""
    app, other = await stage.application(), await stage.application()
    arm = stage.ref("arm")
    await app.refused(SET, "OUT_OF_RESOURCES", component_ref=arm, parameters=[])
    await other.granted(BIND, component_ref=arm)
    await app.refused(SET, "OUT_OF_RESOURCES", component_ref=arm, parameters=[])
    await _set(other, arm, _value("label", "held"))
    for name in ("tool", "thing"):
        await _set(app, stage.ref(name), _value("label", "open"))


MISFITS: Final[tuple[tuple[str, str], ...]] = (
    ("count", ""),
    ("count", "many"),
    ("count", "1.5"),
    ("count", "+5"),
    ("count", " 5"),
    ("ratio", "much"),
    ("ratio", "NaN"),
    ("on", "True"),
    ("on", "1"),
    ("labels", "a"),
    ("labels", '"a"'),
    ("labels", "[1]"),
    ("counts", '["1"]'),
    ("counts", "[1.5]"),
    ("counts", "[" * 5000),
    ("unknown", "x"),
)
"""Parameters of the probes that do not fit their profile: name and value."""


@CHECKS("set-parameter-misfit", Needs.ADAPTER)
async def _set_parameter_misfit(stage: Stage) -> None:
    """A parameter that is not in the profile or does not fit its type is answered BAD_PARAMETER; nothing is stored."""
    app = await stage.application()
    eye = stage.ref("eye")
    before = (await app.granted(GET, component_ref=eye))["parameters"]
    for name, value in MISFITS:
        parameters: list[dict[str, Any]] = [_value("label", "changed"), _value(name, value)]
        await app.refused(SET, "BAD_PARAMETER", component_ref=eye, parameters=parameters)
    expect("the parameters", (await app.granted(GET, component_ref=eye))["parameters"], before)


@CHECKS("set-parameter-undeclared", Needs.ADAPTER)
async def _set_parameter_undeclared(stage: Stage) -> None:
    """`set_parameter` on a component that declares no parameters is answered UNSUPPORTED."""
    app = await stage.application()
    await app.refused(SET, "UNSUPPORTED", component_ref=stage.ref("person_detecter"), parameters=[])
