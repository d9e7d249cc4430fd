"""An adapter and an application that write down what they see of a cluster, for `tests.support.histories`."""

import asyncio
import json
import time
from collections.abc import AsyncIterator, Callable, Coroutine, Mapping, Sequence
from contextlib import asynccontextmanager
from contextvars import ContextVar
from typing import Any, Final

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.client import Client, ConnectionLost, Reconnect
from openrois.client.commands import Command
from openrois.client.dialling import websocket
from openrois.client.steps import Step
from openrois.component.authoring.marks import command
from openrois.component.component import Component
from openrois.contract import Client as Holder
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import RoISError
from openrois.leases.epoch_fence import EpochFence
from openrois.session.session import EngineHost
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois.transport.stream import MessageStream
from openrois.types.messages import Argument, Result
from openrois.types.streams import HolderNotification
from tests.support.histories import Accepted, Completed, Connected, Held, History, Lost, Ran

__all__ = ["Operator", "RecordedAdapter", "operator"]

_epoch: ContextVar[int] = ContextVar("epoch")

QUICK: Final = Reconnect(first=0.05, limit=0.3)
"""An application that looks for a gateway again soon."""


class Arm(Component, authority="Test", function="actuation"):
    """Moves when it is told, and writes down by which epoch."""

    def __init__(self, adapter: "RecordedAdapter") -> None:
        super().__init__("arm")
        self._adapter = adapter

    @command
    async def move(self, name: str, seconds: float = 0.0) -> None:
        self._adapter.note_run(name)
        await asyncio.sleep(seconds)

    @command
    async def stop(self) -> None:
        pass


class Fence(EpochFence):
    """The fence of an adapter, which knows what each gateway has reported."""

    def epoch_of(self, parent: object, component_ref: str) -> int:
        """Return the epoch that a gateway has reported of a component; 0 for none."""
        return self._reported.get(parent, {}).get(component_ref, 0)


class RecordedAdapter:
    """An adapter of this process with one arm.

    Attributes:
        engine_id: of it.
        connected: set while a gateway has attached it.
        attached_at: when a gateway has attached it, each time, in monotonic seconds.
    """

    def __init__(self, history: History, engine_id: str) -> None:
        self.engine_id = engine_id
        self.arm_ref = f"{engine_id}/arm"
        self.connected = asyncio.Event()
        self.attached_at: list[float] = []
        self._history = history
        self._fence = Fence()
        self._host: EngineHost | None = None

    @asynccontextmanager
    async def serving(self, urls: Sequence[str], credentials: Credentials = NO_CREDENTIALS) -> AsyncIterator[None]:
        """Serve one of these gateways at a time while the block runs."""
        registry = LocalRegistry(self.engine_id, [Arm(self)], extension=self)
        registry.guard = self._run
        engine = Engine(self.engine_id)
        await engine.attach(registry)
        async with TaskScope() as running, TaskScope() as dialling:
            self._host = EngineHost(engine, running, epoch_fence=self._fence)
            dialling.start(serve_parent(self._host, *urls, credentials=credentials, attached=self._note_attached))
            yield

    def _note_attached(self, is_attached: bool) -> None:
        if is_attached:
            self.attached_at.append(time.monotonic())
            self.connected.set()
        else:
            self.connected.clear()

    async def attached(self, since: float) -> float:
        """Wait until a gateway has attached it since a moment; return when that was."""
        async with asyncio.timeout(60):
            while not self.attached_at or self.attached_at[-1] < since:
                self.connected.clear()
                await self.connected.wait()
        return self.attached_at[-1]

    def note_run(self, name: str) -> None:
        """Write down that a command begins."""
        self._history.add(Ran(time.monotonic(), self.arm_ref, _epoch.get(), name))

    async def _run(
        self,
        component_ref: str,
        _component: Component,
        _command_type: str,
        work: Coroutine[Any, Any, tuple[Result, ...]],
    ) -> tuple[Result, ...]:
        """Run a command by the epoch of the gateway that sent it."""
        assert self._host is not None
        task = asyncio.current_task()
        sender = next(each.owner for each in self._host.pending.of(component_ref) if each.task is task)
        _epoch.set(self._fence.epoch_of(sender, component_ref))
        return await work

    # What an engine with streams has, for its holders.

    def engines(self) -> frozenset[str]:
        """Return the engines with streams: none."""
        return frozenset()

    async def call(self, method: str, params: Mapping[str, Any], client: Holder) -> dict[str, Any]:
        """Refuse streams."""
        raise AssertionError(f"{method} is asked of an engine without streams")

    async def set_holder(self, notification: HolderNotification, client: Holder) -> None:
        """Write down who holds the arm."""
        self._history.add(
            Held(
                time.monotonic(),
                notification.component_ref,
                notification.epoch,
                client.client_id,
                notification.holds,
            )
        )

    async def forget_client(self, client: Holder) -> None:
        """Do nothing: what it held is told separately."""


class Heard:
    """The connection of an application whose messages are read by another reader, too."""

    def __init__(self, stream: MessageStream, hear: Callable[[dict[str, Any]], None]) -> None:
        self._stream = stream
        self._hear = hear

    async def receive(self) -> str:
        text = await self._stream.receive()
        self._hear(json.loads(text))
        return text

    async def send(self, text: str) -> None:
        await self._stream.send(text)

    async def close(self, code: int = 1000, reason: str = "") -> None:
        await self._stream.close(code, reason)

    def abort(self) -> None:
        self._stream.abort()


