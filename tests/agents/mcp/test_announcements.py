"""A host is told what has changed, in both generations of the protocol."""

import asyncio
from typing import Any

import pytest
from mcp.client.client import Client as Host
from mcp.client.subscriptions import ResourcesListChanged, ResourceUpdated, ToolsListChanged
from openrois_agents.mcp.handlers import Handlers
from openrois_agents.mcp.server import build_server

from openrois.testing import memory_gateway
from tests.support.actors import Actor
from tests.support.mcp_hosts import PATIENCE, Finder, session_at

pytestmark = pytest.mark.extra(name="mcp")


@pytest.mark.filterwarnings("ignore:resources/")
async def test_the_older_generation_is_notified() -> None:
    told: asyncio.Queue[str] = asyncio.Queue(64)

    async def note(message: Any) -> None:
        told.put_nowait(getattr(message, "method", type(message).__name__))

    actor = Actor()
    async with memory_gateway(*actor.parts) as gateway, session_at(gateway.client) as session:
        handlers = Handlers(Finder(session))
        async with Host(build_server(lambda: handlers), mode="legacy", message_handler=note) as host:
            await host.list_tools()
            await host.list_tools()
            await host.subscribe_resource("openrois://events")
            await host.call_tool("use_body", {})
            async with asyncio.timeout(PATIENCE):
                assert await told.get() == "notifications/resources/updated"
            session.profile_changed.notify_all()
            async with asyncio.timeout(PATIENCE):
                assert await told.get() == "notifications/tools/list_changed"
                assert await told.get() == "notifications/resources/list_changed"
            await host.unsubscribe_resource("openrois://events")
            session.log.add("heard", "robot/hearing", {})
            session.profile_changed.notify_all()
            async with asyncio.timeout(PATIENCE):
                assert await told.get() == "notifications/tools/list_changed"


async def test_the_newer_generation_listens() -> None:
    actor = Actor()
    async with memory_gateway(*actor.parts) as gateway, session_at(gateway.client) as session:
        handlers = Handlers(Finder(session))
        async with (
            Host(build_server(lambda: handlers)) as host,
            host.listen(
                tools_list_changed=True, resources_list_changed=True, resource_subscriptions=["openrois://events"]
            ) as changes,
            asyncio.timeout(PATIENCE),
        ):
            await host.call_tool("use_body", {})
            assert await anext(changes) == ResourceUpdated(uri="openrois://events")
            session.profile_changed.notify_all()
            assert await anext(changes) == ToolsListChanged()
            assert await anext(changes) == ResourcesListChanged()
