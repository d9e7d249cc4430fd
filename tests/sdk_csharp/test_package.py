"""The package as Unity's Package Manager reads it, and its components in a stand-in for Unity."""

import asyncio
import re
from pathlib import Path
from typing import Any, cast

import pytest

from openrois.catalog.actuation import REACTION, SPEECH_SYNTHESIS
from tests.support.deployment import adapter, gateway
from tests.support.fleet import Part
from tests.support.mono import SDK, Mono, sdk_sources
from tests.support.once import once
from tests.support.streams import Camera, FakeStreams
from tests.support.upm import check_assemblies, check_identities

UNITY = Path(__file__).with_name("unity")
COMPONENTS = sorted((SDK / "Runtime" / "Unity").glob("*.cs"))
SCENE = sorted((SDK / "Samples~" / "Scene").glob("*.cs"))


@pytest.fixture(scope="session")
def player(mono: Mono, csharp_library: Path, stand_in: Path) -> Path:
    """The sample's scene, with what plays it."""
    sources = [*COMPONENTS, *SCENE, UNITY / "Player.cs"]
    made = csharp_library.with_name("player.exe")
    return once(made, lambda new: mono.build(new, sources, f"-r:{csharp_library}", f"-r:{stand_in}"))


def test_every_asset_has_an_identity_of_its_own() -> None:
    check_identities(SDK)


def test_manifest_and_assemblies() -> None:
    check_assemblies(SDK, "OpenRoIS", "OpenRoIS.Unity")


def test_a_component_is_in_a_file_of_its_name() -> None:
    """Else Unity does not find it."""
    for path in (*COMPONENTS, *SCENE):
        assert re.findall(r"class (\w+) : MonoBehaviour", path.read_text()) in ([], [path.stem])


def test_the_client_does_not_know_unity() -> None:
    assert [path for path in sdk_sources() if "UnityEngine" in path.read_text()] == []


def test_no_file_needs_a_newer_language_than_the_oldest_compiler() -> None:
    """Mono's compiler takes some of these outside of asynchronous methods, and crashes inside."""
    newer = re.compile(
        r"\bout (?:var|[A-Z]\w*) \w+\s*[,)]|\bis [A-Z]\w* [a-z]\w*\b|\bswitch\s*\{|^\s*using var |\brecord\b"
    )
    sources = (*sdk_sources(), *COMPONENTS, *SCENE, *(SDK / "Samples~" / "Console").glob("*.cs"))
    code = {path: re.sub(r"//.*", "", path.read_text()) for path in sources}
    declared = re.compile(r"\((?:[^()]*,\s*)?out [A-Z]\w* \w+\)\s*$", re.MULTILINE)
    assert {path.name: found for path, text in code.items() if (found := newer.findall(declared.sub("", text)))} == {}


def test_in_a_browser_the_component_compiles_too(
    mono: Mono, csharp_library: Path, stand_in: Path, tmp_path: Path
) -> None:
    options = ("-target:library", "-d:UNITY_WEBGL", f"-r:{csharp_library}", f"-r:{stand_in}")
    mono.build(tmp_path / "browser.dll", COMPONENTS, *options)


async def test_the_scene_of_the_sample_is_played(mono: Mono, player: Path) -> None:
    speech, reaction, streams = Part(SPEECH_SYNTHESIS), Part(REACTION), FakeStreams()
    parts = cast(Any, (speech, reaction, Camera()))
    async with gateway() as running, adapter(running, *parts, extension=streams):
        printed = await asyncio.to_thread(mono.run, player, running.url)
    lines = printed.splitlines()
    assert lines[:5] == ["reserved", "greeted", "remote v=0", "close", ""]
    assert lines[5].startswith('"somewhere" is no address of a gateway')
    assert lines[6:] == ["ArgumentException"]
    assert speech.parameters["speech_text"] == "Hello! I am glad to see you."
    assert (speech.done, reaction.done) == (["start"], ["start"])
    (answer,) = (params for method, params, _ in streams.calls if method == "signaling.answer")
    assert answer["sdp"] == "v=0 answer"
