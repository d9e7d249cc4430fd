"""C# on this machine: Mono's compiler, its run time, and Newtonsoft's library."""

import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Self

__all__ = ["SDK", "Mono"]

SDK = Path(__file__).parents[2] / "sdk" / "csharp"

_PATIENCE = 60


@dataclass(frozen=True, slots=True)
class Mono:
    """The programs and the library."""

    compiler: str
    runtime: str
    newtonsoft: Path

    @classmethod
    def found(cls) -> Self | None:
        """Return what is installed, None where something is missing."""
        compiler, runtime = shutil.which("mcs"), shutil.which("mono")
        newtonsoft = next(Path("/usr/lib/cli").glob("Newtonsoft.Json-*/Newtonsoft.Json.dll"), None)
        if compiler is None or runtime is None or newtonsoft is None:
            return None
        return cls(compiler, runtime, newtonsoft)

    def compile(self, sources: Iterable[Path], folder: Path) -> Path:
        """Compile the SDK with further sources to a program in `folder`; a warning is an error."""
        program = folder / "program.exe"
        self.build(program, (*sorted(SDK.rglob("*.cs")), *sources), "-r:System.Runtime.Serialization")
        return program

    def build(self, target: Path, sources: Iterable[Path], *options: str) -> None:
        """Compile sources alone to a program or, with `-target:library`, to a library; a warning is an error."""
        common = ("-warnaserror", "-langversion:6", f"-r:{self.newtonsoft}", f"-out:{target}")
        self._run(self.compiler, *common, *options, *map(str, sources))
        shutil.copy(self.newtonsoft, target.parent)

    def run(self, program: Path, *arguments: str) -> str:
        """Run a program and return what it prints."""
        return self._run(self.runtime, str(program), *arguments)

    def _run(self, *command: str) -> str:
        ran = subprocess.run(command, capture_output=True, text=True, check=False, timeout=_PATIENCE, encoding="utf-8")
        assert ran.returncode == 0, ran.stdout + ran.stderr
        return ran.stdout
