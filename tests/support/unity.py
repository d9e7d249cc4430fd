"""The package for Unity: where it is, and the programs of its parts that run without Unity."""

import re
from pathlib import Path
from typing import Final

from tests.support.mono import Mono

__all__ = ["PACKAGE", "console", "encoding", "player", "vectors"]

PACKAGE: Final = Path(__file__).parents[2] / "avatar_adapter" / "unity"
_TESTS: Final = Path(__file__).parents[1] / "avatar" / "unity"
_UNSAFE: Final = "-unsafe"
_LIBRARY: Final = "-target:library"


def vectors(mono: Mono, folder: Path) -> Path:
    """The program that is asked by a file what the pure parts make of something."""
    program = folder / "vectors.exe"
    mono.build(program, [*_sources("Runtime/Protocol"), _TESTS / "Vectors.cs"], _UNSAFE)
    return program


def console(mono: Mono, folder: Path) -> Path:
    """The sample, a whole engine; it sees the public side of the protocol part alone."""
    program = folder / "console.exe"
    mono.build(program, _sources("Samples~/Console"), f"-r:{_protocol(mono, folder)}")
    return program


def encoding(mono: Mono, folder: Path) -> Path:
    """An engine that sends access units out of a file."""
    program = folder / "encoding.exe"
    mono.build(program, [_TESTS / "Encoding.cs"], f"-r:{_protocol(mono, folder)}")
    return program


def player(mono: Mono, folder: Path) -> Path:
    """The components for Unity and the README's, in a stand-in for it; they too see the public side alone."""
    program, stand_in, example = folder / "player.exe", folder / "UnityEngine.dll", folder / "Example.cs"
    example.write_text(re.findall(r"```csharp\n(.+?)```", (PACKAGE / "README.md").read_text(), re.DOTALL)[0])
    mono.build(stand_in, [_TESTS / "UnityEngine.cs"], _UNSAFE, _LIBRARY)
    sources = [*_sources("Runtime/Unity"), _TESTS / "Player.cs", example]
    mono.build(program, sources, _UNSAFE, f"-r:{_protocol(mono, folder)}", f"-r:{stand_in}")
    return program


def _protocol(mono: Mono, folder: Path) -> Path:
    library = folder / "OpenRoIS.Link.dll"
    if not library.exists():
        mono.build(library, _sources("Runtime/Protocol"), _UNSAFE, _LIBRARY)
    return library


def _sources(folder: str) -> list[Path]:
    return sorted((PACKAGE / folder).glob("*.cs"))
