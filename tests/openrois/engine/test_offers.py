"""Offers are compared by which of their engines are the same objects; what is checked and replaced is what differs."""

from typing import cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.contract import ComponentBus, Directory
from openrois.engine.condition import Condition
from openrois.engine.engine import Engine
from openrois.engine.offers import Place, compare_offers
from openrois.engine.tree import Tree, TreeChange
from openrois.errors import BadParameter
from openrois.types.profiles import HRIEngineProfile, ParameterProfile, RoISIdentifier
from tests.support.offers import Bus, engine, offer


def together(*below: HRIEngineProfile, own: tuple[str, ...] = ()) -> HRIEngineProfile:
    """Return the profile of the engine `inner`, complete at each level."""
    refs = (*own, *(ref for profile in below for ref in profile.component_ids))
    return HRIEngineProfile(identifier=RoISIdentifier(code="inner"), sub_profiles=below, component_ids=refs)


def complete(profile: HRIEngineProfile) -> HRIEngineProfile:
    """Return a profile with all that is reachable at every level; what is below it stays the same object."""
    return compare_offers("gateway", None, profile).profile


ARM, EYE, LEG = (engine(name, "part") for name in ("arm", "eye", "leg"))


class TestCompared:
    def test_a_first_offer_is_all_new(self) -> None:
        number = ParameterProfile(name="speed", data_type_ref=RoISIdentifier(code="integer"))
        robot = engine("robot", "x", below=(ARM,)).model_copy(update={"parameter_profiles": (number,)})
        compared = compare_offers("gateway", None, robot)
        assert (compared.before, compared.twice, compared.repeated) == (frozenset(), frozenset(), frozenset())
        assert compared.now == {
            "robot": Place("gateway", ("robot/x",), RoISIdentifier(code="robot"), (number,)),
            "arm": Place("robot", ("arm/part",), RoISIdentifier(code="arm")),
        }
        assert list(compared.now) == ["robot", "arm"]
        # At every level stands all that is below.
        assert compared.profile.component_ids == ("robot/x", "arm/part")
        assert compared.profile.sub_profiles == (ARM,)

    def test_what_is_complete_stays_the_same_object(self) -> None:
        whole = together(ARM, EYE)
        assert compare_offers("gateway", None, whole).profile is whole

    def test_only_others_differ(self) -> None:
        changed = engine("eye", "part", "lid")
        compared = compare_offers("gateway", together(ARM, EYE, LEG), together(ARM, changed))
        assert compared.before == {"inner", "eye", "leg"}
        assert compared.now.keys() == {"inner", "eye"}
        assert compared.profile.sub_profiles[0] is ARM

    def test_an_equal_one_that_is_another_object_may_have_been_away(self) -> None:
        compared = compare_offers("gateway", together(ARM, EYE), together(ARM, engine("eye", "part")))
        assert (compared.before, set(compared.now)) == ({"inner", "eye"}, {"inner", "eye"})

    def test_deep_below_the_others_stay(self) -> None:
        former = together(LEG, complete(engine("body", below=(ARM, EYE))))
        body = complete(engine("body", below=(ARM, engine("eye", "part", "lid"))))
        compared = compare_offers("gateway", former, together(LEG, body))
        assert compared.before == compared.now.keys() == {"inner", "body", "eye"}

    def test_one_that_moved_is_another_one(self) -> None:
        former = together(ARM, EYE)
        moved = compare_offers("gateway", former, together(complete(engine("arm", "part", below=(EYE,)))))
        assert (moved.before, set(moved.now)) == ({"inner", "arm", "eye"}, {"inner", "arm", "eye"})

    def test_what_stands_twice(self) -> None:
        assert compare_offers("gateway", None, together(ARM, ARM)).twice == {"arm"}
        assert compare_offers("gateway", None, together(ARM, ARM)).repeated == {"arm/part"}
        listed = engine("eye", "lid", "lid", "part")
        assert compare_offers("gateway", None, together(listed)).repeated == {"eye/lid"}
        again = compare_offers("gateway", together(ARM), together(ARM, ARM))
        assert (again.twice, set(again.now)) == (frozenset(), {"inner", "arm"})


