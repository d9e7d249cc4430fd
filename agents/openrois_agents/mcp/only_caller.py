"""The one caller of a process that serves standard input and output."""

from collections.abc import Callable
from typing import Any

from openrois.client import Client
from openrois_agents.mcp.handlers import Handlers
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings

__all__ = ["OnlyCaller"]


class OnlyCaller:
    """A caller whose session every request belongs to.

    Args:
        make_client: returns a client with the token of this process.
        settings: of the tools.
    """

    def __init__(self, make_client: Callable[[], Client], settings: ToolSettings) -> None:
        self._session = Session(make_client, settings)
        self.handlers = Handlers(self)

    async def find_session(self, _request: Any) -> Session:
        """Return the session."""
        return self._session

    async def leave(self) -> None:
        """Stop what runs, give the body back and take leave of the gateway."""
        await self._session.__aexit__(None, None, None)
