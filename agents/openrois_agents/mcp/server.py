"""The server of the protocol, in all its generations: it greets a host before the tools are loaded."""

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

from mcp.server.lowlevel import Server

from openrois.version import __version__
from openrois_agents.tools.instructions import INSTRUCTIONS

if TYPE_CHECKING:
    from openrois_agents.mcp.handlers import Handlers

__all__ = ["build_server"]


def build_server(load: Callable[[], "Handlers"]) -> Server[Any]:
    """Return a server.

    Args:
        load: returns what handles requests; called with the first that is more than a greeting.
    """

    def later(name: str) -> Callable[[Any, Any], Awaitable[Any]]:
        async def handle(context: Any, params: Any) -> Any:
            return await getattr(load(), name)(context, params)

        return handle

    return Server(
        "openrois",
        version=__version__,
        title="OpenRoIS: bodies for agents",
        instructions=INSTRUCTIONS,
        get_tool_input_schema=lambda name: load().find_schema(name),
        on_list_tools=later("list_tools"),
        on_call_tool=later("call_tool"),
        on_list_resources=later("list_resources"),
        on_list_resource_templates=later("list_resource_templates"),
        on_read_resource=later("read_resource"),
        on_subscribe_resource=later("subscribe"),
        on_unsubscribe_resource=later("unsubscribe"),
        on_subscriptions_listen=later("listen"),
    )
