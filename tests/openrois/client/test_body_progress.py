"""Twenty applications compete for three bodies while they are cancelled, cut off, crash, and engines come and go.

Nothing is half held once that has settled, and all get on. The event loop's clock jumps from timer to timer.
"""

import asyncio
import random
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any, Final, cast

import pytest

from openrois.aio.tasks import TaskScope
from openrois.client import Body, Client, ConnectionFailed, ConnectionLost, Reconnect, RoISError
from openrois.client.components import Follow, Move, Navigation, Reaction, SpeechSynthesis
from openrois.component.component import Component
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.applications import serve_application
from openrois.leases.keeper import LeaseKeeper
from openrois.leases.model import GRACE, Rules
from openrois.session.session import EngineHost
from openrois.transport.memory import MemoryStream, memory_pair
from openrois.transport.stream import MessageStream
from tests.support.fleet import Part
from tests.support.grounds import serve_plain
from tests.support.jumping_loop import JumpingLoop
from tests.support.seeds import lasting

pytestmark = pytest.mark.extra(name="base")

APPLICATIONS: Final = 20
KINDS: Final = (Navigation, SpeechSynthesis, Reaction, Move, Follow)
HELD_FOR: Final = 1.0
"""Seconds for which an application holds a body, at most."""

SETTLED: Final = GRACE + 20
"""Seconds after which a lost connection is made again, or its leases have ended, and every attempt is over."""

IN_TIME: Final = 60.0
"""Seconds in which each of twenty gets a body of three: three times what they need one after the other."""

Serve = Callable[[EngineHost, MessageStream], Any]


class Application:
    """An application that reserves a body again and again, and is started again when it has crashed.

    Attributes:
        body: what it has reserved now.
        had: how many bodies it had.
        calm: whether it meets no trouble, and tries until it has what it wants.
    """

    def __init__(self, world: "World", seed: str) -> None:
        self.body: Body | None = None
        self.had = 0
        self.calm = False
        self._chance = random.Random(seed)
        self._world = world
        self._ends: list[MemoryStream] = []
        self._unreachable = False
        self._working: asyncio.Task[None] | None = None
        self._using: asyncio.Task[None] | None = None

    @asynccontextmanager
    async def _dial(self) -> AsyncIterator[MessageStream]:
        if self._unreachable:
            raise OSError("there is no network")
        near, far = memory_pair()
        self._ends.append(far)
        self._world.tasks.start(self._world.serve(self._world.host, far))
        try:
            yield near
        finally:
            near.abort()

    # What happens to it.

    def lose_connection(self) -> None:
        while self._ends:
            self._ends.pop().abort()

    def crash(self) -> None:
        """End without a word to the gateway."""
        self._unreachable = True
        self.lose_connection()
        self.leave()

    def leave(self) -> None:
        """End, and disconnect from the gateway."""
        if self._working is not None:
            self._working.cancel()

    def give_up(self) -> None:
        """Cancel the reserving, or the work with the body, and stay connected."""
        if self._using is not None:
            self._using.cancel()

    # What it does.

    async def live(self) -> None:
        while True:
            await self._world.going_on.wait()
            self._unreachable = False
            self._working = asyncio.ensure_future(self._work())
            await _ended(self._working)
            await asyncio.sleep(self._chance.uniform(0, 1))

    async def _work(self) -> None:
        reconnect = Reconnect(random=self._chance.random, clock=asyncio.get_running_loop().time)
        async with Client(dial=self._dial, reconnect=reconnect) as client:
            while True:
                await asyncio.sleep(self._chance.uniform(0, 1))
                await self._world.going_on.wait()
                self._using = asyncio.ensure_future(self._use(client))
                await _ended(self._using)

    async def _use(self, client: Client) -> None:
        """Reserve a body, hold it for a while, or for as long as all pause, and give it back."""
        kinds = self._chance.sample(KINDS, 4)
        required = self._chance.randint(1, 3)
        wait = IN_TIME if self.calm else self._chance.choice((0, 1, 10))
        try:
            async with client.body(*kinds[:required], optional=kinds[required:], wait=wait) as self.body:
                self.had += 1
                await asyncio.sleep(self._chance.uniform(0, HELD_FOR))
                if self._chance.random() < 0.5:
                    await self._world.going_on.wait()
        finally:
            self.body = None


