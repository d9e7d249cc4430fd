"""What a principal is shown, as a table of scopes over a small tree."""

from dataclasses import replace

import pytest

from openrois.auth.principal import LOCAL, Principal, Role
from openrois.contract import Directory, Fault
from openrois.engine.tree import Tree
from openrois.scope.filter import scoped_directory, scoped_fault
from openrois.types.codes import ErrorType
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier

ARM, EYE, DEEP = "robot/arm", "robot/eye", "below/deep"


def engine(code: str, *refs: str, below: tuple[HRIEngineProfile, ...] = ()) -> HRIEngineProfile:
    return HRIEngineProfile(identifier=RoISIdentifier(code=code), component_ids=refs, sub_profiles=below)


def component(name: str, *parts: str) -> HRIComponentProfile:
    return HRIComponentProfile(identifier=RoISIdentifier(code="urn"), name=name, sub_component_profiles=parts)


def tree() -> Directory:
    robot = engine("robot", ARM, EYE, below=(engine("below", DEEP),))
    parts = component("arm", EYE, "robot/not there", DEEP, "urn:example:part")
    components = {ARM: parts, EYE: component("eye"), DEEP: component("deep")}
    return Directory(engine("gateway", below=(robot, engine("idle"))), components)


def viewer(*scope: str) -> Principal:
    return Principal("anna", frozenset({Role.VIEWER}), scope)


def administrator(*scope: str) -> Principal:
    return Principal("anna", frozenset({Role.ADMINISTRATOR}), scope)


@pytest.mark.parametrize(
    ("principal", "refs", "engines"),
    [
        (viewer(), [], ["gateway"]),
        (viewer("robot/eye"), [EYE], ["gateway", "robot"]),
        (viewer("robot/*"), [ARM, EYE], ["gateway", "robot"]),
        (viewer("below/*"), [DEEP], ["gateway", "robot", "below"]),
        (viewer("ROBOT/*", "other/*"), [], ["gateway"]),
        (viewer("*"), [ARM, EYE, DEEP], ["gateway", "robot", "below", "idle"]),
        (administrator("robot/eye"), [EYE], ["gateway", "robot"]),
        (administrator("*"), [ARM, EYE, DEEP], ["gateway", "robot", "below", "idle"]),
        (LOCAL, [ARM, EYE, DEEP], ["gateway", "robot", "below", "idle"]),
    ],
)
def test_components_and_engines(principal: Principal, refs: list[str], engines: list[str]) -> None:
    shown = scoped_directory(tree(), principal)
    assert list(shown.component_profiles) == refs
    assert list(shown.profile.engine_ids()) == engines
    assert sorted(shown.profile.component_refs()) == sorted(refs)


def test_parts_out_of_scope_are_not_named_whether_they_exist_or_not() -> None:
    shown = scoped_directory(tree(), viewer("robot/arm", "below/*"))
    assert shown.component_profiles[ARM].sub_component_profiles == (DEEP, "urn:example:part")
    whole = tree()
    assert scoped_directory(whole, viewer("*")).component_profiles[ARM] is whole.component_profiles[ARM]


def fault(error_id: str, component_ref: str = "") -> Fault:
    return Fault(error_id, ErrorType.ENGINE_INTERNAL_ERROR, component_ref, "robot/arm burns", "now")


@pytest.mark.parametrize(
    ("principal", "told", "heard"),
    [
        (viewer("robot/eye"), fault("robot/1", EYE), "robot/arm burns"),
        (viewer("robot/eye"), fault("robot/1", ARM), None),
        (viewer("robot/eye"), fault("gateway/1", ARM), None),
        (viewer("robot/eye"), fault("robot/1"), "the engine has a fault"),
        (viewer("robot/eye"), fault("gateway/1"), "the engine has a fault"),
        (viewer("robot/eye"), fault("below/1"), None),
        (viewer("*"), fault("gateway/1"), "robot/arm burns"),
        (viewer("*"), fault("idle/1"), "robot/arm burns"),
        (LOCAL, fault("idle/1"), "robot/arm burns"),
    ],
)
def test_faults(principal: Principal, told: Fault, heard: str | None) -> None:
    whole, seen = Tree[str]("gateway"), Tree[str]("gateway")
    for below in tree().profile.sub_profiles:
        offer = Directory(below, {ref: tree().component_profiles[ref] for ref in below.component_refs()})
        whole.replace(below.identifier.code, offer)
        shown_offer = scoped_directory(offer, principal)
        if shown_offer.component_profiles or principal.sees_everything:
            seen.replace(below.identifier.code, shown_offer)
    shown = scoped_fault(told, whole, seen, principal)
    assert shown == (None if heard is None else replace(told, description=heard))
