"""The example in the guide and in the README, as a person runs it."""

import asyncio
import sys
from pathlib import Path
from typing import Final

import pytest

from openrois.client import Client
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.fleet import everything

pytestmark = pytest.mark.extra(name="gateway")

EXAMPLES: Final = Path(__file__).parents[3] / "docs" / "examples"


async def run(example: str, *arguments: str) -> tuple[int | None, str, str]:
    process = await asyncio.create_subprocess_exec(
        sys.executable, EXAMPLES / example, *arguments, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE
    )
    out, err = await process.communicate()
    return process.returncode, out.decode(), err.decode()


async def test_a_body_that_is_free_is_made_to_speak_and_to_move() -> None:
    taken, robot = everything("avatar"), everything("robot")
    async with run_gateway(GatewaySettings(port=0)) as gateway:
        await gateway.engine.attach(taken.registry)
        await gateway.engine.attach(robot.registry)
        async with Client(gateway.url) as other, other.bound("avatar/reaction"):
            code, said, complaints = await run("talk.py", "Nice to meet you.", gateway.url)
    assert (code, said, complaints) == (0, "robot said: Nice to meet you.\n", "")
    assert taken.parts["SpeechSynthesis"].done == []
    assert robot.parts["SpeechSynthesis"].done == ["start"]
    assert robot.parts["SpeechSynthesis"].parameters["speech_text"] == "Nice to meet you."
    assert robot.parts["Reaction"].parameters["reaction_ref"] == "nod"
    assert robot.parts["Reaction"].done == ["start"]


async def test_without_a_gateway_it_says_what_to_do() -> None:
    code, _, complaints = await run("talk.py", "Hello.", "ws://127.0.0.1:9/")
    assert code == 1
    assert "no gateway answers at ws://127.0.0.1:9/; `openrois gateway` starts one here" in complaints


def test_it_is_short() -> None:
    assert len((EXAMPLES / "talk.py").read_text().splitlines()) < 30
