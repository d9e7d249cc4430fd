"""Packages for Unity's Package Manager: what the manager asks of their files."""

import json
import re
from pathlib import Path

__all__ = ["check_assemblies", "check_identities", "imported"]


def imported(package: Path) -> list[Path]:
    """Return the files and folders that Unity imports: no samples."""
    return [
        path
        for path in package.rglob("*")
        if path.suffix != ".meta" and not any(part.endswith("~") for part in path.relative_to(package).parts)
    ]


def check_identities(package: Path) -> None:
    """Check that every asset has an identity of its own.

    A package from a git URL cannot be written to, and Unity ignores what has no .meta there.
    """
    files = {path: path.with_name(f"{path.name}.meta") for path in imported(package)}
    assert [path for path, meta in files.items() if not meta.is_file()] == []
    assert sorted(files.values()) == sorted(package.rglob("*.meta"))
    texts = [meta.read_text() for meta in files.values()]
    identities = [re.findall(r"^guid: ([0-9a-f]{32})$", text, re.MULTILINE) for text in texts]
    assert all(len(each) == 1 for each in identities)
    assert len({each[0] for each in identities}) == len(files)


def check_assemblies(package: Path, pure: str, components: str) -> None:
    """Check manifest and assemblies: one that knows no engine, and one with the components that uses it."""
    manifest = json.loads((package / "package.json").read_text())
    assert "com.unity.nuget.newtonsoft-json" in manifest["dependencies"]
    assert all((package / sample["path"]).is_dir() for sample in manifest["samples"])
    assemblies = {
        found["name"]: found
        for path in imported(package)
        if path.suffix == ".asmdef"
        for found in [json.loads(path.read_text())]
    }
    assert set(assemblies) == {pure, components}
    assert assemblies[pure]["noEngineReferences"] is True
    assert pure in assemblies[components]["references"]