class Operator:
    """An application that holds an arm and moves it all the time, whatever happens.

    Attributes:
        client: it.
        done: how many of its commands ended OK.
        seconds: that each of its moves takes.
        refusals: what it was told in place of an acceptance, with the seconds that took, newest last.
    """

    def __init__(
        self, history: History, url: str, name: str, component_ref: str, credentials: Credentials = NO_CREDENTIALS
    ) -> None:
        self._dial = websocket(url, credentials)
        self.client = Client(dial=self._connect, reconnect=QUICK, request_timeout=10)
        self.done = 0
        self.seconds = 0.0
        self.refusals: list[tuple[float, Exception]] = []
        self._history = history
        self._name = name
        self._ref = component_ref
        self._count = 0
        self._names: dict[str, str] = {}
        self._unnamed: dict[str, list[Completed]] = {}
        self._is_over = False
        self._news = asyncio.Event()

    @asynccontextmanager
    async def _connect(self) -> AsyncIterator[MessageStream]:
        async with self._dial() as stream:
            yield Heard(stream, self._hear)

    def _hear(self, message: dict[str, Any]) -> None:
        """Write down how its commands end, and as whom adapters know it."""
        if message.get("method") == "rois.command.completed":
            self._note_end(message["params"]["command_id"], message["params"]["status"])
        elif client_id := message.get("result", {}).get("client_id"):
            self._history.add(Connected(time.monotonic(), self._name, client_id))

    def _note_end(self, command_id: str, status: str) -> None:
        end = Completed(time.monotonic(), self._name, self._names.get(command_id, command_id), status)
        if command_id in self._names:
            self._history.add(end)
        else:
            # It may come before the program that waits for the acceptance has its turn.
            self._unnamed.setdefault(command_id, []).append(end)

    async def bind(self) -> None:
        """Bind the arm, as soon as that is possible."""
        async with asyncio.timeout(60):
            while not await self.binds():  # noqa: ASYNC110 - it is free, or seen, at an unknown time
                await asyncio.sleep(0.05)

    async def binds(self) -> bool:
        """Try to bind the arm, and tell whether it did."""
        began = time.monotonic()
        try:
            await self.client.bind(self._ref)
        except (RoISError, ConnectionLost, TimeoutError) as error:
            self.refusals.append((time.monotonic() - began, error))
            return False
        return True

    async def move(self) -> Command[Any] | None:
        """Move the arm once; return the command, or None where it was not accepted."""
        self._count += 1
        name = f"{self._name}-{self._count}"

        async def prepare() -> tuple[Argument, ...]:
            # Without a look at the profile: the gateway is to say what is wrong.
            values = {"name": ("string", name), "seconds": ("double", str(self.seconds))}
            return tuple(Argument(name=key, data_type_ref=kind, value=value) for key, (kind, value) in values.items())

        async def no_results(_command_id: str) -> None:
            return None

        began = time.monotonic()
        try:
            accepted = await Step(self.client, self._ref, "move", prepare, no_results).execute()
        except (RoISError, ConnectionLost, TimeoutError) as error:
            self.refusals.append((time.monotonic() - began, error))
            return None
        self._history.add(Accepted(time.monotonic(), self._name, name))
        self._names[accepted.command_id] = name
        for end in self._unnamed.pop(accepted.command_id, ()):
            self._history.add(Completed(end.at, self._name, name, end.status))
        return accepted

    async def operate(self) -> None:
        """Move the arm again and again, until `finish`."""
        while not self._is_over:
            moving = await self.move()
            if moving is None:
                await asyncio.sleep(0.02)
                continue
            await moving.wait()
            if moving.status is None:
                self._history.add(Lost(time.monotonic(), self._name, self._names[moving.command_id]))
            self.done += moving.status == "OK"
            self._news.set()

    async def moves(self, more: int = 3) -> float:
        """Wait until so many more commands have ended OK; return when the first of them had, in monotonic seconds."""
        wanted, first = self.done + more, 0.0
        async with asyncio.timeout(60):
            while self.done < wanted:
                self._news.clear()
                await self._news.wait()
                first = first or time.monotonic()
        return first

    def finish(self) -> None:
        """Let `operate` end with the command that runs."""
        self._is_over = True


@asynccontextmanager
async def operator(
    history: History,
    url: str,
    name: str,
    component_ref: str,
    *,
    begins: bool = True,
    credentials: Credentials = NO_CREDENTIALS,
) -> AsyncIterator[Operator]:
    """Connect an application that operates a component while the block runs, unless it is to begin nothing."""
    app = Operator(history, url, name, component_ref, credentials)
    async with app.client, asyncio.TaskGroup() as tasks:
        if begins:
            await app.bind()
        operating = tasks.create_task(app.operate() if begins else _nothing())
        try:
            yield app
        except BaseException:
            operating.cancel()
            raise
        app.finish()
        async with asyncio.timeout(60):
            await operating


async def _nothing() -> None:
    """Operate nothing."""
