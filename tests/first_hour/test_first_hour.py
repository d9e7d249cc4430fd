"""The tutorial: its programs run, in its order, and print what its pages say."""

import asyncio
import os
import re
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.fleet import everything

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs/first-hour"
EXAMPLES = ROOT / "docs/examples"


def outputs(page: str) -> list[str]:
    """Return what a page says that programs print."""
    text = (PAGES / page).read_text(encoding="utf-8")
    return re.findall(r"^```text\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


async def run(program: Path, *arguments: str) -> str:
    process = await asyncio.create_subprocess_exec(
        sys.executable, program, *arguments, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE
    )
    out, complaints = await process.communicate()
    assert process.returncode == 0, complaints.decode()
    return out.decode()


@asynccontextmanager
async def lamp_adapter(gateway: Gateway) -> AsyncIterator[None]:
    environment = {**os.environ, "OPENROIS_GATEWAY": gateway.url}
    attached = asyncio.Event()
    gateway.engine.on_change(attached.set)
    process = await asyncio.create_subprocess_exec(sys.executable, EXAMPLES / "lamp_adapter.py", env=environment)
    try:
        await attached.wait()
        yield
    finally:
        process.terminate()
        await process.wait()


async def test_the_application_prints_what_its_page_says() -> None:
    avatar = everything("avatar")
    async with run_gateway(GatewaySettings(port=0)) as gateway:
        await gateway.engine.attach(avatar.registry)
        said = await run(EXAMPLES / "talk.py", "Nice to meet you.", gateway.url)
    assert [said] == outputs("write-an-application.md")


async def test_the_lamp_is_switched_as_its_page_says() -> None:
    async with run_gateway(GatewaySettings(port=0)) as gateway, lamp_adapter(gateway):
        printed = await run(EXAMPLES / "lamp_switch.py", gateway.url)
    assert [printed] == outputs("write-an-adapter.md")


def test_the_tests_of_the_lamp_pass_in_a_folder_of_their_own(tmp_path: Path) -> None:
    page = (PAGES / "write-an-adapter.md").read_text(encoding="utf-8")
    copied, configured = re.findall(r"^    (cp .*|printf .*)$", page, re.MULTILINE)
    for command in (copied.replace(" lamp/", f" {tmp_path}"), configured.replace("lamp/", f"{tmp_path}/")):
        subprocess.run(command, shell=True, cwd=ROOT, check=True, timeout=10)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    tried = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert tried.returncode == 0, tried.stdout
    assert re.search(r"\d\d passed", tried.stdout)


def test_the_address_of_the_demo_is_the_one_that_is_printed() -> None:
    assert outputs("see-the-avatar.md") == ["ready http://127.0.0.1:8765/\n"]
