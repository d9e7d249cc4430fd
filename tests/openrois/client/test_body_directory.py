"""Which bodies there are in a profile."""

import pytest

from openrois.client import BodyComponent, BodyInfo
from openrois.client.body_directory import bodies_in, urn_of
from openrois.client.components import Move, Navigation
from openrois.types.messages import ProfileResult
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier

pytestmark = pytest.mark.extra(name="base")


def engine(code: str, *own: str, below: tuple[HRIEngineProfile, ...] = ()) -> HRIEngineProfile:
    """Return an engine that lists, as the wire says, all that is reachable through it."""
    return HRIEngineProfile(identifier=RoISIdentifier(code=code), sub_profiles=below, component_ids=own).completed()


def answer(main: HRIEngineProfile) -> ProfileResult:
    profiles = {
        ref: HRIComponentProfile(identifier=RoISIdentifier(code=ref.split("/")[1], authority="OMG"), name=ref)
        for ref in main.component_refs()
    }
    return ProfileResult(profile=main, component_profiles=profiles)


def bodies(main: HRIEngineProfile) -> dict[str, list[str]]:
    return {body.engine_id: list(body.types) for body in bodies_in(answer(main))}


def test_each_engine_behind_the_main_one_is_a_body() -> None:
    main = engine("gateway", below=(engine("robot", "robot/navigation", "robot/move"), engine("avatar", "avatar/move")))
    assert bodies(main) == {"robot": ["robot/move", "robot/navigation"], "avatar": ["avatar/move"]}


def test_a_main_engine_alone_is_a_body() -> None:
    assert bodies(engine("robot", "robot/navigation")) == {"robot": ["robot/navigation"]}


def test_of_bodies_behind_it_the_main_engine_is_none() -> None:
    main = engine("gateway", "gateway/reaction", below=(engine("robot", "robot/move"),))
    assert bodies(main) == {"robot": ["robot/move"], "gateway": ["gateway/reaction"]}


def test_an_engine_that_owns_nothing_is_no_body() -> None:
    site = engine("site", below=(engine("robot", "robot/navigation"), engine("avatar", "avatar/move")))
    assert list(bodies(engine("gateway", below=(site,)))) == ["avatar", "robot"]
    assert bodies(engine("gateway")) == {}
    assert bodies_in(ProfileResult()) == ()


def test_the_inner_engine_comes_first_and_belongs_to_the_outer_one() -> None:
    robot = engine("robot", "robot/navigation", below=(engine("arm", "arm/move"),))
    assert bodies(engine("gateway", below=(robot,))) == {
        "arm": ["arm/move"],
        "robot": ["arm/move", "robot/navigation"],
    }


def test_components_that_a_condition_left_out_belong_to_no_body() -> None:
    whole = answer(engine("gateway", below=(engine("robot", "robot/navigation", "robot/move"),)))
    asked = ProfileResult(
        profile=whole.profile, component_profiles={"robot/move": whole.component_profiles["robot/move"]}
    )
    assert [list(body.types) for body in bodies_in(asked)] == [["robot/move"]]


@pytest.mark.parametrize(
    ("parts", "free"),
    [((True, True), True), ((True, False), False), ((None, False), False), ((True, None), None)],
)
def test_a_body_is_free_when_every_part_is(parts: tuple[bool | None, ...], free: bool | None) -> None:
    components = tuple(BodyComponent(f"robot/{part}", urn_of(Move), part) for part in parts)
    assert BodyInfo("robot", components).free is free


def test_what_a_body_can_do_is_asked_by_type() -> None:
    info = BodyInfo("robot", (BodyComponent("robot/move", urn_of(Move), True),))
    assert info.refs(Move) == info.refs("Move") == info.refs(urn_of(Move)) == ("robot/move",)
    assert info.refs(Navigation) == ()
    with pytest.raises(TypeError, match="has no component_type"):
        info.refs(int)  # type: ignore[arg-type]
