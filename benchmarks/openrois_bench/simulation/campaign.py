"""The phases of a simulation: one kind of work after the other, then all together, then a long day."""

import asyncio
from collections.abc import Callable, Coroutine, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from openrois_bench.simulation.applications import PIPELINED, Application
from openrois_bench.simulation.bodies import MOVING, Body
from openrois_bench.simulation.books import Books
from openrois_bench.simulation.mix import EVERY, LOST, RESTART_EVERY
from openrois_bench.simulation.phase import Phase
from openrois_bench.simulation.world import Act, World, at_times, spread

__all__ = ["Campaign"]

SAMPLE: Final = 2000
"""Applications that measure one kind of work, at most."""

ENTERING: Final = 100.0
"""Applications that enter in a second."""

ATTACHING: Final = 25.0
"""Bodies that are attached in a second."""

ACTING: Final = 200.0
"""Applications of a sample that begin in a second."""

SUBSCRIBED: Final = 1.0
"""Seconds in which all applications subscribe before they are at work together."""

WATCHED: Final = 10.0
"""Virtual seconds for which events are counted."""

MOVED: Final = 10.0
"""Virtual seconds for which bodies want signs of life."""

BURST_SECONDS: Final = 1.0
"""Virtual seconds in which the last burst is delivered."""

RESTARTED: Final = 20
"""Bodies that restart for a measurement."""

RESTARTING: Final = 10.0
"""Bodies of these that begin to in a second."""

DAY_HOURS: Final = 12.0
"""In so many hours each application visits its body once, and each adapter restarts once."""

WINDOW: Final = 60.0
"""Virtual seconds over which the busiest gateway of the long day is looked for."""


