"""What profiles tell about messages, engines and references."""

import pytest
from pydantic import ValidationError

from openrois.types.codes import ComponentFunction
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    HRIEngineProfile,
    ParameterProfile,
    QueryMessageProfile,
    RoISIdentifier,
    component_urn,
    type_identifier,
)

LEVEL = ParameterProfile(name="level", data_type_ref=RoISIdentifier(code="int"))
LAMP = HRIComponentProfile(
    identifier=RoISIdentifier(code=component_urn("Lamp", "Test")),
    name="lamp",
    function=ComponentFunction.ACTUATION,
    command_profiles=(CommandMessageProfile(name="start"), CommandMessageProfile(name="switch", timeout=5)),
    query_profiles=(QueryMessageProfile(name="brightness", results=(LEVEL,)),),
    event_profiles=(EventMessageProfile(name="switched"),),
    parameter_profiles=(LEVEL,),
)
TREE = HRIEngineProfile(
    identifier=RoISIdentifier(code="gateway"),
    component_ids=("gateway/own",),
    sub_profiles=(
        HRIEngineProfile(
            identifier=RoISIdentifier(code="fleet"),
            sub_profiles=(HRIEngineProfile(identifier=RoISIdentifier(code="a"), component_ids=("a/lamp",)),),
        ),
        HRIEngineProfile(identifier=RoISIdentifier(code="b"), component_ids=("b/lamp", "b/bell")),
    ),
)


def test_messages_are_found_by_name() -> None:
    assert LAMP.command("switch") == CommandMessageProfile(name="switch", timeout=5)
    assert LAMP.command("explode") is None
    assert LAMP.parameter("level") is LEVEL
    assert LAMP.parameter("colour") is None
    assert (LAMP.has_query("brightness"), LAMP.has_query("level")) == (True, False)
    assert (LAMP.has_event("switched"), LAMP.has_event("rang")) == (True, False)


def test_a_tree_lists_its_engines_and_components() -> None:
    assert TREE.engine_ids() == ("gateway", "fleet", "a", "b")
    assert TREE.component_refs() == ("gateway/own", "a/lamp", "b/lamp", "b/bell")


def test_a_profile_survives_the_wire() -> None:
    for profile in (LAMP, TREE):
        assert type(profile).model_validate(profile.model_dump(mode="json")) == profile


def test_queries_and_events_have_no_arguments() -> None:
    for model in (QueryMessageProfile, EventMessageProfile):
        with pytest.raises(ValidationError):
            model.model_validate({"name": "x", "arguments": []})


def test_the_function_of_a_component_is_one_of_three_or_unknown() -> None:
    written = LAMP.model_dump(mode="json")
    assert HRIComponentProfile.model_validate({**written, "function": None}).function is None
    with pytest.raises(ValidationError):
        HRIComponentProfile.model_validate({**written, "function": "toy"})


def test_the_type_of_a_standard_component() -> None:
    assert component_urn("Navigation") == "urn:x-rois:def:component:OMG::Navigation"


@pytest.mark.parametrize(
    ("identifier", "component_type"),
    [
        (RoISIdentifier(code="Navigation", authority="OMG"), component_urn("Navigation")),
        (RoISIdentifier(code=component_urn("Navigation"), authority="OMG"), component_urn("Navigation")),
        (RoISIdentifier(code="urn:x:lamp", authority="Example"), "urn:x:lamp"),
        (RoISIdentifier(code="Lamp"), "urn:x-rois:def:component:::Lamp"),
    ],
)
def test_a_type_is_the_urn_of_authority_and_code(identifier: RoISIdentifier, component_type: str) -> None:
    assert HRIComponentProfile(identifier=identifier, name="x").component_type == component_type


def test_a_urn_is_taken_apart_where_it_names_an_authority() -> None:
    assert type_identifier(component_urn("Lamp", "Example")) == RoISIdentifier(code="Lamp", authority="Example")
    for other in ("urn:x-rois:def:component:::Lamp", "urn:x-rois:def:Component:OMG::RoISCommon", "Lamp", ""):
        assert type_identifier(other) == RoISIdentifier(code=other)


def engine(code: str, *refs: str, below: tuple[HRIEngineProfile, ...] = ()) -> HRIEngineProfile:
    return HRIEngineProfile(identifier=RoISIdentifier(code=code), component_ids=refs, sub_profiles=below)


def test_what_stands_at_several_levels_of_one_path_is_one_component() -> None:
    deep = engine("deep", "deep/a")
    listing = engine("top", "top/b", "deep/a", below=(engine("middle", "deep/a", below=(deep,)),))
    assert listing.component_refs() == ("top/b", "deep/a")
    assert listing.own_refs() == ("top/b",)
    assert listing.repeated_refs() == ()
    bare = engine("top", "top/b", below=(engine("middle", below=(deep,)),))
    assert bare.completed() == listing == listing.completed()


def test_what_stands_twice_otherwise_is_repeated() -> None:
    assert engine("a", "a/x", "a/x").repeated_refs() == ("a/x",)
    beside = engine("top", below=(engine("a", "a/x"), engine("b", "a/x")))
    assert beside.repeated_refs() == ("a/x",)
    assert engine("upper", below=(beside,)).repeated_refs() == ("a/x",)
