"""The engines of all gateways as one tree."""

from hypothesis import given
from hypothesis import strategies as st

from openrois.contract import Directory
from openrois.engine.tree import TreeChange
from openrois.federation.cluster_directory import ClusterDirectory, Offer
from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
from tests.support.components import Lamp


def offer(engine_id: str, *below: str, streams: bool = False) -> Offer:
    ids = (engine_id, *below)
    refs = tuple(f"{each}/lamp" for each in ids)
    subs = tuple(
        HRIEngineProfile(identifier=RoISIdentifier(code=each, authority="t"), component_ids=(f"{each}/lamp",))
        for each in below
    )
    profile = HRIEngineProfile(
        identifier=RoISIdentifier(code=engine_id, authority="t"), component_ids=refs, sub_profiles=subs
    )
    directory = Directory(profile, {ref: Lamp().profile for ref in refs})
    return Offer(directory, frozenset(ids) if streams else frozenset())


class Watched:
    """A directory, the owners that are known, and what has changed."""

    def __init__(self) -> None:
        self.owners: dict[str, str] = {}
        self.directory = ClusterDirectory("gateway", self.owners.get)
        self.changes: list[TreeChange] = []
        self.directory.changes.add(self.changes.append)


def test_offers_come_change_and_go() -> None:
    here = Watched()
    here.directory.put("a", {"robot": offer("robot", streams=True)})
    assert here.directory.gateway_of("robot") == "a"
    assert here.directory.has_streams("robot")
    assert here.directory.streaming == {"robot"}
    here.directory.put("a", {"robot": offer("robot", "arm")})
    assert here.directory.gateway_of("arm") == "a"
    assert not here.directory.has_streams("robot")
    here.directory.put("a", {"robot": None})
    assert here.directory.gateway_of("robot") is None
    assert not here.directory.has_streams("robot")
    assert len(here.changes) == 3


def test_the_owners_offer_stands_while_two_gateways_have_one() -> None:
    here = Watched()
    here.directory.put("a", {"robot": offer("robot")})
    here.directory.put("b", {"robot": offer("robot")})
    assert here.directory.gateway_of("robot") == "b", "the latest"
    here.owners["robot"] = "a"
    here.directory.settle("robot")
    assert here.directory.gateway_of("robot") == "a"
    here.directory.settle("robot")
    before = len(here.changes)
    here.directory.settle("robot")
    assert len(here.changes) == before, "nothing has changed"
    here.directory.remove_gateway("a", lost=True)
    assert here.directory.gateway_of("robot") == "b"
    assert len(here.directory.lost) == 0, "it is there"


def test_what_a_lost_gateway_offered_counts_as_failing_until_it_is_offered_again() -> None:
    here = Watched()
    here.directory.put("a", {"robot": offer("robot")})
    here.directory.put("b", {"arm": offer("arm")})
    here.directory.remove_gateway("a", lost=True)
    here.directory.remove_gateway("b", lost=False)
    assert "robot/lamp" in here.directory.lost
    assert "arm/lamp" not in here.directory.lost
    here.directory.put("c", {"robot": offer("robot")})
    assert "robot/lamp" not in here.directory.lost


def test_an_id_that_another_engine_has_waits_until_it_is_free() -> None:
    here = Watched()
    here.directory.put("a", {"robot": offer("robot", "arm")})
    here.directory.put("b", {"arm": offer("arm")})
    here.directory.put("b", {"gateway": offer("gateway")})
    assert here.directory.gateway_of("arm") == "a"
    here.directory.put("a", {"robot": None})
    assert here.directory.gateway_of("arm") == "b"
    assert here.directory.gateway_of("gateway") is None, "the main engine's own id"


STEPS = st.lists(
    st.tuples(st.sampled_from("abc"), st.sampled_from(["robot", "arm", "hand"]), st.booleans(), st.sampled_from("abc-"))
)


@given(STEPS)
def test_whatever_comes_an_engine_is_there_exactly_if_a_gateway_offers_it(
    steps: list[tuple[str, str, bool, str]],
) -> None:
    here = Watched()
    offered: dict[str, set[str]] = {}
    for gateway_id, engine_id, is_there, owner in steps:
        here.owners[engine_id] = owner
        here.directory.put(gateway_id, {engine_id: offer(engine_id) if is_there else None})
        at = offered.setdefault(engine_id, set())
        (at.add if is_there else at.discard)(gateway_id)
        for each, gateways in offered.items():
            found = here.directory.gateway_of(each)
            assert (found in gateways) if gateways else found is None
            if here.owners[each] in gateways and each == engine_id:
                assert found == here.owners[each]
