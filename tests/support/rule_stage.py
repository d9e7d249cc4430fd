"""A mind's body in tests: the real tools of a session, and the sentences in the order in which they were said."""

import asyncio
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any

from openrois_agents.mind.contract import Allowed, Turn
from openrois_agents.mind.rules import RuleMind
from openrois_agents.tools.answer import Answer
from openrois_agents.tools.failures import failure
from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings
from openrois_agents.tools.toolbox import call_tool

from openrois.component.component import Component
from openrois.testing import memory_gateway

__all__ = ["RuleStage", "rule_stage"]


class RuleStage:
    """A `Stage` whose sentences are heard at once."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.said: list[str] = []
        self.used: list[str] = []
        self.heard = ""

    async def say(self, text: str) -> None:
        self.said.append(text)

    async def use(self, tool: str, arguments: Mapping[str, Any]) -> Answer:
        self.used.append(tool)
        try:
            return await call_tool(self.session, tool, arguments, _no_progress)
        except Exception as error:
            kind, text = failure(tool, error)
            return Answer(text, {"failed": kind})

    async def all_said(self) -> None:
        self.used.append("all_said")

    async def vocabulary(self) -> Vocabulary:
        return await self.session.vocabulary()

    async def allowed(self) -> Allowed:
        return Allowed(words=True, pictures=True)

    async def answer(self, mind: RuleMind, text: str) -> list[str]:
        """Return what a mind says to a text."""
        before = len(self.said)
        async with asyncio.timeout(30):
            await mind.answer(Turn(text, "", 1), self)
        return self.said[before:]


async def _no_progress(_seconds: float, _what: str) -> None:
    """Report to no host."""


@asynccontextmanager
async def rule_stage(*parts: Component, tools: tuple[str, ...] | None = None) -> AsyncIterator[RuleStage]:
    """Hold a body of these components behind a gateway in memory."""
    async with memory_gateway(*parts) as gateway, Session(gateway.client, ToolSettings()) as session:
        await session.use_body(None, tools, 0)
        yield RuleStage(session)
