"""Applications of the soak: each visit connects, works with an arm for a moment, and ends in one of many ways."""

import asyncio
import json
import random
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any, Final

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from benchmarks.soak_gateway.robot import ARMS, ENGINE
from openrois.bench.errors import BenchFailed, within

__all__ = ["Visitors"]

PATIENCE: Final = 20.0
PAUSE: Final = 0.2
"""Seconds between two visits of one visitor, at most."""

WAYS: Final = ("release", "disconnect", "close", "cut", "resume")
ABANDONED: Final = 0.02
"""The share of visits that ask for a resume token and do not use it."""

_MALFORMED: Final = ("{", "[]", '{"jsonrpc":"2.0","id":-1,"method":"no.such"}')


class _Visit:
    """One connection."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self._answers: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._ended: dict[str, asyncio.Future[str]] = {}
        self._number = 0
        self.events = 0

    async def read(self) -> None:
        try:
            while True:
                self._take(json.loads(await self.socket.recv()))
        except ConnectionClosed:
            waiting: tuple[asyncio.Future[Any], ...] = (*self._answers.values(), *self._ended.values())
            for future in waiting:
                future.set_exception(BenchFailed("the connection has ended"))
                future.exception()

    def _take(self, message: dict[str, Any]) -> None:
        params = message.get("params", {})
        if (waiting := self._answers.pop(message.get("id") or 0, None)) is not None and "result" in message:
            waiting.set_result(message["result"])
        elif message.get("method") == "rois.command.completed" and params["command_id"] in self._ended:
            self._ended.pop(params["command_id"]).set_result(params["status"])
        elif message.get("method") == "rois.event.notify_event":
            self.events += 1

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        self._number += 1
        answer = self._answers[self._number] = asyncio.get_running_loop().create_future()
        request = {"jsonrpc": "2.0", "id": self._number, "method": method, "params": params}
        await self.socket.send(json.dumps(request))
        async with within(PATIENCE, method):
            result: dict[str, Any] = await answer
        return result

    async def turn(self, arm: str, times: int) -> None:
        """Turn an arm so often, one after the other, and check each end."""
        for _ in range(times):
            command_id = f"c{self._number}"
            ended = self._ended[command_id] = asyncio.get_running_loop().create_future()
            unit = {"component_ref": arm, "command_type": "turn", "command_id": command_id}
            if (await self.ask("rois.command.execute", command_unit_list=[unit]))["return_code"] != "OK":
                raise BenchFailed(f"{arm} is bound and does not turn")
            async with within(PATIENCE, "the end of a command"):
                if (status := await ended) != "OK":
                    raise BenchFailed(f"a command ended with {status}")


class Visitors:
    """So many at a time, each on its own.

    Attributes:
        visits: how many there were, by how they ended.
        faults: what went wrong, the first few.
    """

    def __init__(self, url: str, count: int, seed: int) -> None:
        self._url = url.replace("http", "ws", 1)
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
        async with self._connected() as visit:
            way = dice.choice(WAYS)
            token = await self._work(visit, arm, dice, resumes=way == "resume")
            if way == "release":
                await visit.ask("rois.command.release", component_ref=arm)
            elif way == "disconnect":
                await visit.ask("rois.system.disconnect")
            elif way in ("cut", "resume"):
                visit.socket.transport.abort()
        if way != "resume":
            return way
        if not token:
            return "cut"
        async with self._connected() as visit:
            answer = await visit.ask("openrois.lease.resume", token=token)
            if answer["return_code"] != "OK":
                raise BenchFailed(f"a token that is good was answered {answer['return_code']}")
            await visit.turn(arm, 1)
        return way

    async def _work(self, visit: _Visit, arm: str, dice: random.Random, *, resumes: bool) -> str:
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
        # An arm whose holder was cut off with a token is nobody's for ten seconds: that happens, but not all the time.
        wanted = resumes or dice.random() < ABANDONED
        token = str((await visit.ask("openrois.lease.token"))["token"]) if wanted else ""
        await visit.turn(arm, dice.randrange(1, 6))
        return token

    @asynccontextmanager
    async def _connected(self) -> AsyncIterator[_Visit]:
        async with connect(self._url, compression=None, proxy=None, open_timeout=PATIENCE) as socket:
            visit = _Visit(socket)
            reading = asyncio.ensure_future(visit.read())
            try:
                await visit.ask("openrois.hello", version="1")
                yield visit
            finally:
                await socket.close()
                await reading
