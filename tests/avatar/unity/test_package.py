"""The package as Unity's Package Manager reads it."""

import json
import re
from pathlib import Path

from openrois_avatar.link.messages import VISEMES

from tests.support.unity import PACKAGE


def imported() -> list[Path]:
    """The files and folders that Unity imports: no samples."""
    return [
        path
        for path in PACKAGE.rglob("*")
        if path.suffix != ".meta" and not any(part.endswith("~") for part in path.relative_to(PACKAGE).parts)
    ]


def test_every_asset_has_an_identity_of_its_own() -> None:
    """A package from a git URL cannot be written to, and Unity ignores what has no .meta there."""
    files = {path: path.with_name(f"{path.name}.meta") for path in imported()}
    assert [path for path, meta in files.items() if not meta.is_file()] == []
    assert sorted(files.values()) == sorted(PACKAGE.rglob("*.meta"))
    texts = [meta.read_text() for meta in files.values()]
    identities = [re.findall(r"^guid: ([0-9a-f]{32})$", text, re.MULTILINE) for text in texts]
    assert all(len(each) == 1 for each in identities)
    assert len({each[0] for each in identities}) == len(files)


def test_manifest_and_assemblies() -> None:
    manifest = json.loads((PACKAGE / "package.json").read_text())
    assert "com.unity.nuget.newtonsoft-json" in manifest["dependencies"]
    assert all((PACKAGE / sample["path"]).is_dir() for sample in manifest["samples"])
    protocol, components = (json.loads(path.read_text()) for path in sorted(PACKAGE.rglob("*.asmdef")))
    assert (protocol["name"], protocol["noEngineReferences"]) == ("OpenRoIS.Link", True)
    assert components["references"] == [protocol["name"]]


def test_a_component_is_in_a_file_of_its_name() -> None:
    """Else Unity does not find it."""
    for path in (PACKAGE / "Runtime/Unity").glob("*.cs"):
        assert re.findall(r"class (\w+) : MonoBehaviour", path.read_text()) in ([], [path.stem])


def test_the_protocol_part_does_not_know_unity() -> None:
    assert [path for path in (PACKAGE / "Runtime/Protocol").glob("*.cs") if "UnityEngine" in path.read_text()] == []


def test_the_mouth_has_the_shapes_of_the_link() -> None:
    text = (PACKAGE / "Runtime/Protocol/Visemes.cs").read_text()
    assert tuple(re.findall(r'"(\w+)"', text)) == VISEMES
