"""The seventeen types of the standard, offered by the suite's adapter: every message gets through unchanged."""

from typing import Final

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.component_type import ComponentType
from openrois.types.codes import ComponentFunction
from openrois.types.profiles import HRIComponentProfile, ParameterProfile
from openrois.types.values import check_value
from openrois_conformance.application import EVENT, Application
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.manifest import check_of_type
from openrois_conformance.probe_profiles import sample
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()


def _values(profiles: tuple[ParameterProfile, ...]) -> list[dict[str, str]]:
    return [
        {
            "name": profile.name,
            "data_type_ref": profile.data_type_ref.code,
            "value": sample(profile.data_type_ref.code),
        }
        for profile in profiles
    ]


async def _commands(app: Application, ref: str, profile: HRIComponentProfile) -> None:
    for number, command in enumerate(profile.command_profiles):
        command_id = f"conformance-{number}"
        unit = {"component_ref": ref, "command_type": command.name, "command_id": command_id}
        unit_with = {**unit, "arguments": _values(command.arguments)}
        await app.granted("rois.command.execute", command_unit_list=[unit_with])
        expect(f"how {command.name} completed", await app.completed(command_id), {command_id: "OK"})
        results = (await app.granted("rois.command.get_command_result", command_id=command_id))["results"]
        if command.results:
            expect(f"the results of {command.name}", results, _values(command.results))


async def _queries(app: Application, ref: str, profile: HRIComponentProfile) -> None:
    for query in profile.query_profiles:
        answer = await app.granted("rois.query.query", query_type=query.name, condition=f"component_ref = '{ref}'")
        expect(f"the results of {query.name}", answer["results"], _values(query.results))


async def _events(stage: Stage, app: Application, ref: str, profile: HRIComponentProfile) -> None:
    for event in profile.event_profiles:
        params = {"event_type": event.name, "condition": f"component_ref = '{ref}'"}
        await app.granted("rois.event.subscribe", **params)
        await stage.probe.happen(ref, event.name)
        notice = await app.next(EVENT)
        expect("the event_type", notice["event_type"], event.name)
        detail = await app.granted("rois.event.get_event_detail", event_id=notice["event_id"])
        expect(f"the results of {event.name}", detail["results"], _values(event.results))


async def _parameters(app: Application, ref: str, profile: HRIComponentProfile) -> None:
    if not profile.parameter_profiles:
        return
    values = _values(profile.parameter_profiles)
    answer = await app.granted("rois.command.set_parameter", component_ref=ref, parameters=values)
    await app.completed(answer["command_id"])
    stored = (await app.granted("rois.command.get_parameter", component_ref=ref))["parameters"]
    expect("the parameters", stored, values)


def _add(kind: ComponentType) -> None:
    async def play(stage: Stage) -> None:
        app = await stage.application()
        ref = stage.ref(kind.name)
        profile = kind.profile()
        if kind.function is ComponentFunction.ACTUATION:
            await app.granted("rois.command.bind", component_ref=ref)
        await _parameters(app, ref, profile)
        await _commands(app, ref, profile)
        await _queries(app, ref, profile)
        await _events(stage, app, ref, profile)

    play.__doc__ = f"Every command, query, event and parameter of {kind.code} gets through as it is."
    CHECKS(check_of_type(kind), Needs.ADAPTER)(play)


for _kind in BASIC_COMPONENTS:
    _add(_kind)


@CHECKS("standard-profiles")
async def _standard_profiles(stage: Stage) -> None:
    """A component that says it is of a type of the standard has messages of that type, with its results and types."""
    app = await stage.application()
    kinds = {kind.urn: kind for kind in BASIC_COMPONENTS}
    profiles = (await app.granted("rois.system.get_profile"))["component_profiles"]
    found = 0
    for ref, given in profiles.items():
        profile = HRIComponentProfile.model_validate(given)
        if (kind := kinds.get(profile.component_type)) is not None:
            found += 1
            if missing := _missing(profile, kind):
                stage.remark(f"{ref}, a {kind.code}, lacks {', '.join(missing)}")
            _compare(ref, profile, kind.profile())
    if not found:
        stage.remark("the gateway has no component of the standard")


def _compare(ref: str, profile: HRIComponentProfile, standard: HRIComponentProfile) -> None:
    for kind in ("command_profiles", "query_profiles", "event_profiles"):
        known = {message.name: message for message in getattr(standard, kind)}
        for message in getattr(profile, kind):
            if message.name in known:
                _same(f"the results of {ref} {message.name}", message.results, known[message.name].results)
    _same(f"the parameters of {ref}", profile.parameter_profiles, standard.parameter_profiles)


def _same(what: str, given: tuple[ParameterProfile, ...], standard: tuple[ParameterProfile, ...]) -> None:
    codes = {profile.name: profile.data_type_ref.code.lower() for profile in standard}
    for profile in given:
        if profile.name in codes:
            expect(f"{what}: the type of {profile.name}", profile.data_type_ref.code.lower(), codes[profile.name])


