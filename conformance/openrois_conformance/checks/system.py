"""The System interface: connect, disconnect, get_profile, errors."""

from typing import Final

from openrois.types.profiles import HRIEngineProfile
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.probe import new_engine_id
from openrois_conformance.probe_engine import Answer, ProbeEngine
from openrois_conformance.probe_profiles import URN, component_profiles, profile_result
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

CHANGED: Final = "rois.system.profile_changed"
REFUSED_CONDITIONS: Final = ("component_ref", "colour = 'red'", "component_ref = 'x' OR component_ref = 'y'", "x" * 64)


@CHECKS("connect")
async def _connect(stage: Stage) -> None:
    """`connect` is answered OK, and again OK."""
    app = await stage.application()
    for _ in range(2):
        await app.granted("rois.system.connect")


@CHECKS("connect-not-enforced")
async def _connect_not_enforced(stage: Stage) -> None:
    """Requests before connect are answered, or refused in RoIS terms."""
    app = await stage.application()
    if await app.code("rois.command.search") != "OK":
        stage.remark("nothing is served before connect; the reference engine serves everything")


@CHECKS("disconnect")
async def _disconnect(stage: Stage) -> None:
    """`disconnect` is answered OK and leaves the socket open: connect works again."""
    app = await stage.application()
    for method in ("connect", "disconnect", "disconnect", "connect"):
        await app.granted(f"rois.system.{method}")


@CHECKS("disconnect-gives-back", Needs.ADAPTER)
async def _disconnect_gives_back(stage: Stage) -> None:
    """`disconnect` gives back what the application has bound and subscribed."""
    app, other = await stage.application(), await stage.application()
    arm, eye = stage.ref("arm"), stage.ref("eye")
    await app.granted("rois.command.bind", component_ref=arm)
    await app.granted("rois.event.subscribe", event_type="happened_to_eye")
    await app.granted("rois.system.disconnect")
    await other.granted("rois.command.bind", component_ref=arm)
    await stage.probe.happen(eye, "happened_to_eye")
    await stage.settle(app)


@CHECKS("profile")
async def _profile(stage: Stage) -> None:
    """`get_profile` gives the tree of engines and the profile of every component in it, and of no other."""
    app = await stage.application()
    result = await app.granted("rois.system.get_profile")
    refs = (await app.tree()).component_refs()
    expect("the components that have a profile", sorted(result["component_profiles"]), sorted(refs))
    found = (await app.granted("rois.command.search"))["component_ref_list"]
    expect("the components that search finds", sorted(found), sorted(refs))


@CHECKS("profile-ids")
async def _profile_ids(stage: Stage) -> None:
    """Engine ids are unique and have no slash, and each leads the components of its engine."""
    app = await stage.application()
    tree = await app.tree()
    ids = tree.engine_ids()
    expect("every engine id once", sorted(ids), sorted(set(ids)))
    if wrong := [engine_id for engine_id in ids if not engine_id or "/" in engine_id]:
        raise Deviation("engine ids that are not empty and have no slash", shown(wrong))

    def walk(profile: HRIEngineProfile) -> None:
        below = profile.engine_ids()
        for ref in profile.component_ids:
            if ref.partition("/")[0] not in below:
                raise Deviation(f"the components of {profile.identifier.code} to begin with its id, or one below", ref)
        for sub in profile.sub_profiles:
            walk(sub)

    walk(tree)


@CHECKS("profile-names")
async def _profile_names(stage: Stage) -> None:
    """The name in a component's profile is the instance's name: what follows the engine id in its reference."""
    app = await stage.application()
    for ref, profile in (await app.granted("rois.system.get_profile"))["component_profiles"].items():
        expect(f"the name of {ref}", profile["name"], ref.partition("/")[2])


@CHECKS("profile-unchanged", Needs.ADAPTER)
async def _profile_unchanged(stage: Stage) -> None:
    """The profile that an adapter gives of a component reaches applications unchanged, at any depth of the tree."""
    app = await stage.application()
    result = await app.granted("rois.system.get_profile")
    for ref, profile in stage.probe.engine.profiles.items():
        expect(f"the profile of {ref}", result["component_profiles"].get(ref), profile.model_dump(mode="json"))
    engine_id = stage.probe.engine.engine_id
    tree = await app.tree()
    below = [sub.engine_ids() for sub in tree.sub_profiles if sub.identifier.code == engine_id]
    expect("the engines of the adapter", below, [(engine_id, f"{engine_id}-below")])


@CHECKS("profile-levels", Needs.ADAPTER)
async def _profile_levels(stage: Stage) -> None:
    """At every level `component_ids` lists all that is reachable there; an adapter that does so is attached."""
    app = await stage.application()
    engine_id = new_engine_id()
    engine = ProbeEngine(engine_id, component_profiles(engine_id))
    own = profile_result(engine_id, engine.profiles)
    own["profile"]["component_ids"] = list(engine.profiles)
    engine.answers["rois.system.get_profile"] = Answer(own)
    adapter = await stage.adapter(engine)
    await stage.until_there(adapter.ref("deep"))
    tree = await app.tree()

    def walk(profile: HRIEngineProfile) -> None:
        if missing := set(profile.component_refs()) - set(profile.component_ids):
            raise Deviation(f"all that is reachable through {profile.identifier.code}", f"without {sorted(missing)[0]}")
        for below in profile.sub_profiles:
            walk(below)

    walk(tree)
    found = await app.granted("rois.command.search", condition=f"component_ref = '{adapter.ref('deep')}'")
    expect("a component that stands at two levels", found["component_ref_list"], [adapter.ref("deep")])


