"""The avatar's components have the names by which components of their types go everywhere."""

import re
from pathlib import Path

from openrois_avatar.adapter import serve_scene
from openrois_avatar.scene import external_scene
from openrois_streaming.clock import SystemClock

from openrois.adapter import components
from openrois.catalog.actuation import NAVIGATION
from openrois.catalog.basic import BASIC_COMPONENTS
from tests.support.packages import ROOT, tracked

OURS = {
    "Dialogue": "dialogue",
    "Enrolment": "enrolment",
    "Gaze": "gaze",
    "Hearing": "hearing",
    "Operator": "operator",
    "Sight": "sight",
    "SpeechProgress": "speech_progress",
    "SpeechStream": "speech_stream",
    "Surroundings": "surroundings",
    "Teleoperation": "teleoperation",
    "Viewpoint": "viewpoint",
    "Visitors": "visitors",
}
"""The names of the avatar's own components by the codes of their types."""
OF_THE_SCENE = {
    "PersonDetection": "scene_person_detecter",
    "PersonLocalization": "scene_person_localizer",
    "SoundLocalization": "scene_sound_localizer",
}
"""Second components of a type, which tell of the game engine's scene."""


async def test_each_component_has_the_name_of_its_type(tmp_path: Path) -> None:
    clock = SystemClock()
    async with (
        external_scene("avatar", f"unix:{tmp_path}/engine", "secret", clock) as scene,
        serve_scene("avatar", scene, clock) as avatar,
    ):
        profiles = avatar.host.engine.directory.component_profiles
    standard = {kind.code: getattr(components, kind.code).component_type.name for kind in BASIC_COMPONENTS}
    assert len(standard) == 17
    expected = {
        *(("OMG", code, name) for code, name in (*standard.items(), *OF_THE_SCENE.items())),
        *(("OpenRoIS", code, name) for code, name in OURS.items()),
    }
    types = {ref: (profile.identifier.authority, profile.identifier.code) for ref, profile in profiles.items()}
    assert {(*types[ref], profile.name) for ref, profile in profiles.items()} == expected
    assert set(profiles) == {f"avatar/{name}" for *_, name in expected}


def _texts() -> list[Path]:
    kinds = {".cs", ".gd", ".html", ".js", ".json", ".md", ".mjs", ".py", ".service", ".toml", ".ts", ".yaml", ".yml"}
    paths = (ROOT / path for path in tracked() if not path.startswith("CHANGELOG"))
    return [path for path in paths if path.suffix in kinds]


def test_no_reference_ends_in_the_code_of_a_type() -> None:
    codes = "|".join((*(kind.code for kind in BASIC_COMPONENTS), *OURS))
    reference = re.compile(rf"(?<![\w/.:-])[a-z]\w*/(?:Scene)?(?:{codes})(?![\w./-])")
    assert reference.search(f"component_ref = 'avatar/{NAVIGATION.code}'")
    found = {path.relative_to(ROOT): reference.findall(path.read_text(encoding="utf-8")) for path in _texts()}
    assert {path: refs for path, refs in found.items() if refs} == {}
