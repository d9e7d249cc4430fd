"""Callers over HTTP: whom the gateway lets in, how many there may be, and what a process of the tools may itself."""

import asyncio
import os
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path

import pytest
from openrois_agents.mcp import callers as module
from openrois_agents.mcp.callers import VERIFIED_FOR, Callers
from openrois_agents.mcp.guard import Refused
from openrois_agents.tools.settings import ToolSettings

from openrois.client import Client
from tests.support.demo import free_port
from tests.support.mcp_hosts import PATIENCE, text_of
from tests.support.mcp_site import Site, agent_token, hosted_at, site


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@asynccontextmanager
async def callers(url: str, clock: Clock | None = None) -> AsyncIterator[Callers]:
    def make_client(token: Callable[[], str] | None) -> Client:
        return Client(url, token=token)

    async with Callers(make_client, ToolSettings(), clock or Clock()) as opened:
        yield opened


async def test_a_gateway_that_is_not_there_is_said() -> None:
    async with callers("ws://127.0.0.1:1/") as opened:
        with pytest.raises(Refused, match=r"the gateway cannot be asked: .*ws://127\.0\.0\.1:1/") as refused:
            await opened.admit(agent_token("ann"))
        assert refused.value.status == 503


async def test_one_subject_is_one_caller(tmp_path: Path) -> None:
    async with site(tmp_path) as running, callers(running.url) as opened:
        first = await opened.admit(agent_token("ann", jti="1"))
        assert await opened.admit(agent_token("ann", jti="2")) is first
        assert await opened.admit(agent_token("bob")) is not first
        assert len(opened) == 2


async def test_a_token_that_was_revoked_is_refused_after_a_minute_at_the_latest(tmp_path: Path) -> None:
    revoked, clock = tmp_path / "revoked", Clock()
    revoked.write_text("")
    async with site(tmp_path, auth_revocations=revoked) as running, callers(running.url, clock) as opened:
        old, new = agent_token("ann", jti="old"), agent_token("ann", jti="new")
        caller = await opened.admit(old)
        assert await opened.admit(new) is caller
        revoked.write_text("jti old\n")
        running.reload()
        clock.now = VERIFIED_FOR
        with pytest.raises(Refused, match="the gateway does not let this token in") as refused:
            await opened.admit(old)
        assert refused.value.status == 401
        assert await opened.admit(new) is caller


async def test_only_so_many_callers_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_CALLERS", 1)
    async with site(tmp_path) as running, callers(running.url) as opened:
        ann = await opened.admit(agent_token("ann"))
        bob = await opened.admit(agent_token("bob"))
        assert (len(opened), await opened.admit(agent_token("ann")) is ann) == (1, False)
        caller = await opened.admit(agent_token("bob"))
        assert caller is not bob
        await caller.session.use_body(None, None, 0)
        with pytest.raises(Refused, match="there are 1 callers already") as refused:
            await opened.admit(agent_token("ann"))
        assert refused.value.status == 503


async def test_only_so_many_tokens_are_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_TOKENS", 2)
    shown: list[bool] = []
    async with site(tmp_path) as running:

        def make_client(token: Callable[[], str] | None) -> Client:
            shown.append(token is not None)
            return Client(running.url, token=token)

        async with Callers(make_client, ToolSettings(), Clock()) as opened:
            tokens = [agent_token("ann", jti=str(number)) for number in range(3)]
            for token in tokens:
                await opened.admit(token)
            assert shown.count(True) == 3
            await opened.admit(tokens[2])
            assert shown.count(True) == 3
            await opened.admit(tokens[0])
            assert shown.count(True) == 4
            # Whether the gateway judges tokens is asked once.
            assert shown.count(False) == 1


@contextmanager
def process(running: Site, folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run `openrois mcp --http`, with a good token in its environment, which is none of its business."""
    token_file = folder / "agent.token"
    token_file.write_text(agent_token("mallory", roles=["administrator"]))
    command = [sys.executable, "-m", "openrois.cli", "mcp", "--gateway", running.url, "--http", str(free_port())]
    environment = {**os.environ, "OPENROIS_TOKEN_FILE": str(token_file)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as started:
        try:
            assert started.stdout is not None
            yield started, started.stdout.readline().split()[1]
        finally:
            started.kill()


async def test_the_process_has_no_rights_of_its_own_and_gives_bodies_back_when_it_is_ended(tmp_path: Path) -> None:
    async with site(tmp_path) as running:
        with process(running, tmp_path) as (started, address):
            await _use(running, started, address)


async def _use(running: Site, started: "subprocess.Popen[str]", address: str) -> None:
    async with hosted_at(address, agent_token("vera", roles=["viewer"])) as host:
        assert "UNSUPPORTED" in text_of(await host.call_tool("use_body", {"wait": 0}))
    async with hosted_at(address, agent_token("ann")) as host:
        assert not (await host.call_tool("use_body", {})).is_error
    assert not await running.is_free(agent_token("bob"))
    started.send_signal(signal.SIGTERM)
    assert await asyncio.to_thread(started.wait, PATIENCE) == 0
    await running.until_free(agent_token("bob"))