@CHECKS("profile-condition", Needs.ADAPTER)
async def _profile_condition(stage: Stage) -> None:
    """A condition chooses components; engines without one of these are left out."""
    app = await stage.application()
    everything = await app.tree()
    arm = stage.ref("arm")
    chosen = await app.granted("rois.system.get_profile", condition=f"component_ref = '{arm}'")
    expect("the components chosen by reference", list(chosen["component_profiles"]), [arm])
    tree = HRIEngineProfile.model_validate(chosen["profile"])
    expect("the components listed", tree.component_refs(), (arm,))
    top, engine_id = everything.identifier.code, stage.probe.engine.engine_id
    expect("the engines, without those that have no match", tree.engine_ids(), (top, engine_id))
    nothing = await app.granted("rois.system.get_profile", condition=f"component_ref = '{engine_id}/absent'")
    expect("the components that an absent reference chooses", list(nothing["component_profiles"]), [])
    bare = HRIEngineProfile.model_validate(nothing["profile"])
    expect("the engines without a match, and what they list", (bare.engine_ids(), bare.component_ids), ((top,), ()))
    by_type = await app.granted("rois.system.get_profile", condition=f"component_type = '{URN}'")
    mine = sorted(ref for ref in by_type["component_profiles"] if ref.startswith(stage.probe.engine.engine_id))
    wanted = sorted(ref for ref, profile in stage.probe.engine.profiles.items() if profile.component_type == URN)
    expect("the components chosen by type", mine, wanted)


@CHECKS("profile-condition-refused")
async def _profile_condition_refused(stage: Stage) -> None:
    """A condition that cannot be read, or names an unknown property, is answered BAD_PARAMETER."""
    app = await stage.application()
    for condition in REFUSED_CONDITIONS:
        await app.refused("rois.system.get_profile", "BAD_PARAMETER", condition=condition)


@CHECKS("profile-changed", Needs.ADAPTER)
async def _profile_changed(stage: Stage) -> None:
    """Every application is notified of profile_changed when an adapter comes and when it goes."""
    app, other = await stage.application(), await stage.application()
    for each in (app, other):
        await each.granted("rois.system.connect")
    second = await stage.adapter()
    for each in (app, other):
        expect("the params of profile_changed", await each.next(CHANGED), {})
    await stage.until_there(second.ref("arm"))
    for each in (app, other):
        each.unread.clear()
    await second.socket.close()
    for each in (app, other):
        await each.next(CHANGED)
    await stage.until_there(second.ref("arm"), there=False)


NOTIFY: Final = "rois.system.notify_error"
DETAIL: Final = "rois.system.get_error_detail"


@CHECKS("error-component", Needs.ADAPTER)
async def _error_component(stage: Stage) -> None:
    """A component's error is notified to applications that have bound it or subscribed to its events, and no other."""
    binder, subscriber, other = [await stage.application() for _ in range(3)]
    arm = stage.ref("arm")
    for app in (binder, subscriber, other):
        await app.granted("rois.system.connect")
    await binder.granted("rois.command.bind", component_ref=arm)
    await subscriber.granted("rois.event.subscribe", event_type="happened_to_arm")
    method, fault = stage.probe.engine.fault(arm, "COMPONENT_INTERNAL_ERROR")
    await stage.probe.send_notification(method, **fault)
    for app in (binder, subscriber):
        notice = await app.next(NOTIFY)
        expect("the error_type", notice["error_type"], "COMPONENT_INTERNAL_ERROR")
        await app.granted(DETAIL, error_id=notice["error_id"])
        await app.refused(DETAIL, "BAD_PARAMETER", error_id=notice["error_id"], condition="component_ref = 'x'")
    await stage.settle(other)
    await binder.granted("rois.command.release", component_ref=arm)
    await stage.probe.send_notification(method, **stage.probe.engine.fault(arm, "COMPONENT_INTERNAL_ERROR")[1])
    await subscriber.next(NOTIFY)
    await stage.settle(binder)


@CHECKS("error-engine", Needs.ADAPTER)
async def _error_engine(stage: Stage) -> None:
    """An engine's own error is notified to every application between connect and disconnect."""
    app, left = await stage.application(), await stage.application()
    for each in (app, left):
        await each.granted("rois.system.connect")
    await left.granted("rois.system.disconnect")
    method, fault = stage.probe.engine.fault("", "ENGINE_INTERNAL_ERROR")
    await stage.probe.send_notification(method, **fault)
    expect("the error_type", (await app.next(NOTIFY))["error_type"], "ENGINE_INTERNAL_ERROR")
    await stage.settle(left)


@CHECKS("error-detail-unknown")
async def _error_detail_unknown(stage: Stage) -> None:
    """`get_error_detail` of an id that was never notified is answered BAD_PARAMETER."""
    app = await stage.application()
    for error_id in ("unknown", "", "conformance-nowhere/err-1"):
        await app.refused(DETAIL, "BAD_PARAMETER", error_id=error_id)
