"""The avatar's own profiles as XML: basic components that list less than the standard's, and one of our own."""

from openrois_avatar.adapter import run_avatar
from openrois_avatar.options.settings import AvatarSettings
from openrois_body.components.gaze import Gaze

from openrois.catalog.common import ROIS_COMMON
from openrois.profiles.xml.documents import Profiles, assemble, doubts, write_documents
from openrois.profiles.xml.read import ComponentDocument, read_profile
from openrois.profiles.xml.write import component_xml
from tests.support.profiles import structural_errors


async def test_profiles_are_read_back_unchanged() -> None:
    async with run_avatar(AvatarSettings(engine="synthetic")) as avatar:
        directory = avatar.host.engine.directory
    assert directory.profile.component_ids
    documents = write_documents(directory.profile, directory.component_profiles)
    assert [structural_errors(text) for text in documents.values()] == [[]] * (1 + len(directory.component_profiles))
    read = assemble(read_profile(text) for text in documents.values())
    assert read == Profiles(directory.profile, directory.component_profiles)
    assert doubts(read) == []


def test_a_component_of_our_own() -> None:
    kind = Gaze.component_type
    for profile in (kind.profile("gaze"), kind.definition()):
        text = component_xml(profile, "avatar/gaze")
        assert structural_errors(text) == []
        assert read_profile(text) == ComponentDocument(profile, "avatar/gaze")
    assert kind.definition().sub_component_profiles == (ROIS_COMMON.urn,)
    assert kind.definition().identifier.authority == "OpenRoIS"
