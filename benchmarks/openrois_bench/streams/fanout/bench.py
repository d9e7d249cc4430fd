"""`openrois bench fanout`: cost of a further viewer to the sender, beside aiortc alone.

All viewers of all senders are connected before the first run, so that a run is short and its encoders are warm. Those
that do not play cost their sender what an idle session costs.
"""

import asyncio
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import Final

from openrois_bench.measuring.conditions import busy, conditions, load
from openrois_bench.processes.partner import Partner, partner
from openrois_bench.streams.fanout.report import FanoutReport
from openrois_bench.streams.fanout.runs import CODECS, WAYS, Planned, Reading, Run, compare, plan

__all__ = ["FanoutSettings", "run_fanout"]

_SENDER: Final = "openrois_bench.streams.fanout.sender"
_SETTLING: Final = 0.4
"""Seconds that viewers play before it counts: encoders start, and with a key frame."""
_SOON: Final = 20.0
"""Seconds for what takes no time on a machine that is not overloaded."""


@dataclass(frozen=True, slots=True)
class FanoutSettings:
    """Settings of the measurement.

    Attributes:
        seconds: of each run.
        rounds: how often everything runs.
        viewers: the numbers of viewers.
    """

    seconds: float = 1.0
    rounds: int = 3
    viewers: tuple[int, ...] = (1, 2, 4, 8)


async def run_fanout(settings: FanoutSettings, progress: Callable[[str], None]) -> FanoutReport:
    """Measure; `progress` is told what comes next.

    Raises:
        BenchFailed: something did not do what it should.
    """
    before = load()
    async with AsyncExitStack() as stack:
        receivers = await stack.enter_async_context(partner("openrois_bench.streams.fanout.receivers"))
        senders = {
            (way, codec): await stack.enter_async_context(partner(_SENDER, way, codec, "pinned"))
            for way in WAYS
            for codec in CODECS
        }
        bench = _Bench(settings, receivers, senders)
        progress(f"connecting {max(settings.viewers)} viewers to each of {len(senders)} senders")
        for way, codec in senders:
            await bench.connect(way, codec)
        runs: list[Run] = []
        for planned in plan(settings.rounds, settings.viewers):
            if not runs or planned.round != runs[-1].round:
                progress(f"round {planned.round + 1} of {settings.rounds}")
            runs.append(await bench.run(planned))
    return FanoutReport(
        conditions=conditions(before),
        seconds=settings.seconds,
        rounds=settings.rounds,
        comparisons=compare(runs),
        runs=tuple(runs),
    )


class _Bench:
    """All processes that take part."""

    def __init__(
        self, settings: FanoutSettings, receivers: Partner, senders: Mapping[tuple[str, str], Partner]
    ) -> None:
        self._settings = settings
        self._receivers = receivers
        self._senders = senders

    async def connect(self, way: str, codec: str) -> None:
        """Connect to a sender as many receivers as will ever play."""
        sender, name = self._senders[way, codec], {"sender": f"{way} {codec}"}
        for viewer in _names(max(self._settings.viewers)):
            offer = await sender.ask("offer", {"viewer": viewer}, within=_SOON)
            answer = await self._receivers.ask("answer", {**name, "sdp": offer}, within=_SOON)
            await sender.ask("answer", {"viewer": viewer, "sdp": answer}, within=_SOON)
        await self._receivers.ask("connected", name, within=_SOON)

    async def run(self, planned: Planned) -> Run:
        """Let the viewers play, and count."""
        sender, name = self._senders[planned.way, planned.codec], {"sender": f"{planned.way} {planned.codec}"}
        await sender.ask("play", {"viewers": _names(planned.viewers)}, within=_SOON)
        await asyncio.sleep(_SETTLING)
        before = await self._read(sender, name)
        await asyncio.sleep(self._settings.seconds)
        after = await self._read(sender, name)
        await sender.ask("play", {"viewers": []}, within=_SOON)
        return Run.of(planned, before, after)

    async def _read(self, sender: Partner, name: Mapping[str, str]) -> Reading:
        return Reading(
            await sender.ask("read", {}, within=_SOON),
            await self._receivers.ask("read", name, within=_SOON),
            busy(),
        )


def _names(viewers: int) -> list[str]:
    return [f"viewer {number}" for number in range(viewers)]
