"""Sends wrong messages over a few connections and checks every answer; a process of its own where times are measured.

`python -m openrois_bench.gateway.malformed.flood URL COUNT RATE SEED`; it prints what it found as one line of JSON.
"""

import asyncio
import json
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, Final

from openrois_bench.errors import within
from openrois_bench.gateway.load import Application, Door, applications
from openrois_bench.gateway.malformed.messages import Malformed, malformed

__all__ = ["CONNECTIONS", "Found", "flood"]

CONNECTIONS: Final = 4
WINDOW: Final = 32
"""Messages of one connection that are unanswered at a time."""

PATIENCE: Final = 60.0
"""Seconds for one answer."""

_END: Final = "the last question"


@dataclass
class Found:
    """Answers to the wrong messages.

    Attributes:
        sent: messages.
        by_code: right answers, by their code.
        wrong: answers to no open request, or with another code; those after the first few are left out.
        missing: messages without an answer.
    """

    sent: int = 0
    by_code: Counter[int] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)
    missing: int = 0

    @property
    def right(self) -> bool:
        """Whether each message got its one right error."""
        return not self.wrong and not self.missing and self.by_code.total() == self.sent


class _Sending:
    """One connection: what it has sent and not heard of."""

    def __init__(self, application: Application, found: Found) -> None:
        self._application = application
        self._found = found
        self._room = asyncio.Semaphore(WINDOW)
        self._expected: dict[tuple[type, int | str], int] = {}
        self._nameless: Counter[int] = Counter()
        self._ended = asyncio.Event()
        application.on_message = self._check_answer

    async def run(self, messages: Iterator[Malformed], rate: float) -> None:
        """Send all of them, `rate` a second or, if that is zero, as fast as they are answered."""
        clock = asyncio.get_running_loop().time
        due = clock()
        for message in messages:
            async with within(PATIENCE, "an answer"):
                await self._room.acquire()
            if rate:
                due += 1 / rate
                await asyncio.sleep(max(0.0, due - clock()))
            self._send(message)
        async with within(PATIENCE, "the last answers"):
            for _ in range(WINDOW):
                await self._room.acquire()
            # Whatever would be answered twice has been by now.
            last = {"jsonrpc": "2.0", "id": _END, "method": "rois.system.connect", "params": {}}
            self._application.send(json.dumps(last).encode())
            await self._ended.wait()
        self._found.missing += len(self._expected) + sum(max(0, left) for left in self._nameless.values())

    def _send(self, message: Malformed) -> None:
        self._found.sent += 1
        if message.answered_as is None:
            self._nameless[message.code] += 1
        else:
            self._expected[(type(message.answered_as), message.answered_as)] = message.code
        self._application.send(message.text.encode())

    def _check_answer(self, text: bytes) -> None:
        answer = json.loads(text)
        if answer.get("id") == _END and answer.get("result") == {"return_code": "OK"}:
            self._ended.set()
        elif "id" in answer:
            if self._is_right(answer):
                self._found.by_code[answer["error"]["code"]] += 1
            elif len(self._found.wrong) < 10:
                self._found.wrong.append(text.decode()[:300])
            self._room.release()

    def _is_right(self, answer: dict[str, Any]) -> bool:
        error = answer.get("error") or {}
        if set(answer) != {"jsonrpc", "id", "error"} or not {"code", "message"} <= set(error):
            return False
        code: int = error["code"]
        if answer["id"] is None:
            self._nameless[code] -= 1
            return self._nameless[code] >= 0
        return self._expected.pop((type(answer["id"]), answer["id"]), None) == code


async def flood(door: Door, count: int, rate: float, seed: int) -> Found:
    """Send `count` wrong messages, and return what was answered.

    Raises:
        BenchFailed: an answer did not come.
    """
    found = Found()
    async with applications(door, CONNECTIONS) as opened, asyncio.TaskGroup() as sending:
        for number, application in enumerate(opened):
            share = count // CONNECTIONS + (number < count % CONNECTIONS)
            messages = islice(malformed(seed * CONNECTIONS + number), share)
            sending.create_task(_Sending(application, found).run(messages, rate / CONNECTIONS))
    return found


if __name__ == "__main__":
    print("ready", flush=True)
    result = asyncio.run(flood(Door(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4])))
    print(json.dumps(vars(result)), flush=True)
