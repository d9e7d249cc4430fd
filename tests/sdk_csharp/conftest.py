"""The SDK for C#, compiled once, and applications of it in a Mono of their own."""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from pathlib import Path

import pytest

from tests.support.json_program import JsonProgram, json_program
from tests.support.mono import SDK, Mono
from tests.support.once import once

HERE = Path(__file__).parent

Start = Callable[..., AbstractAsyncContextManager[JsonProgram]]


@pytest.fixture(scope="session")
def applications(mono: Mono, csharp_library: Path) -> Path:
    """The program with all applications of `applications/`."""
    sources = sorted((HERE / "applications").glob("*.cs"))
    made = csharp_library.with_name("applications.exe")
    return once(made, lambda program: mono.build(program, sources, f"-r:{csharp_library}"))


@pytest.fixture(scope="session")
def two_bodies(mono: Mono, csharp_library: Path) -> Path:
    """The sample without Unity."""
    sources = sorted((SDK / "Samples~" / "Console").glob("*.cs"))
    made = csharp_library.with_name("two_bodies.exe")
    return once(made, lambda program: mono.build(program, sources, f"-r:{csharp_library}"))


@pytest.fixture(scope="session")
def stand_in(mono: Mono, csharp_folder: Path) -> Path:
    """The types of Unity that the package and its sample use."""
    made = csharp_folder / "UnityEngine.dll"
    return once(made, lambda new: mono.build(new, [HERE / "unity" / "UnityEngine.cs"], "-target:library"))


@pytest.fixture
def start(mono: Mono, applications: Path) -> Start:
    """Run an application against the gateway at an address."""

    def run(name: str, gateway: str, **environment: str) -> AbstractAsyncContextManager[JsonProgram]:
        return json_program(*mono.command(applications), name, gateway, environment=environment)

    return run
