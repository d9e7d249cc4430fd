"""Entries of engines, and the versions in them."""

import gc

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.contract import Directory
from openrois.engine.entries import engine_entry
from openrois.engine.profile_versions import profile_version
from openrois.engine.tree import Tree
from openrois.types.directory import EngineEntry
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier


def entry_of(*profiles: HRIComponentProfile, has_streams: bool = False) -> EngineEntry:
    components = {f"robot/{profile.name}": profile for profile in profiles}
    tree = Tree[str]("gateway")
    robot = HRIEngineProfile(identifier=RoISIdentifier(code="robot"), component_ids=tuple(components))
    tree.replace("bus", Directory(robot, components))
    entry = engine_entry(tree, "robot", lambda _engine_id: has_streams)
    assert entry is not None
    return entry


FIRST, SECOND = (kind.profile() for kind in BASIC_COMPONENTS[:2])


def test_an_entry_has_another_version_when_anything_of_it_is_another() -> None:
    plain = entry_of(FIRST)
    assert entry_of(FIRST) == plain
    others = [entry_of(FIRST, SECOND), entry_of(FIRST, has_streams=True), entry_of(SECOND), entry_of()]
    assert len({each.version for each in (plain, *others)}) == 5


def test_an_engine_that_is_not_there_has_no_entry() -> None:
    assert engine_entry(Tree[str]("gateway"), "robot", lambda _engine_id: False) is None


def test_equal_profiles_have_one_version_and_what_is_gone_is_forgotten() -> None:
    read_anew = HRIComponentProfile.model_validate_json(FIRST.model_dump_json())
    assert profile_version(read_anew) == profile_version(FIRST)
    assert profile_version(FIRST) is profile_version(FIRST)
    assert profile_version(SECOND).code != profile_version(FIRST).code
    assert profile_version(FIRST).size == len(FIRST.model_dump_json())
    codes = set()
    for number in range(100):
        codes.add(profile_version(FIRST.model_copy(update={"name": f"{number}"})).code)
        gc.collect(0)
    assert len(codes) == 100
