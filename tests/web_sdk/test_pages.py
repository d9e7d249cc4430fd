"""What the page knows of control, without a document: two pages and a program at a real gateway."""

import subprocess
import time
from pathlib import Path

import pytest

from tests.support.fleet import everything
from tests.support.guarded import guarded
from tests.support.json_program import json_program
from tests.support.tokens import issue
from tests.web_sdk.conftest import HERE, WEB_DEMO


@pytest.fixture
def bundle(node: Path, tmp_path: Path) -> Path:
    """The program with the modules of the page that it uses."""
    made = tmp_path / "pages.mjs"
    bundling = (WEB_DEMO / "node_modules/.bin/esbuild", HERE / "pages.mjs", "--bundle", f"--outfile={made}")
    subprocess.run([*bundling, "--platform=node", "--format=esm", "--log-level=error"], check=True, timeout=60)
    return made


async def test_pages_take_over_from_a_program_and_see_who_has_which_part(
    node: Path, package: Path, bundle: Path, tmp_path: Path
) -> None:
    now = time.time()
    tokens = [
        issue(now, sub=subject, rank=rank)
        for subject, rank in (("night watch", "script"), ("ann", "person"), ("bob", "person"))
    ]
    variables = {"OPENROIS_SDK": str(package), "WEB_DEMO": str(WEB_DEMO), "TOKEN": " ".join(tokens)}
    async with guarded(tmp_path) as here:
        await here.gateway.engine.attach(everything().registry)
        async with json_program(node, bundle, here.gateway.url, environment=variables) as app:
            free = ["gesture free", "voice free"]
            assert await app.says("before") == [["legs other night watch", *free], True]
            mine = ["legs mine  night watch", "gesture mine", "voice free"]
            assert await app.says("mine") == mine
            theirs = ["legs other ann night watch", "gesture other ann", "voice free"]
            assert await app.says("seen by another") == theirs
            assert await app.says("refused") == "ann has control. Ask for it first."
            assert await app.says("to be asked") is False
            assert await app.says("still") == mine
            assert await app.says("restored") == "robot/move"
            assert await app.says("after") == ["legs other night watch", *free]
            assert await app.says("one part") == ["legs other ann night watch", *free]
            assert await app.says("restored") == "robot/move"
            assert await app.says("lost") == []
            await app.ends()
