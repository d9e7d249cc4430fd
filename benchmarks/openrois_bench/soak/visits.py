"""Applications of the soak: each visit connects, works with an arm for a moment, and ends in one of many ways."""

import asyncio
import random
from collections import Counter
from typing import Final

from websockets.exceptions import ConnectionClosed

from openrois_bench.errors import BenchFailed
from openrois_bench.soak.connection import Connection, connected
from openrois_bench.soak.robot import ARMS, ENGINE

__all__ = ["Visitors"]

PAUSE: Final = 0.2
"""Seconds between two visits of one visitor, at most."""

WAYS: Final = ("release", "disconnect", "close", "cut", "resume")
ABANDONED: Final = 0.02
"""The share of visits that ask for a resume token and do not use it."""

_MALFORMED: Final = ("{", "[]", '{"jsonrpc":"2.0","id":-1,"method":"no.such"}')


class Visitors:
    """So many at a time, each on its own.

    Attributes:
        visits: how many there were, by how they ended.
        faults: what went wrong, the first few.
    """

    def __init__(self, url: str, count: int, seed: int) -> None:
        self._url = url
        self._dices = [random.Random(seed + number) for number in range(count)]
        self.visits: Counter[str] = Counter()
        self.faults: list[str] = []

    async def run(self, over: asyncio.Event) -> None:
        """Come and go until the event is set."""
        async with asyncio.TaskGroup() as visitors:
            for dice in self._dices:
                visitors.create_task(self._come_and_go(dice, over))

    async def _come_and_go(self, dice: random.Random, over: asyncio.Event) -> None:
        while not over.is_set():
            try:
                self.visits[await self._visit(dice)] += 1
            except (BenchFailed, OSError, ConnectionClosed) as error:
                self.visits["failed"] += 1
                self.faults += [repr(error)][: 10 - len(self.faults)]
            await asyncio.sleep(dice.uniform(0, PAUSE))

    async def _visit(self, dice: random.Random) -> str:
        arm = f"{ENGINE}/arm{dice.randrange(ARMS)}"
        async with connected(self._url) as visit:
            await visit.ask("openrois.hello", version="1")
            way = dice.choice(WAYS)
            token = await self._work(visit, arm, dice, resumes=way == "resume")
            if way == "release":
                await visit.ask("rois.command.release", component_ref=arm)
            elif way == "disconnect":
                await visit.ask("rois.system.disconnect")
            elif way in ("cut", "resume"):
                visit.cut()
        if way != "resume":
            return way
        if not token:
            return "cut"
        async with connected(self._url) as visit:
            await visit.ask("openrois.hello", version="1")
            answer = await visit.ask("openrois.lease.resume", token=token)
            if answer["return_code"] != "OK":
                raise BenchFailed(f"a token that is good was answered {answer['return_code']}")
            await visit.turn(arm, 1)
        return way

    async def _work(self, visit: Connection, arm: str, dice: random.Random, *, resumes: bool) -> str:
        """Do what applications do; return a resume token, if one is wanted and the arm was free."""
        await visit.ask("rois.system.get_profile")
        condition = f"component_ref = '{arm}'"
        await visit.ask("rois.event.subscribe", event_type="turned", condition=condition)
        for _ in range(dice.randrange(5)):
            await visit.ask("rois.query.query", query_type="angle", condition=condition)
        if dice.random() < 0.2:
            await visit.socket.send(dice.choice(_MALFORMED))
        if (await visit.ask("rois.command.bind", component_ref=arm))["return_code"] != "OK":
            return ""
        # An arm whose holder was cut off with a token stays leased for ten seconds: that happens now and then.
        wanted = resumes or dice.random() < ABANDONED
        token = str((await visit.ask("openrois.lease.token"))["token"]) if wanted else ""
        await visit.turn(arm, dice.randrange(1, 6))
        return token