@dataclass(slots=True)
class Campaign:
    """Runs phases in a world.

    Attributes:
        progress: called with each phase that has ended.
        phases: all of them.
        peak: the greatest share of a processor that one gateway took for `WINDOW` seconds of the long day.
    """

    world: World
    books: Books
    progress: Callable[[Phase], None] = lambda _phase: None
    phases: list[Phase] = field(default_factory=list)
    peak: float = 0.0

    async def run(self) -> None:
        """Run all phases."""
        plan, applications = self.world.plan, self.world.applications
        await self._phase("empty", self._rest)
        await self._phase("attach", self._attach)
        await self._phase("enter", lambda: self._all(applications, Application.enter, ENTERING))
        await self._phase("idle", self._rest)
        sample = applications[:SAMPLE]
        # One of each body: those that share a body would wait for each other.
        single = applications[: min(plan.bodies, SAMPLE)]
        shared = max(plan.applications // plan.bodies, 1)
        crowd = [
            application
            for number in range(shared)
            for application in applications[number * plan.bodies :][: max(min(plan.bodies, SAMPLE // shared), 1)]
        ]
        # A gateway that has rested takes twice as long: it is measured at work.
        await self._phase("warm up", lambda: self._all(sample, Application.query))
        await self._phase("query", lambda: self._all(sample, Application.query))
        pipelining = applications[: max(min(len(single), SAMPLE // PIPELINED), 1)]
        # Not faster: where many come at the same time the gateway gives each a small share, and takes them apart.
        apart = ACTING / plan.pace
        await self._phase("query together", lambda: self._all(pipelining, Application.query_together, apart))
        await self._phase("command", lambda: self._all(single, lambda each: each.command("speech_synthesizer")))
        await self._phase("subscription", lambda: self._all(sample, Application.listen_in_vain))
        await self._phase("move", self._move)
        await self._watch("to one", single)
        await self._watch("to many", crowd)
        await self._burst("to one", single)
        await self._burst("to many", crowd)
        await self._phase("stream", lambda: self._all(single, lambda each: each.stream(1.0)))
        await self._phase("return", lambda: self._all(sample, Application.come_back))
        await self._phase("restart", lambda: self._again(Body.restart))
        await self._phase("loss", lambda: self._again(self._lose))
        if plan.rush:
            at_once = len(applications) / SUBSCRIBED / plan.pace
            await self._phase("subscribe all", lambda: self._all(applications, Application.subscribe, at_once))
            ending = self._rush()
            # What has begun ends behind the rush, without its events: only its own seconds count.
            await self._phase("rush", lambda: asyncio.sleep(plan.rush))
            await self._phase("unsubscribe all", lambda: self._all(applications, Application.unsubscribe, at_once))
            await ending
        if plan.hours:
            await self._phase("day", self._day)
        # Before the bodies: a gateway asks all sessions that are left whether a lost body concerns them.
        await self._phase("leave", lambda: self._all(applications, Application.leave, ENTERING))

    async def _phase(self, name: str, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        world, loop = self.world, asyncio.get_running_loop()
        counts, began, spent = world.counts.copy(), loop.time(), self.books.open()
        await work()
        happened = {each: count - counts[each] for each, count in sorted(world.counts.items()) if count > counts[each]}
        phase = Phase(name, loop.time() - began, happened, spent(), self.books.resident())
        self.phases.append(phase)
        self.progress(phase)

    async def _all(
        self,
        applications: Iterable[Application],
        act: Callable[[Application], Coroutine[Any, Any, None]],
        each_second: float = ACTING,
    ) -> None:
        acts = [partial(_attempt, each, act) for each in applications]
        await spread(acts, len(acts) / each_second / self.world.plan.pace)

    async def _rest(self) -> None:
        await asyncio.sleep(10)

    async def _attach(self) -> None:
        async def attach(body: Body) -> None:
            self.world.tasks.start(body.run())
            await body.attached.wait()

        bodies = self.world.bodies
        await spread([partial(attach, body) for body in bodies], len(bodies) / ATTACHING / self.world.plan.pace)

    async def _move(self) -> None:
        moving = self.world.bodies[:SAMPLE]
        await spread([partial(body.move, MOVED) for body in moving], len(moving) / ACTING)

    async def _watch(self, name: str, applications: list[Application]) -> None:
        await self._phase(f"subscribe {name}", lambda: self._all(applications, Application.subscribe))
        await self._phase(f"events {name}", lambda: asyncio.sleep(WATCHED))
        await self._phase(f"unsubscribe {name}", lambda: self._all(applications, Application.unsubscribe))

    async def _burst(self, name: str, applications: list[Application]) -> None:
        bodies = list(dict.fromkeys(application.body for application in applications))

        async def burst() -> None:
            await spread([body.burst for body in bodies], len(bodies) / ACTING)
            await asyncio.sleep(BURST_SECONDS)

        await self._phase(f"subscribe bursts {name}", lambda: self._all(applications, Application.subscribe_to_bursts))
        await self._phase(f"bursts {name}", burst)
        await self._phase(f"unsubscribe bursts {name}", lambda: self._all(applications, Application.unsubscribe))

    async def _again(self, act: Callable[[Body], Coroutine[Any, Any, None]]) -> None:
        bodies = self.world.bodies[:RESTARTED]
        await spread([partial(act, body) for body in bodies], len(bodies) / RESTARTING / self.world.plan.pace)

    async def _lose(self, body: Body) -> None:
        """Lose a body; each session at its gateway is asked once whether that concerns it."""
        sessions = sum(each.body.gateway is body.gateway for each in self.world.applications)
        self.world.counts["fault checks"] += sessions
        await body.be_lost()

    def _end_of(self, body: Body) -> Act:
        return partial(self._lose, body) if self.world.chance.random() < LOST else body.restart

    def _rush(self) -> asyncio.Task[None]:
        """Have every application receive events, and do at random times what it does now and then."""
        world, seconds = self.world, self.world.plan.rush
        acts: list[tuple[float, Act]] = []
        for name, every in EVERY.items():
            for _ in range(round(len(world.applications) * seconds / every)):
                application = world.chance.choice(world.applications)
                acts.append((world.chance.uniform(0, seconds), partial(_attempt, application, _ACTS[name])))
        for _ in range(round(len(world.bodies) * seconds / RESTART_EVERY)):
            acts.append((world.chance.uniform(0, seconds), self._end_of(world.chance.choice(world.bodies))))
        return world.tasks.start(at_times(sorted(acts, key=lambda each: each[0])))

    async def _day(self) -> None:
        """Let hours pass, in which applications visit their bodies, leave, come back, and adapters restart."""
        world, seconds = self.world, self.world.plan.hours * 3600
        share = world.plan.hours / DAY_HOURS
        acts: list[tuple[float, Act]] = [(seconds, partial(asyncio.sleep, 0))]
        for application in world.chance.sample(world.applications, round(len(world.applications) * share)):
            begins = world.chance.uniform(0, seconds - world.plan.visit)
            more = world.chance.choices(_MORE, _WEIGHTS)[0]
            acts.append((begins, partial(_visit, application, world.plan.visit, more)))
        for body in world.chance.sample(world.bodies, round(len(world.bodies) * share)):
            acts.append((world.chance.uniform(0, seconds), self._end_of(body)))
        watching = world.tasks.start(self._find_peak())
        await at_times(sorted(acts, key=lambda each: each[0]))
        watching.cancel()

    async def _find_peak(self) -> None:
        while True:
            spent = self.books.open()
            await asyncio.sleep(WINDOW)
            self.peak = max(self.peak, max(spent().gateways) / WINDOW)


_ACTS: Final[dict[str, Callable[[Application], Coroutine[Any, Any, None]]]] = {
    "query": Application.query,
    "command": lambda application: application.command(MOVING),
    "stream": lambda application: application.stream(5.0),
    "return": Application.come_back,
}

_MORE: Final = (*_ACTS.values(), None)
_WEIGHTS: Final = (2, 4, 4, 1, 9)
"""How often a visit has one of these, or nothing more."""


async def _attempt(application: Application, act: Callable[[Application], Coroutine[Any, Any, None]]) -> None:
    await application.attempt(act(application))


async def _visit(
    application: Application, seconds: float, more: Callable[[Application], Coroutine[Any, Any, None]] | None
) -> None:
    """Receive events for a while, ask something, and do one thing more."""
    acts = [application.watch(seconds), application.query()]
    await application.attempt(*acts, *(() if more is None else (more(application),)))