@CHECKS("component-profile", Needs.COMPONENT)
async def _component_profile(stage: Stage) -> None:
    """The given component is in the profile and can be found by its reference."""
    app = await stage.application()
    ref = stage.component
    profiles = (await app.granted("rois.system.get_profile"))["component_profiles"]
    if ref not in profiles:
        raise Deviation(f"a profile of {ref}", shown(sorted(profiles)))
    found = (await app.granted("rois.command.search", condition=f"component_ref = '{ref}'"))["component_ref_list"]
    expect("what search finds", found, [ref])


@CHECKS("component-commands", Needs.COMPONENT)
async def _component_commands(stage: Stage) -> None:
    """The given component has the commands that its type, one of the standard's, requires."""
    app = await stage.application()
    profile = await _profile_of(stage, app)
    kind = next((each for each in BASIC_COMPONENTS if each.urn == profile.component_type), None)
    if kind is not None and (missing := _missing(profile, kind)):
        said = shown(sorted(each.name for each in profile.command_profiles))
        raise Deviation(f"the commands {', '.join(missing)} of a {kind.code}", said)


def _missing(profile: HRIComponentProfile, kind: ComponentType) -> list[str]:
    return [name for name in kind.required_commands() if profile.command(name) is None]


async def _profile_of(stage: Stage, app: Application) -> HRIComponentProfile:
    given = (await app.granted("rois.system.get_profile"))["component_profiles"].get(stage.component)
    if given is None:
        raise Deviation(f"a profile of {stage.component}", "none")
    return HRIComponentProfile.model_validate(given)


def _fit(what: str, values: list[dict[str, str]], profiles: tuple[ParameterProfile, ...]) -> None:
    codes = {profile.name: profile.data_type_ref.code for profile in profiles}
    for value in values:
        if value["name"] not in codes:
            raise Deviation(f"{what} to be among {shown(sorted(codes))}", value["name"])
        try:
            check_value(codes[value["name"]], value["value"])
        except ValueError as error:
            raise Deviation(f"{what} {value['name']} to be a {codes[value['name']]}", str(error)) from None


@CHECKS("component-queries", Needs.COMPONENT)
async def _component_queries(stage: Stage) -> None:
    """Every query of the given component is answered, with results that fit its profile; component_status always."""
    app = await stage.application()
    for query in (await _profile_of(stage, app)).query_profiles:
        condition = f"component_ref = '{stage.component}'"
        answer = await app.ask("rois.query.query", query_type=query.name, condition=condition)
        if query.name == "component_status":
            expect("the return_code of component_status", answer["return_code"], "OK")
        _fit(f"a result of {query.name}", answer["results"], query.results)


@CHECKS("component-parameters", Needs.COMPONENT)
async def _component_parameters(stage: Stage) -> None:
    """`get_parameter` of the given component gives values that fit its profile."""
    app = await stage.application()
    profile = await _profile_of(stage, app)
    answer = await app.granted("rois.command.get_parameter", component_ref=stage.component)
    _fit("a parameter", answer["parameters"], profile.parameter_profiles)


@CHECKS("component-events", Needs.COMPONENT)
async def _component_events(stage: Stage) -> None:
    """Every event of the given component can be subscribed to and unsubscribed from, while it can work."""
    app = await stage.application()
    for event in (await _profile_of(stage, app)).event_profiles:
        condition = f"component_ref = '{stage.component}'"
        answer = await app.ask("rois.event.subscribe", event_type=event.name, condition=condition)
        if answer["return_code"] == "ERROR" and (status := await _status(stage, app)) not in ("READY", "BUSY"):
            stage.remark(f"the component's status is {status}: its events were not tried")
            break
        expect("the return_code of rois.event.subscribe", answer["return_code"], "OK")
        await app.granted("rois.event.unsubscribe", subscribe_id=answer["subscribe_id"])
    app.unread.clear()


async def _status(stage: Stage, app: Application) -> str:
    condition = f"component_ref = '{stage.component}'"
    answer = await app.granted("rois.query.query", query_type="component_status", condition=condition)
    return str(answer["results"][0]["value"])


@CHECKS("component-bind", Needs.COMPONENT)
async def _component_bind(stage: Stage) -> None:
    """The given component can be bound, or another application has it; an actuation has one holder at a time."""
    app, other = await stage.application(), await stage.application()
    exclusive = (await _profile_of(stage, app)).function is ComponentFunction.ACTUATION
    code = await app.code("rois.command.bind", component_ref=stage.component)
    expect("the return_code of bind", code, "OK", *(["OUT_OF_RESOURCES"] if exclusive else []))
    if code == "OK":
        wanted = "OUT_OF_RESOURCES" if exclusive else "OK"
        expect("another's", await other.code("rois.command.bind", component_ref=stage.component), wanted)
        await app.granted("rois.command.release", component_ref=stage.component)
    else:
        stage.remark("another application has it bound")
