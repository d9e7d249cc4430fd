"""Application that works beside a flood: queries at a fixed rate, each answered in order."""

import asyncio
import json
import time
from typing import Final

from openrois_bench.errors import BenchFailed, within
from openrois_bench.gateway.deployment import request
from openrois_bench.gateway.gauge import COMPONENT
from openrois_bench.gateway.load import Application

__all__ = ["Bystander"]

PATIENCE: Final = 30.0


class Bystander:
    """Client that asks, and checks that answers are right and in order.

    Attributes:
        waits: seconds from when each question was due to its answer.
        fault: the first answer that was wrong; empty as long as none was.
    """

    def __init__(self, application: Application, rate: float) -> None:
        self._application = application
        self._rate = rate
        self._due: list[float] = []
        self._heard = asyncio.Event()
        self.waits: list[float] = []
        self.fault = ""
        application.on_message = self._check_answer

    async def run(self, running: asyncio.Event) -> None:
        """Ask until the event is set, and wait for what was not answered yet.

        Raises:
            BenchFailed: an answer was wrong, out of order, or did not come.
        """
        began = time.perf_counter()
        while not running.is_set():
            number = len(self._due)
            self._due.append(began + number / self._rate)
            await asyncio.sleep(max(0.0, self._due[-1] - time.perf_counter()))
            condition = f"component_ref = '{COMPONENT}'"
            self._application.send(request(number, "rois.query.query", query_type="level", condition=condition))
        async with within(PATIENCE, "the bystander's answers"):
            while len(self.waits) < len(self._due) and not self.fault:
                self._heard.clear()
                await self._heard.wait()
        if self.fault:
            raise BenchFailed(self.fault)

    def _check_answer(self, text: bytes) -> None:
        answer = json.loads(text)
        number = len(self.waits)
        if answer.get("id") != number or answer.get("result", {}).get("return_code") != "OK":
            self.fault = self.fault or f"instead of answer {number}: {text.decode()[:200]}"
        else:
            self.waits.append(time.perf_counter() - self._due[number])
        self._heard.set()
