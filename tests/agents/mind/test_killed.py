"""`openrois mind` as what supervises it sees it: killed in mid-conversation, started again, and alive."""

import asyncio
import os
import socket
import sys
import time
from asyncio.subprocess import Process
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from tests.support.actors import Actor
from tests.support.conversing import PATIENCE, Recognition, until
from tests.support.conversing_site import ConversingSite, conversing_site
from tests.support.tokens import issue

pytestmark = pytest.mark.timeout(180)

_GRACE = 1.0
_MIND = "import sys; from openrois_agents.mind.command import main; sys.exit(main(sys.argv[1:]))"


@asynccontextmanager
async def mind_process(site: ConversingSite, folder: Path, **environment: str) -> AsyncIterator[Process]:
    """Run a mind while the block runs, unless it is killed before; it listens when the block begins."""
    file = folder / "mind.token"
    file.write_text(issue(time.time(), sub="mind", scope=["*/*"], rank="agent"))
    command = [sys.executable, "-c", _MIND, "--gateway", site.url, "--token-file", str(file)]
    process = await asyncio.create_subprocess_exec(
        *command, stdout=asyncio.subprocess.PIPE, env=os.environ | environment
    )
    try:
        assert process.stdout is not None
        async with asyncio.timeout(60):
            assert (await process.stdout.readline()).startswith(b"ready ")
        yield process
    finally:
        if process.returncode is None:
            process.terminate()
        await process.wait()


async def test_a_killed_mind_leaves_its_body_free_and_still_and_the_next_one_works_on(tmp_path: Path) -> None:
    actor, recognition = Actor(at_once=False), Recognition()
    async with (
        conversing_site(tmp_path, lease_grace=_GRACE) as site,
        site.body("robot", actor, recognition),
        site.client("ann", "person") as person,
    ):
        async with mind_process(site, tmp_path) as first, asyncio.timeout(PATIENCE):
            actor.hearing.heard("go to the plant", True)
            await actor.walking.begun.wait()
            assert not (await person.bodies())[0].free
            first.kill()
            await actor.walking.stopped.wait()
            await site.until("robot", free=True)
        assert not actor.walking.begun.is_set()
        assert "grammar mind" in recognition.grammar
        actor.speaking.may_end.set()
        async with mind_process(site, tmp_path), asyncio.timeout(PATIENCE):
            actor.hearing.heard("good morning", True)
            await until(lambda: "Hello! How can I help you?" in actor.speaking.did)
            assert not (await person.bodies())[0].free
        assert len(actor.walking.did) == 1
        assert recognition.grammar == "default"


async def test_a_mind_tells_its_supervisor_that_it_is_ready_and_goes_on(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as supervisor:
        supervisor.bind(str(tmp_path / "signs"))
        supervisor.settimeout(PATIENCE)
        told = {"NOTIFY_SOCKET": supervisor.getsockname(), "WATCHDOG_USEC": "100000"}
        async with conversing_site(tmp_path) as site, mind_process(site, tmp_path, **told):
            assert (await asyncio.to_thread(supervisor.recv, 100)).startswith(b"READY=1\nSTATUS=converses at ws://")
            for _ in range(3):
                assert await asyncio.to_thread(supervisor.recv, 100) == b"WATCHDOG=1"
