"""A stage without a body for minds in tests: it notes what is said and used, and lets a test say what is heard."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from openrois_agents.mind.contract import Allowed
from openrois_agents.tools.answer import Answer
from openrois_agents.tools.names import Vocabulary

__all__ = ["NotedStage"]

NAMES = Vocabulary(bodies=("robot",), gestures=("bow", "wave"), places=("door", "plant"))


class NotedStage:
    """Hears each sentence at once, unless a test holds it.

    Args:
        answers: what each tool answers; `done` unless it is here.

    Attributes:
        said: the sentences.
        used: the tools that were used, with their arguments.
        running: how many tools run now, and how many have run at a time.
        goes_on: is cleared by a test that holds what is said.
        may_go: what visitors let a model have.
    """

    def __init__(self, answers: Mapping[str, Answer | Callable[[], Any]] | None = None) -> None:
        self.said: list[str] = []
        self.used: list[tuple[str, Mapping[str, Any]]] = []
        self.running = [0, 0]
        self.goes_on = asyncio.Event()
        self.goes_on.set()
        self.names: Vocabulary | Exception = NAMES
        self.may_go = Allowed(words=True, pictures=True)
        self._answers = answers or {}
        self._news = asyncio.Condition()

    async def say(self, text: str) -> None:
        self.said.append(text)
        await self._note()

    async def use(self, tool: str, arguments: Mapping[str, Any]) -> Answer:
        self.used.append((tool, arguments))
        self.running[0] += 1
        self.running[1] = max(self.running)
        await self._note()
        try:
            answer = self._answers.get(tool, Answer("done"))
            return answer if isinstance(answer, Answer) else await answer()
        finally:
            self.running[0] -= 1

    async def all_said(self) -> None:
        await self.goes_on.wait()

    @property
    def heard(self) -> str:
        return " ".join(self.said)

    async def vocabulary(self) -> Vocabulary:
        if isinstance(self.names, Exception):
            raise self.names
        return self.names

    async def allowed(self) -> Allowed:
        return self.may_go

    async def _note(self) -> None:
        async with self._news:
            self._news.notify_all()

    async def until(self, so: Callable[[], bool]) -> None:
        async with asyncio.timeout(30), self._news:
            await self._news.wait_for(so)
