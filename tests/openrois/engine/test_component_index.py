"""A search by the index finds what a look at every component finds."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.engine.component_index import ComponentIndex
from openrois.engine.condition import Comparison, Condition, parse_condition
from openrois.types.profiles import HRIComponentProfile, RoISIdentifier

PROPERTIES = frozenset({"component_ref", "component_type"})
TYPES = ("urn:a", "urn:ab", "urn:b")


def profile(name: str, urn: str) -> HRIComponentProfile:
    return HRIComponentProfile(identifier=RoISIdentifier(code=urn), name=name)


def index_of(components: dict[str, str]) -> ComponentIndex:
    index = ComponentIndex()
    for ref, urn in components.items():
        index.add(ref, profile(ref.partition("/")[2], urn))
    return index


BODIES = {f"{body}/{name}": urn for body in ("a1", "a2", "b1") for name, urn in (("arm", "urn:a"), ("eye", "urn:b"))}


@pytest.mark.parametrize(
    ("condition", "found"),
    [
        ("", list(BODIES)),
        ("component_ref = 'a2/eye'", ["a2/eye"]),
        ("component_ref = 'a2/leg'", []),
        ("component_ref = 'a2/eye' AND component_type = 'urn:a'", []),
        ("component_type = 'urn:b'", ["a1/eye", "a2/eye", "b1/eye"]),
        ("component_type = 'urn:c'", []),
        ("component_type LIKE 'urn:%'", list(BODIES)),
        ("component_ref LIKE 'a1/%'", ["a1/arm", "a1/eye"]),
        ("component_ref LIKE 'c/%'", []),
        ("component_ref LIKE 'a%'", ["a1/arm", "a1/eye", "a2/arm", "a2/eye"]),
        ("component_ref LIKE '%1/e%'", ["a1/eye", "b1/eye"]),
        ("component_ref LIKE '%ye'", ["a1/eye", "a2/eye", "b1/eye"]),
        ("component_ref LIKE '%a%' AND component_type = 'urn:b'", ["a1/eye", "a2/eye"]),
        ("component_ref LIKE '_1/eye' AND component_ref LIKE 'b%'", ["b1/eye"]),
        ("component_ref LIKE '%'", list(BODIES)),
        ("component_ref LIKE ''", []),
    ],
)
def test_what_is_found_and_in_which_order(condition: str, found: list[str]) -> None:
    assert index_of(BODIES).search(parse_condition(condition, PROPERTIES)) == found


def test_what_is_gone_is_found_no_more_and_what_comes_again_comes_last() -> None:
    index = index_of(BODIES)
    for name, urn in (("arm", "urn:a"), ("eye", "urn:b")):
        index.remove(f"a1/{name}", profile(name, urn))
    assert (list(index.refs_of("a1")), list(index.refs_of("a2"))) == ([], ["a2/arm", "a2/eye"])
    index.add("a1/arm", profile("arm", "urn:a"))
    assert index.search(parse_condition("component_type = 'urn:a'", PROPERTIES)) == ["a2/arm", "b1/arm", "a1/arm"]


names = st.text("ab_", min_size=1, max_size=3)
refs = st.builds("{}/{}".format, names, names)
patterns = st.text("ab%_/\\", max_size=5)
comparisons = st.one_of(
    st.builds(Comparison, st.just("component_ref"), st.just(True), patterns),
    st.builds(Comparison, st.just("component_ref"), st.just(False), refs),
    st.builds(Comparison, st.just("component_type"), st.just(True), st.sampled_from(["urn:%", "%a%", "%b", "_"])),
    st.builds(Comparison, st.just("component_type"), st.just(False), st.sampled_from(TYPES)),
)


@given(st.dictionaries(refs, st.sampled_from(TYPES), max_size=30), st.lists(comparisons, max_size=3))
def test_nothing_is_missed_and_nothing_else_found(components: dict[str, str], asked: list[Comparison]) -> None:
    condition = Condition(tuple(asked))
    wanted = [
        ref for ref, urn in components.items() if condition.matches({"component_ref": ref, "component_type": urn})
    ]
    assert index_of(components).search(condition) == wanted
