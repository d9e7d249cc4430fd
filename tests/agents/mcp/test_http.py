"""The tools over streamable HTTP: whose session it is, and who is let in, at a real gateway with tokens."""

import asyncio
from collections.abc import Mapping
from pathlib import Path

import pytest
from openrois_agents.tools.settings import ToolSettings

from tests.support.actors import Actor
from tests.support.mcp_hosts import GENERATIONS, Generation, text_of
from tests.support.mcp_site import agent_token, bearer, hosted_at, site

TOOLS = ToolSettings()


@pytest.mark.parametrize("mode", GENERATIONS)
async def test_a_caller_holds_a_body_for_a_task_of_several_requests(tmp_path: Path, mode: Generation) -> None:
    async with site(tmp_path, http=TOOLS) as opened:
        token = agent_token("ann")
        async with hosted_at(opened.tools, token, mode) as host:
            assert not (await host.call_tool("use_body", {})).is_error
        told: list[str | None] = []

        async def note(progress: float, total: float | None, message: str | None) -> None:
            told.append(message)

        async with hosted_at(opened.tools, token, mode) as host:
            said = await host.call_tool("say", {"text": "Good day!"}, progress_callback=note)
            assert not said.is_error, text_of(said)
            await host.call_tool("give_back", {})
        assert opened.actor.speaking.did == ["Good day!"]
        assert told == ["start of robot/speech_synthesizer runs"]
        assert await opened.is_free(token)


async def test_two_callers_never_share_a_part(tmp_path: Path) -> None:
    async with (
        site(tmp_path, http=TOOLS) as opened,
        hosted_at(opened.tools, agent_token("ann")) as ann,
        hosted_at(opened.tools, agent_token("bob")) as bob,
    ):
        assert not (await ann.call_tool("use_body", {"tools": ["say"]})).is_error
        refused = await bob.call_tool("use_body", {"tools": ["say"], "wait": 0})
        assert "robot/speech_synthesizer is bound by another application" in text_of(refused)
        assert "no body is held" in text_of(await bob.call_tool("say", {"text": "x"}))
        assert not (await bob.call_tool("use_body", {"tools": ["gesture"]})).is_error


async def test_a_newer_token_of_the_same_subject_goes_on_with_the_task(tmp_path: Path) -> None:
    async with site(tmp_path, http=TOOLS) as opened:
        async with hosted_at(opened.tools, agent_token("ann", jti="1")) as host:
            await host.call_tool("use_body", {})
        async with hosted_at(opened.tools, agent_token("ann", jti="2")) as host:
            assert not (await host.call_tool("say", {"text": "still here"})).is_error


async def test_a_token_with_other_rights_has_a_session_of_its_own(tmp_path: Path) -> None:
    async with site(tmp_path, http=TOOLS) as opened:
        async with hosted_at(opened.tools, agent_token("ann")) as host:
            await host.call_tool("use_body", {})
        async with hosted_at(opened.tools, agent_token("ann", roles=["viewer"])) as host:
            assert "no body is held" in text_of(await host.call_tool("say", {"text": "x"}))
            assert "UNSUPPORTED" in text_of(await host.call_tool("use_body", {"wait": 0}))


async def test_a_gateway_that_judges_no_token_has_a_caller_for_each(tmp_path: Path) -> None:
    async with site(tmp_path, with_tokens=False, http=TOOLS) as opened:
        async with hosted_at(opened.tools, agent_token("ann")) as host:
            assert not (await host.call_tool("use_body", {})).is_error
        async with hosted_at(opened.tools, agent_token("ann", jti="forged")) as host:
            assert "no body is held" in text_of(await host.call_tool("say", {"text": "x"}))


INITIALIZE: Mapping[str, object] = {
    "jsonrpc": "2.0",
    "id": 1,
    "method": "initialize",
    "params": {"protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}},
}


@pytest.mark.parametrize(
    ("token", "headers", "status", "said"),
    [
        ("", {}, 401, "each caller shows a token of its own"),
        ("forged.token.here", {}, 401, "the gateway does not let this token in"),
        ("good", {"Host": "evil.example.org"}, 421, "this server is not called so"),
        ("good", {"Origin": "https://evil.example.org"}, 403, "this page may not use the server"),
        ("good", {"Origin": "null"}, 403, "this page may not use the server"),
        ("ended", {}, 401, "the token has ended"),
        ("good", {"Origin": "https://app.example.org"}, 200, "openrois"),
        ("good", {}, 200, "openrois"),
    ],
)
async def test_who_is_let_in(tmp_path: Path, token: str, headers: dict[str, str], status: int, said: str) -> None:
    shown = {"good": agent_token("ann"), "ended": agent_token("ann", exp=1)}.get(token, token)
    async with site(tmp_path, http=TOOLS) as opened, bearer(shown) as http:
        if not token:
            del http.headers["Authorization"]
        accept = {"Accept": "application/json, text/event-stream"}
        answer = await http.post(opened.tools, json=INITIALIZE, headers={**accept, **headers})
        assert (answer.status_code, said in answer.text) == (status, True), answer.text
        assert ("www-authenticate" in answer.headers) == (status == 401)
        assert "access-control-allow-origin" not in answer.headers


async def test_the_session_of_another_caller_is_not_there(tmp_path: Path) -> None:
    async with (
        site(tmp_path, http=TOOLS) as opened,
        bearer(agent_token("ann")) as ann,
        bearer(agent_token("eve")) as eve,
    ):
        accept = {"Accept": "application/json, text/event-stream"}
        begun = await ann.post(opened.tools, json=INITIALIZE, headers=accept)
        named = {**accept, "Mcp-Session-Id": begun.headers["mcp-session-id"]}
        listing = {"jsonrpc": "2.0", "id": 2, "method": "tools/list"}
        assert (await eve.post(opened.tools, json=listing, headers=named)).status_code == 404
        assert (await ann.post(opened.tools, json=listing, headers=named)).status_code == 200


async def test_a_caller_that_does_not_come_back_frees_its_body(tmp_path: Path) -> None:
    async with site(tmp_path, http=ToolSettings(idle=0.2)) as opened:
        async with hosted_at(opened.tools, agent_token("ann")) as host:
            await host.call_tool("use_body", {})
        await opened.until_free(agent_token("bob"))


@pytest.mark.parametrize("mode", GENERATIONS)
async def test_a_request_that_is_cut_off_stops_what_it_began(tmp_path: Path, mode: Generation) -> None:
    actor = Actor(at_once=False)
    async with (
        site(tmp_path, actor=actor, http=TOOLS) as opened,
        hosted_at(opened.tools, agent_token("ann"), mode) as host,
    ):
        await host.call_tool("use_body", {"tools": ["go_to"]})
        going = asyncio.ensure_future(host.call_tool("go_to", {"place": "plant"}))
        await actor.walking.begun.wait()
        going.cancel()
        await actor.walking.stopped.wait()