class TestAttached:
    """The engine checks what differs, and no more."""

    async def attached(self, *below: HRIEngineProfile) -> tuple[Engine, Bus]:
        made, bus = Engine("outer"), Bus(offer(together(*below)))
        await made.attach(cast(ComponentBus, bus), own=False)
        return made, bus

    @pytest.mark.parametrize(
        ("below", "why"),
        [
            ((ARM, ARM), "taken already"),
            ((ARM, complete(engine("leg", below=(ARM,)))), "taken already"),
            ((ARM, engine("outer")), "taken already"),
            ((ARM, engine("other")), "taken already"),
            ((ARM, engine("")), "no engine id"),
            ((ARM, engine("leg", "x/y")), "slash"),
            ((ARM, HRIEngineProfile(identifier=RoISIdentifier(code="leg"), component_ids=("arm/part",))), "twice"),
            ((ARM, HRIEngineProfile(identifier=RoISIdentifier(code="leg"), component_ids=("x/part",))), "begin with"),
        ],
    )
    async def test_a_change_that_cannot_be(self, below: tuple[HRIEngineProfile, ...], why: str) -> None:
        outer, bus = await self.attached(ARM, EYE)
        await outer.attach(cast(ComponentBus, Bus(offer(engine("other")))))
        before = outer.tree.directory
        bus.offered = offer(together(*below))
        with pytest.raises(BadParameter, match=why):
            await outer.refresh(cast(ComponentBus, bus))
        assert outer.tree.directory == before

    async def test_a_component_needs_the_engine_that_leads_it(self) -> None:
        """Also where the engine that lists it has not changed."""
        listing = HRIEngineProfile(identifier=RoISIdentifier(code="leg"), component_ids=("eye/lid",))
        outer, bus = await self.attached(listing, EYE)
        bus.offered = offer(together(listing))
        with pytest.raises(BadParameter, match="'eye/lid' cannot be in this tree: it does not begin"):
            await outer.refresh(cast(ComponentBus, bus))

    async def test_a_component_without_a_profile(self) -> None:
        outer, bus = await self.attached(ARM)
        bus.offered = Directory(together(ARM, EYE), {"arm/part": offer(ARM).component_profiles["arm/part"]})
        with pytest.raises(BadParameter, match="it has no profile"):
            await outer.refresh(cast(ComponentBus, bus))

    async def test_what_is_notified_is_what_differs(self) -> None:
        outer, bus = await self.attached(ARM, EYE, LEG)
        changes: list[TreeChange] = []
        outer.changes.add(changes.append)
        bus.offered = offer(together(ARM, LEG, engine("nose", "part")))
        assert await outer.refresh(cast(ComponentBus, bus)) == {"eye/part"}
        (change,) = changes
        assert change.engine_ids == {"inner", "eye", "nose"}
        assert (change.gone_refs, set(change.refs_now)) == ({"eye/part"}, {"nose/part"})


SHAPES = st.dictionaries(
    st.sampled_from("abcd"),
    st.tuples(st.sets(st.sampled_from("xyz")).map(sorted).map(tuple), st.sets(st.sampled_from("pq")).map(sorted)),
    max_size=4,
)


@given(st.lists(SHAPES, max_size=8), st.booleans())
def test_a_tree_that_keeps_what_is_the_same_is_the_tree_that_is_made_anew(
    shapes: list[dict[str, object]], is_asked: bool
) -> None:
    kept: dict[str, HRIEngineProfile] = {}

    def body(engine_id: str, shape: tuple[tuple[str, ...], list[str]]) -> HRIEngineProfile:
        names, below = shape
        key = repr((engine_id, shape))
        if key not in kept:
            deeper = tuple(engine(engine_id + name, "v") for name in below)
            kept[key] = complete(engine(engine_id, *names, below=deeper))
        return kept[key]

    tree = Tree[str]("outer")
    for shape in shapes:
        if is_asked:
            assert list(tree.engines_after("")) == sorted(tree.engine_ids)
        latter = offer(
            together(
                *(body(engine_id, cast(tuple[tuple[str, ...], list[str]], each)) for engine_id, each in shape.items())
            )
        )
        former = tree.offer_of("bus")
        change = tree.replace("bus", latter)
        anew = Tree[str]("outer")
        anew.replace("bus", latter)
        assert tree.directory == anew.directory
        assert dict(tree.components) == dict(anew.components)
        assert sorted(tree.search(Condition())) == sorted(anew.search(Condition()))
        assert {each: tree.place_of(each) for each in tree.engine_ids} == {
            each: anew.place_of(each) for each in anew.engine_ids
        }
        assert list(tree.engines_after("")) == list(anew.engines_after(""))
        refs_before = set(former.component_profiles) if former is not None else set()
        assert change.gone_refs == refs_before - set(latter.component_profiles)
