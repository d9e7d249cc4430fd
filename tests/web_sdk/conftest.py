"""The TypeScript SDK as a package, built once, and applications of it in a Node of their own."""

import subprocess
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from pathlib import Path

import pytest

from tests.support.json_program import JsonProgram, json_program

HERE = Path(__file__).parent
WEB_DEMO = HERE.parents[1] / "web_demo"

Start = Callable[..., AbstractAsyncContextManager[JsonProgram]]


@pytest.fixture(scope="session")
def package(node: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the built package."""
    folder = tmp_path_factory.mktemp("openrois")
    subprocess.run([node, "build.mjs", "--package", folder], cwd=WEB_DEMO, check=True, timeout=60)
    return folder


@pytest.fixture
def start(node: Path, package: Path) -> Start:
    """Run a program of this folder against the gateway at an address."""

    def run(program: str, gateway: str, *flags: str, token: str = "") -> AbstractAsyncContextManager[JsonProgram]:
        variables = {"OPENROIS_SDK": str(package), "WEB_DEMO": str(WEB_DEMO), "TOKEN": token}
        return json_program(node, *flags, HERE / program, gateway, environment=variables)

    return run
