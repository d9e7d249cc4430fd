import gc

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.remote.shared_profiles import shared_profile
from openrois.types.profiles import HRIComponentProfile


def read_anew(profile: HRIComponentProfile) -> HRIComponentProfile:
    return HRIComponentProfile.model_validate_json(profile.model_dump_json())


def test_equal_profiles_are_one() -> None:
    for kind in BASIC_COMPONENTS:
        first = shared_profile(read_anew(kind.profile()))
        assert shared_profile(read_anew(kind.profile())) is first
        other = first.model_copy(update={"name": "another"})
        assert shared_profile(other) is other


def test_a_profile_that_nothing_refers_to_is_not_kept() -> None:
    name = "a profile of this test alone"
    profile = BASIC_COMPONENTS[0].profile().model_copy(update={"name": name})
    assert shared_profile(profile) is profile
    del profile
    gc.collect()
    again = BASIC_COMPONENTS[0].profile().model_copy(update={"name": name})
    assert shared_profile(again) is again
