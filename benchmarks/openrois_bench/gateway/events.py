"""`openrois bench events`: cost of an event with many subscribers, over one subscription at the adapter."""

import asyncio
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from openrois_bench.errors import within
from openrois_bench.gateway.deployment import Deployment, deployed, request
from openrois_bench.gateway.gauge import COMPONENT
from openrois_bench.gateway.load import Application, applications
from openrois_bench.gateway.security import OPEN, Security
from openrois_bench.measuring.conditions import Conditions, conditions, load
from openrois_bench.measuring.figures import MICROSECONDS, Figures, Percentiles, Throughput
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import own_cpu

__all__ = ["EventsReport", "EventsSettings", "run_events"]

BURST: Final = 32
"""Events that the adapter announces at once; two bursts are under way at a time, so that none is dropped."""

PATIENCE: Final = 20.0
"""Seconds that a burst, or the subscriptions of all, may take."""

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class EventsSettings:
    """Settings of the measurement.

    Attributes:
        rounds: how often everything is measured.
        seconds: of each measurement with many events.
        singles: events of each measurement of one event at a time.
        clients: applications that listen.
        security: how the gateway is protected.
    """

    rounds: int = 5
    seconds: float = 2.0
    singles: int = 100
    clients: int = 50
    security: Security = OPEN


class EventsReport(Figures):
    """Results, as medians of the rounds; times in microseconds."""

    bench: Literal["events"] = "events"
    conditions: Conditions
    clients: int
    rounds: int
    security: str
    many: Throughput
    first: Percentiles
    last: Percentiles

    def __str__(self) -> str:
        many = self.many
        rows = [
            ("to the first of them", self.first),
            ("to the last of them", self.last),
        ]
        return "\n".join(
            (
                str(self.conditions),
                f"{self.clients} applications, {self.security}; medians of {self.rounds} rounds",
                "",
                f"{many.per_second:.0f} deliveries a second; CPU of each: gateway {many.gateway_us:.1f} us, "
                f"adapter {many.adapter_us:.1f} us, load {many.load_us:.1f} us",
                "",
                table(
                    ("one event, from the adapter's component", "p50 us", "p95 us", "p99 us"),
                    [(name, f"{w.p50:.0f}", f"{w.p95:.0f}", f"{w.p99:.0f}") for name, w in rows],
                ),
            )
        )


@dataclass(frozen=True, slots=True)
class _Round:
    many: Throughput
    first: Percentiles
    last: Percentiles


async def run_events(settings: EventsSettings, progress: Progress) -> EventsReport:
    """Measure and return the report.

    Raises:
        BenchFailed: something that is measured did not do what it should.
    """
    before = load()
    rounds: list[_Round] = []
    async with (
        deployed(settings.security) as deployment,
        applications(deployment.door, settings.clients) as listening,
    ):
        audience = _Audience(listening)
        async with within(PATIENCE, "subscribing"):
            await audience.subscribe()
        for number in range(settings.rounds):
            many = await _many(settings, deployment, audience)
            first, last = await _singles(settings, audience)
            rounds.append(_Round(many, first, last))
            progress(f"round {number + 1} of {settings.rounds}: {many.per_second:.0f} deliveries a second")
    return EventsReport(
        conditions=conditions(before),
        clients=settings.clients,
        rounds=settings.rounds,
        security=str(settings.security),
        many=Throughput.median([each.many for each in rounds]),
        first=Percentiles.median([each.first for each in rounds]),
        last=Percentiles.median([each.last for each in rounds]),
    )


class _Audience:
    """Subscribed applications, the first of which triggers the events.

    Attributes:
        deliveries: events that arrived, counted at every application.
        arrivals: where the age of each is noted in seconds, if it is.
    """

    def __init__(self, listening: Sequence[Application]) -> None:
        self._listening = listening
        self._numbers = 0
        self._replies = 0
        self.deliveries = 0
        self.arrivals: list[float] | None = None
        self._awaited = 0
        self._complete = asyncio.Event()
        for application in listening:
            application.on_message = self._on_message

    def _on_message(self, message: bytes) -> None:
        # The first member of a notification after its version is its method; of an answer it is its id.
        if b"notify_event" in message[:60]:
            self.deliveries += 1
            if self.arrivals is not None:
                self.arrivals.append(_age(message))
            if self.deliveries >= self._awaited:
                self._complete.set()
        elif b'"result"' in message:
            self._replies += 1
            self._complete.set()

    async def subscribe(self) -> None:
        """Subscribe all applications."""
        for application in self._listening:
            application.send(
                request(0, "rois.event.subscribe", event_type="measured", condition=f"component_ref = '{COMPONENT}'")
            )
        while self._replies < len(self._listening):
            self._complete.clear()
            await self._complete.wait()

    def announce(self, count: int) -> None:
        """Let the adapter announce events at once."""
        self._numbers += 1
        unit = {
            "component_ref": COMPONENT,
            "command_type": "announce",
            "command_id": str(self._numbers),
            "arguments": [{"name": "count", "data_type_ref": "int", "value": str(count)}],
        }
        self._listening[0].send(request(self._numbers, "rois.command.execute", command_unit_list=[unit]))

    async def wait_for_events(self, events: int) -> None:
        """Wait until all applications have received so many events in all."""
        self._awaited = events * len(self._listening)
        async with within(PATIENCE, f"the delivery of {BURST} events to {len(self._listening)} applications"):
            while self.deliveries < self._awaited:
                self._complete.clear()
                await self._complete.wait()


async def _many(settings: EventsSettings, deployment: Deployment, audience: _Audience) -> Throughput:
    processes = (deployment.gateway, deployment.adapter)
    events = audience.deliveries // settings.clients
    audience.announce(BURST)
    began, before, own, first = time.perf_counter(), [p.cpu() for p in processes], own_cpu(), audience.deliveries
    while time.perf_counter() - began < settings.seconds:
        audience.announce(BURST)
        events += BURST
        await audience.wait_for_events(events)
    await audience.wait_for_events(events + BURST)
    took, after, own_after = time.perf_counter() - began, [p.cpu() for p in processes], own_cpu()
    count = audience.deliveries - first
    gateway, adapter = (b - a for a, b in zip(before, after, strict=True))
    return Throughput.of(count, took, gateway=gateway, adapter=adapter, load=own_after - own)


async def _singles(settings: EventsSettings, audience: _Audience) -> tuple[Percentiles, Percentiles]:
    """Announce one event at a time and note when the first and when the last application has it."""
    firsts: list[float] = []
    lasts: list[float] = []
    for _ in range(settings.singles):
        audience.arrivals = []
        audience.announce(1)
        await audience.wait_for_events(audience.deliveries // settings.clients + 1)
        arrivals, audience.arrivals = audience.arrivals, None
        firsts.append(min(arrivals))
        lasts.append(max(arrivals))
    return Percentiles.of(firsts, MICROSECONDS), Percentiles.of(lasts, MICROSECONDS)


def _age(message: bytes) -> float:
    """Return how many seconds ago the event was announced: all processes of a machine have one monotonic clock."""
    now = time.monotonic_ns()
    results = json.loads(message)["params"]["results"]
    announced = next(result["value"] for result in results if result["name"] == "at")
    return (now - int(announced)) / 1e9
