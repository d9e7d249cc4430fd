"""The example of the guide, as a person runs it."""

import asyncio
import sys
from pathlib import Path

from tests.support.mcp_site import site
from tests.support.packages import ROOT


async def run(*arguments: str) -> tuple[int | None, str, str]:
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        ROOT / "docs" / "examples" / "agent_host.py",
        *arguments,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    out, err = await process.communicate()
    return process.returncode, out.decode(), err.decode()


async def test_a_host_in_python_lets_a_body_speak(tmp_path: Path) -> None:
    async with site(tmp_path, with_tokens=False) as opened:
        code, said, complaints = await run("Nice to meet you.", opened.url)
        assert (code, complaints) == (0, "")
        assert said.splitlines()[0].startswith("tools: bodies, use_body, say, ")
        assert said.splitlines()[-2:] == ["say did: robot said it.", "give_back did: robot was given back."]
        assert opened.actor.speaking.did == ["Nice to meet you."]
        assert await opened.is_free()


async def test_without_a_gateway_it_says_what_to_do() -> None:
    code, said, complaints = await run("Hello.", "ws://127.0.0.1:9/")
    assert (code, complaints) == (0, "")
    assert said.splitlines()[-1].startswith("use_body failed: ConnectionLost: no gateway answers at ws://127.0.0.1:9/")
