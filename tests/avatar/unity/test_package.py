"""The package as Unity's Package Manager reads it."""

import re

from openrois_avatar.link.messages import VISEMES

from tests.support.unity import PACKAGE
from tests.support.upm import check_assemblies, check_identities


def test_every_asset_has_an_identity_of_its_own() -> None:
    check_identities(PACKAGE)


def test_manifest_and_assemblies() -> None:
    check_assemblies(PACKAGE, "OpenRoIS.Link", "OpenRoIS.Link.Unity")


def test_a_component_is_in_a_file_of_its_name() -> None:
    """Else Unity does not find it."""
    for path in (PACKAGE / "Runtime/Unity").glob("*.cs"):
        assert re.findall(r"class (\w+) : MonoBehaviour", path.read_text()) in ([], [path.stem])


def test_the_protocol_part_does_not_know_unity() -> None:
    assert [path for path in (PACKAGE / "Runtime/Protocol").glob("*.cs") if "UnityEngine" in path.read_text()] == []


def test_the_mouth_has_the_shapes_of_the_link() -> None:
    text = (PACKAGE / "Runtime/Protocol/Visemes.cs").read_text()
    assert tuple(re.findall(r'"(\w+)"', text)) == VISEMES
