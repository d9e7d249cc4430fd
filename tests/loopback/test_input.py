"""What a person does, over real WebRTC: from an application's hands to the session that it plays with."""

import asyncio

import pytest
from openrois_streaming.input.reader import Label

pytestmark = [pytest.mark.media, pytest.mark.timeout(30)]


class Ears:
    """Hears what comes over the data channels of a session."""

    def __init__(self) -> None:
        self.came: list[tuple[Label, str | bytes]] = []
        self.lost: list[str] = []
        self.news = asyncio.Event()

    def input_came(self, label: Label, data: str | bytes) -> None:
        self.came.append((label, data))
        self.news.set()

    def input_lost(self, reason: str) -> None:
        self.lost.append(reason)
        self.news.set()

    async def hear(self, count: int) -> None:
        async with asyncio.timeout(10):
            while len(self.came) < count:
                self.news.clear()
                await self.news.wait()
