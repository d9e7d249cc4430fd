"""`openrois mcp` as a host starts it: a process of its own, at a real gateway."""

import asyncio
import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from tests.support.actors import Actor
from tests.support.mcp_hosts import GENERATIONS, Generation, text_of
from tests.support.mcp_site import agent_token, site, started


def program(name: str = "mcp") -> psutil.Process:
    """Return the child of this process that runs a command."""
    children: list[psutil.Process] = psutil.Process().children(recursive=True)
    return next(child for child in children if name in child.cmdline())


@pytest.mark.parametrize("mode", GENERATIONS)
async def test_a_host_that_closes_frees_its_body(tmp_path: Path, mode: Generation) -> None:
    async with site(tmp_path) as opened:
        token_file = tmp_path / "agent.token"
        token_file.write_text(agent_token("ann"))
        async with started(opened.url, mode=mode, token_file=token_file) as host:
            assert not (await host.call_tool("use_body", {})).is_error
            said = await host.call_tool("say", {"text": "Good day!"})
            assert text_of(said) == "robot said it."
            assert not await opened.is_free(agent_token("bob"))
        await opened.until_free(agent_token("bob"))
        assert opened.actor.speaking.did == ["Good day!"]


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
async def test_a_process_that_is_ended_stops_and_frees_its_body(tmp_path: Path, how: signal.Signals) -> None:
    actor = Actor(at_once=False)
    async with (
        site(tmp_path, actor=actor, with_tokens=False, lease_grace=0.5) as opened,
        started(opened.url) as host,
    ):
        await host.call_tool("use_body", {"tools": ["go_to"]})
        going = asyncio.ensure_future(host.call_tool("go_to", {"place": "plant"}))
        await actor.walking.begun.wait()
        program().send_signal(how)
        await actor.walking.stopped.wait()
        await opened.until_free()
        await asyncio.wait({going})
        going.exception()


def test_a_host_that_is_killed_frees_its_body() -> None:
    """Its end of the pipe is closed by the system: that is what a process of `openrois mcp` sees of it."""
    reading, writing = os.pipe()
    command = [sys.executable, "-m", "openrois.cli", "mcp", "--gateway", "ws://127.0.0.1:1/"]
    with subprocess.Popen(command, stdin=reading, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        os.close(reading)
        os.close(writing)
        assert process.wait(60) == 0
        assert process.communicate() == (b"", b"")


async def test_without_a_gateway_it_starts_and_says_so() -> None:
    async with started("ws://127.0.0.1:1/") as host:
        assert len((await host.list_tools()).tools) == 14
        refused = await host.call_tool("use_body", {})
        assert refused.is_error
        assert text_of(refused).startswith("ConnectionLost: ")
        assert "ws://127.0.0.1:1/" in text_of(refused)
