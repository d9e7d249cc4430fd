"""What is bounded: calls, events that are watched, lists, documents, listeners, and what comes over HTTP."""

import asyncio
from pathlib import Path

import pytest
from mcp.client.client import Client as Host
from openrois_agents.mcp import announcements, http_server
from openrois_agents.mcp.handlers import Handlers
from openrois_agents.mcp.server import build_server
from openrois_agents.tools import documents, session, tasks, vocabulary, watching
from openrois_agents.tools.settings import ToolSettings

from openrois.testing import memory_gateway
from tests.support.actors import Actor
from tests.support.mcp_hosts import PATIENCE, Finder, session_at, table
from tests.support.mcp_site import Site, agent_token, bearer, site

HTTP = ToolSettings()
ACCEPT = {"Accept": "application/json, text/event-stream"}
INITIALIZE = {
    "jsonrpc": "2.0",
    "id": 1,
    "method": "initialize",
    "params": {"protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}},
}


def _place(opened: Site) -> tuple[str, int]:
    host, _, port = opened.tools.removeprefix("http://").partition("/")[0].partition(":")
    return host, int(port)


async def test_of_a_caller_only_so_many_calls_run_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "MAX_CALLS", 1)
    async with table() as at_table:
        waiting = asyncio.ensure_future(at_table.call("wait_for_event", seconds=60))
        await at_table.until("waiting")
        assert await at_table.refused("bodies") == (
            "OutOfResources: 1 calls run already: wait for one of them, or cancel it"
        )
        assert await at_table.said("stop") == "robot has stopped."
        assert await at_table.said("give_back") == "No body was held."
        waiting.cancel()


async def test_a_caller_watches_only_so_many_events(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watching, "MAX_SUBSCRIPTIONS", 1)
    async with table() as at_table:
        await at_table.said("use_body")
        await at_table.said("wait_for_event", events=["heard"], seconds=0)
        await at_table.said("wait_for_event", events=["heard"], seconds=0)
        refused = await at_table.refused("wait_for_event", events=["reached_target"], seconds=0)
        assert refused == "OutOfResources: 1 events are watched already: give_back ends that"
        await at_table.said("give_back")
        await at_table.said("wait_for_event", events=["reached_target"], seconds=0)


async def test_a_list_names_only_so_many_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tasks, "MAX_LISTED", 0)
    async with table() as at_table:
        assert await at_table.said("bodies") == "and 1 more, which can be named"


async def test_only_so_many_names_can_be_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vocabulary, "MAX_CHOICES", 1)
    async with table() as at_table:
        schemas = {each.name: each.input_schema["properties"] for each in (await at_table.host.list_tools()).tools}
        assert schemas["gesture"]["name"]["enum"] == ["nod"]
        await at_table.said("use_body")
        await at_table.said("gesture", name="wave")


async def test_a_document_is_only_so_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(documents, "MAX_DOCUMENT", 100)
    async with table() as at_table:
        with pytest.raises(Exception, match="BadParameter: the document has more than 100 characters"):
            await at_table.document("openrois://profile/robot")


async def test_only_so_many_connections_of_a_caller_listen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(announcements, "MAX_LISTENERS", 1)
    async with memory_gateway(*Actor().parts) as gateway, session_at(gateway.client) as opened:
        handlers = Handlers(Finder(opened))
        async with (
            Host(build_server(lambda: handlers)) as first,
            Host(build_server(lambda: handlers)) as second,
            first.listen(tools_list_changed=True),
        ):
            with pytest.raises(Exception, match="Subscription limit reached"):
                await second.listen(tools_list_changed=True).__aenter__()


async def test_a_request_of_an_agent_is_only_so_long(tmp_path: Path) -> None:
    async with site(tmp_path, http=HTTP) as opened, bearer(agent_token("ann")) as http:
        whole = {**INITIALIZE, "more": "x" * http_server.MAX_BODY}
        assert (await http.post(opened.tools, json=whole, headers=ACCEPT)).status_code == 413


async def test_the_head_of_a_request_of_an_agent_is_only_so_long(tmp_path: Path) -> None:
    async with site(tmp_path, http=HTTP) as opened:
        reader, writer = await asyncio.open_connection(*_place(opened))
        writer.write(b"POST /mcp HTTP/1.1\r\nHost: localhost\r\nX-Long: " + b"x" * (http_server.MAX_HEAD + 1))
        async with asyncio.timeout(PATIENCE):
            assert (await reader.readline()).startswith(b"HTTP/1.1 400 ")
        writer.close()


async def test_only_so_many_sessions_of_the_older_generation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http_server, "MAX_HTTP_SESSIONS", 1)
    async with site(tmp_path, http=HTTP) as opened, bearer(agent_token("ann")) as http:
        assert (await http.post(opened.tools, json=INITIALIZE, headers=ACCEPT)).status_code == 200
        assert (await http.post(opened.tools, json=INITIALIZE, headers=ACCEPT)).status_code == 503


async def test_only_so_many_connections_of_agents(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http_server, "MAX_CONNECTIONS", 2)
    async with site(tmp_path, http=HTTP) as opened, bearer(agent_token("ann")) as http:
        _, writer = await asyncio.open_connection(*_place(opened))
        # It is counted when the server has accepted it, which it does in order.
        answer = await http.post(opened.tools, json=INITIALIZE, headers=ACCEPT)
        assert answer.status_code == 503
        writer.close()