async def _ended(task: asyncio.Task[None]) -> None:
    """Wait for the end of a task, which is cancelled with the caller; refusals and lost connections may end it."""
    try:
        await asyncio.wait({task})
    finally:
        task.cancel()
    if not task.cancelled() and (error := task.exception()) is not None:
        assert isinstance(error, RoISError | ConnectionFailed | ConnectionLost), error


def _robot(engine_id: str) -> LocalRegistry:
    """Return an engine of the components that the applications want."""
    # A registry asks for nothing but the run-time face of a component.
    return LocalRegistry(engine_id, [cast(Component, Part(kind.component_type)) for kind in KINDS])


class World:
    """A gateway, three bodies, and twenty applications."""

    def __init__(self, host: EngineHost, tasks: TaskScope, serve: Serve, seed: int) -> None:
        self.host = host
        self.tasks = tasks
        self.serve = serve
        self.going_on = asyncio.Event()
        self.robots = [_robot(name) for name in ("avatar", "kachaka", "reachy")]
        self.applications = [Application(self, f"{seed} {number}") for number in range(APPLICATIONS)]
        self._chance = random.Random(seed)

    async def begin(self) -> None:
        for robot in self.robots:
            await self.host.engine.attach(robot)
        for each in self.applications:
            self.tasks.start(each.live())
        self.going_on.set()

    async def trouble(self, seconds: float) -> None:
        """Let happen for a while what can happen, between messages and in the midst of them."""
        now = asyncio.get_running_loop().time
        end = now() + seconds
        # Not more often: what a session is told of changes is bounded by real time.
        engine_leaves = now() + self._chance.uniform(0, seconds)
        while now() < end:
            await asyncio.sleep(self._chance.uniform(0, 0.3))
            for _ in range(self._chance.randrange(40)):
                await asyncio.sleep(0)
            one = self._chance.choice(self.applications)
            self._chance.choice((one.lose_connection, one.crash, one.leave, one.give_up, one.give_up))()
            if now() > engine_leaves:
                engine_leaves = end
                await self._lose_engine(self._chance.choice(self.robots))

    async def _lose_engine(self, robot: LocalRegistry) -> None:
        # As the gateway does where an adapter leaves.
        self.host.leases.end_all(self.host.engine.detach(robot))
        await asyncio.sleep(self._chance.uniform(0, 2))
        await self.host.engine.attach(robot)

    async def settle(self) -> int:
        """Let all pause, some of them with a body; return how many these are.

        What is held at the gateway has to be these bodies, each by one session, and nothing else.
        """
        self.going_on.clear()
        await asyncio.sleep(SETTLED)
        holding = self.host.leases.model.holding
        bodies = [body for each in self.applications if (body := each.body) is not None and body.error is None]
        owned: list[str] = []
        for body in bodies:
            refs = [component.component_ref for kind in KINDS if (component := body.get(kind)) is not None]
            assert {ref.partition("/")[0] for ref in refs} == {body.engine_id}
            assert len({id(held[0]) for ref in refs if (held := holding.holder(ref)) is not None}) == 1
            owned += refs
        assert sorted(owned) == sorted(holding.held())
        self.going_on.set()
        return len(bodies)


@asynccontextmanager
async def world(serve: Serve, seed: int) -> AsyncIterator[World]:
    async with AsyncExitStack() as stack:
        commands = await stack.enter_async_context(TaskScope())
        host = EngineHost(Engine("gateway"), commands)
        host.leases = LeaseKeeper(
            host.engine, commands, host.pending, rules=Rules(GRACE), clock=asyncio.get_running_loop().time
        )
        there = World(host, await stack.enter_async_context(TaskScope()), serve, seed)
        await there.begin()
        yield there


async def twenty_applications(serve: Serve, seed: int, seconds: float) -> None:
    async with world(serve, seed) as there:
        settled = 0
        for _ in range(2):
            await there.trouble(seconds)
            settled += await there.settle()
        assert settled > 0
        for each in there.applications:
            each.calm, each.had = True, 0
        await asyncio.sleep(IN_TIME)
        assert all(each.had > 0 for each in there.applications)
        await there.settle()


@pytest.mark.parametrize("seconds", [1.0, pytest.param(20.0, marks=pytest.mark.long)])
@pytest.mark.parametrize("seed", lasting(0))
def test_no_body_is_half_held_and_all_get_on(seed: int, seconds: float) -> None:
    # With leases that survive a lost connection, and at a gateway of the base wire alone.
    serve = (serve_application, serve_plain)[seed % 2]
    with asyncio.Runner(loop_factory=JumpingLoop) as runner:
        runner.run(twenty_applications(serve, seed, seconds))
