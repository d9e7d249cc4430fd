"""A house with an avatar and a robot, for the guide of `docs/examples`: what its visitors say there, and are told."""

import asyncio
import importlib
import os
import sys
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path
from types import ModuleType
from typing import Any, Final
from unittest.mock import patch

from openrois_body.components.hearing import Hearing
from openrois_body.components.speech_progress import SpeechProgress
from openrois_body.host_body import HostBody
from openrois_body.messages import Place
from openrois_media import Media
from openrois_robots.simulated.adapter import Robot, simulated_robot
from openrois_robots.simulated.simulation import SimulationSettings
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.synthetic import ColourBars

from openrois.adapter import Component
from openrois.adapter.running import serve
from openrois.aio.listeners import Listeners
from openrois.client import Client, Subscription, where
from openrois.client.components import Navigation
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.testing import FaultRelay
from openrois.transport.credentials import Credentials
from openrois.types.codes import ComponentStatus, Purpose
from openrois.types.leases import LeaseState
from tests.support.deployment import until
from tests.support.ground import Child, program
from tests.support.operated import noting_avatar
from tests.support.packages import ROOT
from tests.support.simulated_robot import at
from tests.support.tokens import issue, key_file
from tests.support.voice import ScriptedSynthesizer

__all__ = [
    "AVATAR_VOICE",
    "LEGS",
    "ROBOT_VOICE",
    "House",
    "example",
    "guide",
    "guide_process",
    "house",
    "token",
    "visitor",
]

_GUIDE: Final = ROOT / "docs/examples/guide.py"
LEGS: Final = "robot/navigation"
AVATAR_VOICE: Final = "avatar/speech_synthesizer"
ROBOT_VOICE: Final = "robot/speech_synthesizer"

_PATIENCE: Final = 60.0
_STILL: Final = 20
"""Questions to the gateway for which a robot stands still that has stopped."""
_GRACE: Final = 1.0
"""Seconds for which the gateway keeps the leases of a lost connection."""


def token(subject: str, **claims: object) -> str:
    """Return a good token for everything in the house."""
    return issue(time.time(), sub=subject, scope=["*/*"], **claims)


class _NoEars:
    """The attention of a robot that hears nothing."""

    speech_began: Listeners[float] = Listeners()

    def attend(self) -> Any:
        return lambda: None


class House:
    """A gateway, the bodies behind it, and an application that sees what a visitor is told.

    Attributes:
        url: of the gateway.
        guides, avatars, robots: stand between the gateway and the guide, the avatar and the robot.
        client: the application.
        told: body and text of each speech, since it began.
        hearing: of the avatar.
        robot: as it is, whatever the gateway knows of it; None where it is a program.
        robot_process: that program.
        synthesizer: speaks for both bodies.
    """

    def __init__(self, url: str, client: Client, relays: tuple[FaultRelay, FaultRelay, FaultRelay]) -> None:
        self.url = url
        self.client = client
        self.guides, self.avatars, self.robots = relays
        self.told: list[tuple[str, str]] = []
        self.hearing: list[Hearing] = []
        self.robot: Robot | None = None
        self.robot_process: Child | None = None
        self.synthesizer = ScriptedSynthesizer(0.2)
        self._news = asyncio.Event()

    def say(self, words: str, visitor: str | None = None) -> None:
        """Let the avatar hear a visitor."""
        (hearing,) = self.hearing
        hearing.heard(words, True, None, visitor)

    async def hears(self) -> None:
        """Wait until a program listens to what the avatar hears."""
        (hearing,) = self.hearing
        async with asyncio.timeout(_PATIENCE):
            while not hearing.activity.works:
                await self._turn()

    async def leaves(self, body: str) -> None:
        """Wait until the gateway knows a body no more."""
        async with asyncio.timeout(_PATIENCE):
            while body in {each.engine_id for each in await self.client.bodies()}:
                await self._turn()

    async def tells(self, text: str, by: str = "") -> None:
        """Wait until a visitor is told something that was not waited for yet, by a body where one is named."""
        async with asyncio.timeout(_PATIENCE):
            while True:
                for number, (body, heard) in enumerate(self.told):
                    if text in heard and by in ("", body):
                        del self.told[: number + 1]
                        return
                self._news.clear()
                await self._news.wait()

    async def listen(self, body: str, speeches: Subscription[dict[str, Any]]) -> None:
        """Note what a body says."""
        async for began in speeches:
            self.told.append((body, began["text"]))
            self._news.set()

    @property
    def place(self) -> Place:
        """Where the robot is."""
        assert self.robot is not None
        return self.robot.simulation.place

    async def is_busy(self, component_ref: str) -> None:
        """Wait until a component does what it was started for."""
        async with asyncio.timeout(_PATIENCE):
            while await self.client.component(Navigation, component_ref).component_status() is not ComponentStatus.BUSY:
                await self._turn()

    async def moves(self) -> None:
        """Wait until the robot has moved."""
        began = self.place
        async with asyncio.timeout(_PATIENCE):
            while self.place == began:
                await self._turn()

    async def stands(self) -> None:
        """Wait until nothing is going to move the robot, and it stands still."""
        legs = self.client.component(Navigation, LEGS)
        async with asyncio.timeout(_PATIENCE):
            while await legs.component_status() is ComponentStatus.BUSY:
                await self._turn()
            still, here = 0, self.place
            while still < _STILL:
                await self._turn()
                # It brakes for a moment.
                still, here = (still + 1 if self.place == here else 0), self.place
        assert await legs.component_status() is not ComponentStatus.BUSY

    async def is_free(self, component_ref: str) -> None:
        """Wait until no application holds a component."""
        async with asyncio.timeout(_PATIENCE):
            while (await self.client.control.status(component_ref)).state is not LeaseState.FREE:
                await self._turn()

    async def _turn(self) -> None:
        # What is asked over a socket takes its time.
        await self.client.search(where(component_ref=LEGS))


