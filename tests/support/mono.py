"""C# on this machine: Mono's compiler, its run time, and Newtonsoft's library."""

import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from tests.support.once import once

__all__ = ["SDK", "Mono", "sdk_sources"]

SDK = Path(__file__).parents[2] / "sdk" / "csharp"

_LAUNCHER = Path(__file__).with_name("Launcher.cs")
_PATIENCE = 60
_LIBRARY = "-target:library"
_SERIALIZATION = "-r:System.Runtime.Serialization"


def sdk_sources() -> list[Path]:
    """The sources of the SDK that need no game engine."""
    return sorted((SDK / "Runtime" / "OpenRoIS").rglob("*.cs"))


@dataclass(frozen=True, slots=True)
class Mono:
    """The programs and the library."""

    compiler: str
    runtime: str
    newtonsoft: Path
    folder: Path

    @classmethod
    def found(cls, folder: Path) -> Self | None:
        """Return what is installed, None where something is missing; `folder` is for what several tests compile."""
        compiler, runtime = shutil.which("mcs"), shutil.which("mono")
        newtonsoft = next(Path("/usr/lib/cli").glob("Newtonsoft.Json-*/Newtonsoft.Json.dll"), None)
        if compiler is None or runtime is None or newtonsoft is None:
            return None
        return cls(compiler, runtime, newtonsoft, folder)

    def library(self, folder: Path) -> Path:
        """Compile the SDK for C# to a library in `folder`, where one is not there yet; a warning is an error."""
        return once(folder / "OpenRoIS.dll", lambda made: self.build(made, sdk_sources(), _SERIALIZATION, _LIBRARY))

    def compile(self, sources: Iterable[Path], folder: Path, library: Path) -> Path:
        """Compile sources, which see the public side of `library` alone, to a program in `folder`."""
        program = folder / "program.exe"
        self.build(program, sources, f"-r:{library}")
        shutil.copy(library, folder)
        return program

    def build(self, target: Path, sources: Iterable[Path], *options: str) -> None:
        """Compile sources alone to a program or, with `-target:library`, to a library; a warning is an error."""
        common = ("-warnaserror", "-langversion:6", f"-r:{self.newtonsoft}", f"-out:{target}")
        self._run(self.compiler, *common, *options, *map(str, sources))
        # Once: a program of another process may have it mapped.
        once(target.with_name(self.newtonsoft.name), self._copy_newtonsoft)

    def command(self, program: Path) -> tuple[str | Path, ...]:
        """Return the command that runs a program, and ends when that does: of itself Mono does not always."""
        launcher = once(self.folder / "launcher.exe", lambda made: self.build(made, [_LAUNCHER]))
        return (self.runtime, launcher, program)

    def run(self, program: Path, *arguments: str) -> str:
        """Run a program and return what it prints."""
        return self._run(*map(str, self.command(program)), *arguments)

    def _copy_newtonsoft(self, made: Path) -> None:
        shutil.copy(self.newtonsoft, made)

    def _run(self, *command: str) -> str:
        ran = subprocess.run(command, capture_output=True, text=True, check=False, timeout=_PATIENCE, encoding="utf-8")
        assert ran.returncode == 0, ran.stdout + ran.stderr
        return ran.stdout
