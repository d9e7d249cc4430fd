"""A caller's session: its connection, the body that it holds, and what happened around that."""

import asyncio
import re
import time
from collections.abc import AsyncIterator, Callable, Coroutine, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from types import TracebackType
from typing import Any, Final, Self

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois.client import BadParameter, BodyInfo, Client, OutOfResources, Unsupported
from openrois_agents.tools.abilities import ABILITIES
from openrois_agents.tools.consents import Consents
from openrois_agents.tools.event_log import EventLog
from openrois_agents.tools.gateway_link import GatewayLink
from openrois_agents.tools.held_body import HeldBody
from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.permits import Permits
from openrois_agents.tools.running import Runner
from openrois_agents.tools.settings import ToolSettings
from openrois_agents.tools.vocabulary import VocabularyReader
from openrois_agents.tools.watching import Watching

__all__ = ["Session"]

MAX_CALLS: Final = 16
"""Calls of one caller that may run at a time."""

MAX_ASKED: Final = 16
"""Bodies whose visitors' consent is remembered."""

_NAMES: Final = 4.0
"""Seconds that reading names may take; a list of tools goes without them then."""


class Session:
    """One caller of the tools, for as long as the block runs. It holds one body at a time, for a task of many calls.

    Args:
        make_client: returns a client with the caller's own token.
        settings: of the tools.
        clock: monotonic seconds.

    Attributes:
        settings, clock: as above.
        link: its connection to the gateway.
        log: its events.
        watching: fills the log.
        profile_changed: told when bodies or their components came or went.
    """

    def __init__(
        self,
        make_client: Callable[[], Client],
        settings: ToolSettings,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.settings = settings
        self.link = GatewayLink(make_client)
        self.log = EventLog()
        self.profile_changed: Listeners[()] = Listeners()
        self.clock = clock
        self._tasks = TaskScope()
        self.watching = Watching(self.log, self.profile_changed.notify_all)
        self.link.connected.add(self.watching.follow_notices)
        self._vocabulary = VocabularyReader(clock)
        self._consents: dict[tuple[object, ...], Consents] = {}
        self._changing = asyncio.Lock()
        self._reserving: asyncio.Task[Any] | None = None
        self._releasing: asyncio.Task[None] | None = None
        self._held: HeldBody | None = None
        self._why_not_held = ""
        self._calls = 0
        self._last_call = clock()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop what runs, give the body back and take leave of the gateway."""
        if self._reserving is not None:
            self._reserving.cancel()
        await self.give_back("the session is over")
        if self._releasing is not None:
            await asyncio.wait({self._releasing})
        await self.watching.close()
        await self._tasks.__aexit__(kind, error, trace)
        await self.link.__aexit__(kind, error, trace)

    def start(self, work: Coroutine[Any, Any, None]) -> None:
        """Run work for as long as the session lasts at most."""
        self._tasks.start(work)

    @property
    def held(self) -> HeldBody | None:
        """The body that it holds now."""
        return self._held

    @property
    def idle(self) -> float:
        """Seconds since the last call ended; 0 while one runs."""
        return 0.0 if self._calls else self.clock() - self._last_call

    @asynccontextmanager
    async def call(self, *, passes: bool = False) -> AsyncIterator[None]:
        """Count a call while the block runs: the session is not idle meanwhile.

        Args:
            passes: run it, however many there are.

        Raises:
            OutOfResources: too many run already.
        """
        if self._calls >= MAX_CALLS and not passes:
            raise OutOfResources(f"{MAX_CALLS} calls run already: wait for one of them, or cancel it")
        self._calls += 1
        try:
            yield
        finally:
            self._calls -= 1
            self._last_call = self.clock()

    def require_body(self) -> HeldBody:
        """Return the body that is held.

        Raises:
            OutOfResources: there is none, or it was lost.
        """
        if self._held is None:
            why = f"{self._why_not_held}: " if self._why_not_held else ""
            raise OutOfResources(f"{why}no body is held: call use_body first")
        self._held.require_held()
        return self._held

    async def use_body(self, body: str | None, tools: Sequence[str] | None, wait: float) -> HeldBody:
        """Reserve a body for a task.

        Args:
            body: which; whichever is free unless given.
            tools: what the task may use and the body must have; what is usual unless given.
            wait: seconds for which it is tried.

        Raises:
            BadParameter: there is no such body.
            OutOfResources: a body is held already, or all are taken.
            Unsupported: no body has what is needed, or a tool is withheld from all tasks.
        """
        async with self._changing:
            if self._held is not None:
                if self._held.body.error is None:
                    raise OutOfResources(f"this task holds {self._held.engine_id} already: give_back comes first")
                await self._give_back(f"{self._held.engine_id} was lost")
            wanted = self._wanted(tools)
            if body is not None:
                await self.body_info(body)
            self._reserving = asyncio.current_task()
            try:
                held = await self._reserve(body, wanted, all_of_them=tools is not None, wait=wait)
            finally:
                self._reserving = None
            self._held, self._why_not_held = held, ""
            self.log.add("body_reserved", held.engine_id, {"tools": held.tools})
            self._tasks.start(self._watch_idle(held))
            return held

    async def _reserve(self, body: str | None, tools: frozenset[str], *, all_of_them: bool, wait: float) -> HeldBody:
        """Reserve a body with components for all tools, or for the first one and those that it has and are free."""
        client = await self.link.client()
        urns = [ability.urn for tool, ability in ABILITIES.items() if tool in tools]
        needed = len(urns) if all_of_them else 1
        condition = "" if body is None else f"component_ref LIKE '{_pattern(body)}/%'"
        reserving = client.body(*urns[:needed], optional=urns[needed:], condition=condition, wait=wait)
        async with AsyncExitStack() as stack:
            reserved = await stack.enter_async_context(reserving)
            info = next((each for each in await client.bodies() if each.engine_id == reserved.engine_id), None)
            if info is None:
                raise OutOfResources(f"{reserved.engine_id} has left: use_body reserves another one")
            permits = Permits(tools, self.settings.movements, self.clock)
            runner = Runner(self._tasks, self.clock)
            return HeldBody(client, reserved, info, permits, runner, stack.pop_all())

    def _wanted(self, tools: Sequence[str] | None) -> frozenset[str]:
        """Return the tools of a task.

        Raises:
            Unsupported: one is withheld from all tasks.
            BadParameter: a body cannot be reserved by them.
        """
        allowed = self.settings.allowed
        if tools is None:
            tools = [tool for tool, ability in ABILITIES.items() if ability.is_usual and tool in allowed]
        if withheld := sorted(set(tools) - allowed):
            raise Unsupported(
                f"{', '.join(withheld)} is withheld from all tasks here: there is {', '.join(sorted(allowed))}"
            )
        if not set(tools) & set(ABILITIES):
            raise BadParameter(f"name a tool by which a body is reserved, such as {next(iter(ABILITIES))}")
        return frozenset(tools)

    async def give_back(self, reason: str) -> str:
        """Stop what runs and give the body back; return its id, empty where none is held."""
        async with self._changing:
            return await self._give_back(reason)

    async def _give_back(self, reason: str) -> str:
        held = self._held
        if held is None:
            return ""
        self._held, self._why_not_held = None, f"{held.engine_id} was given back, as {reason}"
        self.log.add("body_given_back", held.engine_id, {"reason": reason})
        # A call that is cancelled meanwhile leaves nothing bound.
        self._releasing = self._tasks.start(self._release(held))
        await asyncio.wait({self._releasing})
        return held.engine_id

    async def _release(self, held: HeldBody) -> None:
        """Stop what runs, release the body, and watch no events any more."""
        try:
            await held.give_back()
        finally:
            await self.watching.stop()

    async def _watch_idle(self, held: HeldBody) -> None:
        """Give a body back when no call came for as long as a task may be idle."""
        while self._held is held:
            left = self.settings.idle - self.idle
            if left <= 0:
                await self.give_back(f"no call came for {self.settings.idle:g} s")
                return
            await asyncio.sleep(left)

    async def vocabulary(self) -> Vocabulary:
        """Return the names that can be chosen now.

        Raises:
            ConnectionFailed, ConnectionLost, RoISError, TimeoutError: the gateway does not tell, or not soon.
        """
        async with asyncio.timeout(_NAMES):
            return await self._vocabulary.current(await self.link.client())

    async def body_info(self, body: str | None) -> BodyInfo:
        """Return a body: the one that is named, else the one that is held, else the only one.

        Raises:
            BadParameter: there is no such body, or there are several and none is named.
            Unsupported: there is none at all.
        """
        held = self._held
        if held is not None and held.body.error is None and body in (None, held.engine_id):
            return held.info
        wanted = body or (held.engine_id if held is not None else None)
        bodies = await (await self.link.client()).bodies()
        if not bodies:
            raise Unsupported("there is no body behind the gateway")
        there = ", ".join(each.engine_id for each in bodies)
        if wanted is None and len(bodies) > 1:
            raise BadParameter(f"name a body: there are {there}")
        found = [each for each in bodies if wanted in (None, each.engine_id)]
        if not found:
            raise BadParameter(f"there is no body {wanted!r}: there are {there}")
        return found[0]

    async def consents(self, info: BodyInfo) -> Consents:
        """Return what asks the visitors of a body, as it is, by the connection of now."""
        client = await self.link.client()
        key = client, info.engine_id, *(each.component_ref for each in info.components)
        self._consents[key] = known = self._consents.pop(key, None) or Consents(client, info)
        if len(self._consents) > MAX_ASKED:
            del self._consents[next(iter(self._consents))]
        return known


def _pattern(engine_id: str) -> str:
    """Return an id as a pattern of a condition that matches nothing else."""
    return re.sub(r"([%_\\])", r"\\\1", engine_id).replace("'", "''")