@asynccontextmanager
async def house(folder: Path, x: float = -1.5, y: float = 0.5, *, robot_process: bool = False) -> AsyncIterator[House]:
    """Run a gateway with an avatar and a robot while the block runs.

    Args:
        folder: for what is written.
        x, y: where the robot is at first.
        robot_process: the robot is a program, which begins in its dock and does not announce what it says.
    """
    file = folder / "adapters.token"
    file.write_text(token("adapters", roles=["adapter"]))
    settings = GatewaySettings(port=0, auth_keys=(key_file(folder),), lease_grace=_GRACE)
    clock = SystemClock()
    async with AsyncExitStack() as stack:
        running = await stack.enter_async_context(run_gateway(settings))
        url = running.url.replace("http", "ws", 1)
        relays = [await stack.enter_async_context(FaultRelay(url)) for _ in range(3)]
        client = await stack.enter_async_context(Client(url, token=token("observer", rank="script")))
        opened = House(url, client, (relays[0], relays[1], relays[2]))

        @asynccontextmanager
        async def synthesizer(_choice: object, _clock: MediaClock) -> AsyncIterator[ScriptedSynthesizer]:
            yield opened.synthesizer

        class Ears(Component, authority="Test", function="sensing"):
            """Finds what the avatar hears with."""

            def __init__(self, body: HostBody) -> None:
                super().__init__()
                hearing = body.find(Hearing)
                assert hearing is not None
                opened.hearing.append(hearing)

        stack.enter_context(patch("openrois_body.speech_options.VoiceChoice.make", synthesizer))
        dialled = [f"{relay.url}adapter" for relay in relays]
        credentials = Credentials.of_files(file, None)
        await stack.enter_async_context(noting_avatar(folder, dialled[1], credentials, (Ears,)))
        if robot_process:
            arguments = ("robot", "simulated", "--gateway", dialled[2], "--token-file", str(file))
            opened.robot_process = await stack.enter_async_context(
                program("-m", "openrois.cli", *arguments, log=folder / "robot.log")
            )
        else:
            opened.robot = await stack.enter_async_context(
                simulated_robot("robot", SimulationSettings(), clock, at(x, y))
            )
            progress = SpeechProgress(opened.robot.voice, _NoEars())
            await stack.enter_async_context(
                serve(*opened.robot.components, progress, engine_id="robot", gateway=dialled[2], token_file=file)
            )
        await until(running.engine, lambda ids: {"avatar", "robot"} <= set(ids))
        for body in ("avatar",) if robot_process else ("avatar", "robot"):
            speeches = client.component(f"{body}/speech_progress").event("speech_began")
            listening = asyncio.ensure_future(opened.listen(body, await stack.enter_async_context(speeches)))
            stack.push_async_callback(_ended, listening)
        yield opened


async def _ended(task: "asyncio.Task[None]") -> None:
    task.cancel()
    with suppress(asyncio.CancelledError):
        await task


def example(name: str) -> ModuleType:
    """Return an example as a module."""
    with patch.object(sys, "path", [str(_GUIDE.parent), *sys.path]):
        return importlib.import_module(name)


@asynccontextmanager
async def visitor(opened: House, *purposes: Purpose) -> AsyncIterator[str]:
    """Let a visitor send a picture to the avatar, with consent to something, while the block runs; yield its ref."""
    shown = token("visitor", roles=["visitor"])
    async with (
        Client(opened.url, token=shown) as client,
        Media(client) as media,
        media.send(camera=ColourBars(160, 120, 15, clock=SystemClock()), consent=purposes, to="avatar/video_streaming"),
    ):
        visitors: tuple[str, ...] = ()
        async with asyncio.timeout(_PATIENCE):
            while not visitors:
                visitors = tuple((await opened.client.component("avatar/visitors").query("visitors"))["visitor_ref"])
        yield visitors[0]


@asynccontextmanager
async def guide_process(opened: House, folder: Path) -> AsyncIterator[Child]:
    """Run the guide as a process while the block runs, unless it is killed before; it listens when the block begins."""
    file = folder / "guide.token"
    file.write_text(token("guide", rank="agent"))
    arguments = (str(_GUIDE), "--gateway", opened.guides.url, "--note", str(folder / "note"))
    variables = {"OPENROIS_TOKEN_FILE": str(file)}
    with patch.dict(os.environ, variables):
        started = program(*arguments, log=folder / "guide.log", prints=True)
        async with started as child:
            yield child


@asynccontextmanager
async def guide(opened: House, folder: Path, model: str = "") -> AsyncIterator["asyncio.Task[None]"]:
    """Run the guide in this process while the block runs."""
    relayed = opened.guides.url
    async with Client(relayed, token=token("guide", rank="agent")) as client:
        talk = example("small_talk").SmallTalk(client, model)
        task = asyncio.ensure_future(example("guide").Guide(client, "robot", talk, folder / "note").run())
        try:
            yield task
            assert not task.done(), task.exception()
        finally:
            await _ended(task)
