"""The C# package's page: its programs, and the command that compiles one."""

import asyncio
import re
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Final

import pytest

from tests.sdk_csharp.test_operations import attached
from tests.support.deployment import gateway
from tests.support.fleet import everything
from tests.support.mono import SDK, Mono

pytestmark = pytest.mark.timeout(120)

PAGE: Final = (SDK / "README.md").read_text(encoding="utf-8")


def examples(language: str) -> list[str]:
    """Return the examples of a language."""
    found: list[str] = re.findall(rf"```{language}\n(.+?)```", PAGE, re.DOTALL)
    return found


@pytest.fixture
def first_program(mono: Mono, tmp_path: Path) -> Path:
    """The first program, compiled as the page says."""
    program, source = tmp_path / "greeting.exe", tmp_path / "Greeting.cs"
    source.write_text(examples("csharp")[0], encoding="utf-8")
    (told,) = (each for each in examples("sh") if each.startswith("mcs "))
    for name, path in (("Newtonsoft.Json.dll", mono.newtonsoft), ("greeting.exe", program), ("Greeting.cs", source)):
        assert name in told
        told = told.replace(name, str(path))
    subprocess.run(shlex.split(told), cwd=SDK, check=True, timeout=60)
    shutil.copy(mono.newtonsoft, tmp_path)
    return program


async def test_the_first_program_prints_what_the_page_says(mono: Mono, first_program: Path) -> None:
    async with gateway() as here, attached(here, everything("avatar")):
        printed = await asyncio.to_thread(mono.run, first_program, here.url)
    assert printed == examples("text")[0]


def test_the_script_of_a_scene_compiles(mono: Mono, csharp_library: Path, stand_in: Path, tmp_path: Path) -> None:
    (tmp_path / "Guide.cs").write_text(examples("csharp")[1], encoding="utf-8")
    sources = [*(SDK / "Runtime" / "Unity").glob("*.cs"), tmp_path / "Guide.cs"]
    mono.build(tmp_path / "guide.dll", sources, "-target:library", f"-r:{csharp_library}", f"-r:{stand_in}")


def test_the_page_has_no_other_programs() -> None:
    assert (len(examples("csharp")), len(examples("text")), len(examples("sh"))) == (2, 1, 1)
