"""A tree that is kept change by change is the tree that would be made anew."""

from hypothesis import given
from hypothesis import strategies as st

from openrois.contract import Directory
from openrois.engine.condition import Condition
from openrois.engine.offers import Place
from openrois.engine.tree import AUTHORITY, Tree
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier


def component(name: str, urn: str = "urn:a") -> HRIComponentProfile:
    return HRIComponentProfile(identifier=RoISIdentifier(code=urn), name=name)


def engine(engine_id: str, *refs: str, below: tuple[HRIEngineProfile, ...] = ()) -> HRIEngineProfile:
    return HRIEngineProfile(identifier=RoISIdentifier(code=engine_id), component_ids=refs, sub_profiles=below)


def offer(profile: HRIEngineProfile, urn: str = "urn:a") -> Directory:
    return Directory(profile, {ref: component(ref.partition("/")[2], urn) for ref in profile.component_refs()})


def test_a_bus_comes_changes_and_goes() -> None:
    tree = Tree[str]("gateway")
    deep = engine("robot", "robot/arm", below=(engine("hand", "hand/finger"),))
    came = tree.replace("bus", offer(deep))
    assert (came.former, came.gone_refs, came.engines_before) == (None, frozenset(), frozenset())
    assert came.engines_now == {"robot", "hand"}
    assert tree.engine_ids == {"gateway", "robot", "hand"}
    assert (tree.bus_of("hand"), tree.bus_of("gateway"), tree.sub_engine_ids) == ("bus", None, ["robot"])
    assert tree.directory.profile.sub_profiles[0].component_ids == ("robot/arm", "hand/finger")
    changed = tree.replace("bus", offer(engine("robot", "robot/arm"), "urn:b"))
    assert (changed.gone_refs, changed.engines_before - changed.engines_now) == ({"hand/finger"}, {"hand"})
    assert changed.engine_ids == {"robot", "hand"}
    assert tree.components == {"robot/arm": component("arm", "urn:b")}
    assert tree.search(Condition()) == ["robot/arm"]
    gone = tree.replace("bus", None)
    assert (gone.latter, gone.gone_refs, gone.engines_now) == (None, {"robot/arm"}, frozenset())
    assert (tree.engine_ids, dict(tree.components), tree.offer_of("bus")) == ({"gateway"}, {}, None)
    assert tree.directory == Directory(engine("gateway").model_copy(update={"identifier": root_of(tree)}), {})


def root_of(tree: Tree[str]) -> RoISIdentifier:
    return tree.directory.profile.identifier


def test_engines_are_given_in_the_order_of_their_ids_whenever_they_came() -> None:
    tree = Tree[str]("gateway")
    tree.replace("m", offer(engine("m", below=(engine("deep", "deep/x"),))))
    assert list(tree.engines_after("")) == ["deep", "gateway", "m"]
    tree.replace("own", offer(engine("gateway", "gateway/clock")))
    tree.replace("a", offer(engine("a", "a/x")))
    tree.replace("m", offer(engine("m", "m/x")))
    assert list(tree.engines_after("")) == ["a", "gateway", "m"]
    assert list(tree.engines_after("b")) == ["gateway", "m"]
    tree.replace("own", None)
    tree.replace("a", None)
    assert (list(tree.engines_after("")), tree.engine_count) == (["gateway", "m"], 2)


def test_the_place_of_an_engine() -> None:
    tree = Tree[str]("gateway")
    root = RoISIdentifier(code="gateway", authority=AUTHORITY)
    assert tree.place_of("gateway") == Place("", (), root)
    tree.replace("robot", offer(engine("robot", "robot/arm", below=(engine("hand", "hand/finger"),))))
    tree.replace("own", offer(engine("gateway", "gateway/clock")))
    assert tree.place_of("gateway") == Place("", ("gateway/clock",), root)
    assert tree.place_of("robot") == Place("gateway", ("robot/arm",), RoISIdentifier(code="robot"))
    assert tree.place_of("hand") == Place("robot", ("hand/finger",), RoISIdentifier(code="hand"))
    assert tree.place_of("absent") is None


def test_what_an_engine_does_not_list_is_not_there() -> None:
    tree = Tree[str]("gateway")
    tree.replace("bus", Directory(engine("robot", "robot/arm"), {"robot/arm": component("arm"), "x/y": component("y")}))
    assert list(tree.components) == ["robot/arm"]


def test_own_components_stand_first_and_belong_to_no_sub_engine() -> None:
    tree = Tree[str]("gateway")
    tree.replace("robot", offer(engine("robot", "robot/arm")))
    tree.replace("own", offer(engine("gateway", "gateway/clock")))
    assert tree.directory.profile.component_ids == ("gateway/clock", "robot/arm")
    assert tree.sub_engine_ids == ["robot"]
    assert tree.has_engine("gateway")
    assert list(tree.refs_of("gateway")) == ["gateway/clock"]


def test_a_tree_is_restricted_to_some_components() -> None:
    tree = Tree[str]("gateway")
    for engine_id in ("c", "a", "b"):
        tree.replace(engine_id, offer(engine(engine_id, f"{engine_id}/x", f"{engine_id}/y")))
    shown = tree.restricted(["b/y", "c/x"])
    assert [(each.identifier.code, each.component_ids) for each in shown.sub_profiles] == [
        ("c", ("c/x",)),
        ("b", ("b/y",)),
    ]
    assert shown.component_ids == ("c/x", "b/y")
    assert tree.restricted([]).sub_profiles == ()
    assert tree.restricted(["absent/x"]).component_ids == ()
    assert [each.identifier.code for each in tree.restricted(["a/x"]).sub_profiles] == ["a"]


def test_the_directory_is_made_once_for_each_change() -> None:
    tree = Tree[str]("gateway")
    tree.replace("a", offer(engine("a", "a/x")))
    whole = tree.directory
    assert tree.directory is whole
    tree.replace("b", offer(engine("b", "b/x")))
    assert tree.directory is not whole
    assert list(whole.component_profiles) == ["a/x"]


offers = st.builds(
    lambda names, urn: (tuple(names), urn),
    st.lists(st.sampled_from(["arm", "eye", "leg"]), max_size=3, unique=True),
    st.sampled_from(["urn:a", "urn:b"]),
)


@given(st.lists(st.tuples(st.sampled_from("abc"), st.none() | offers), max_size=20))
def test_changes_one_by_one_make_the_tree_that_is_made_at_once(
    steps: list[tuple[str, tuple[tuple[str, ...], str] | None]],
) -> None:
    tree, present = Tree[str]("gateway"), dict[str, Directory]()
    for bus, given_offer in steps:
        if given_offer is None:
            tree.replace(bus, None)
            present.pop(bus, None)
            continue
        names, urn = given_offer
        present[bus] = offer(engine(bus, *(f"{bus}/{name}" for name in names)), urn)
        tree.replace(bus, present[bus])
    anew = Tree[str]("gateway")
    for bus, each in present.items():
        anew.replace(bus, each)
    assert tree.directory == anew.directory
    assert dict(tree.components) == dict(anew.components)
    assert sorted(tree.search(Condition())) == sorted(anew.search(Condition()))
    assert tree.engine_ids == anew.engine_ids
