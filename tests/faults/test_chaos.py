"""F44: two or three faults at a time, by chance; what a seed does it does again."""

import asyncio
import signal
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

import psutil
import pytest
from openrois_streaming.testing import ImpairedPath

from tests.support.seeds import lasting
from tests.support.spectator import AUDIO, VIDEO, Spectator
from tests.support.stage import SMALL_GAME, Stage, stage

pytestmark = [pytest.mark.media, pytest.mark.timeout(400)]

ROUNDS: Final = 3


class Storm:
    """What may go wrong, for one who watches over a path.

    Attributes:
        log: what was done, for the reader of a failed run.
    """

    def __init__(self, on: Stage, app: Spectator) -> None:
        self.log: list[str] = []
        self._on = on
        self._app = app

    @property
    def _path(self) -> ImpairedPath:
        assert self._app.path is not None, "one who watches has a path"
        return self._app.path

    async def strike(self) -> None:
        """Do two or three things at a time, and end them."""
        faults: list[Callable[[], Awaitable[None]]] = [
            self.engine_dies,
            self.engine_talks_nonsense,
            self.engine_stands_still,
            self.control_is_cut,
            self.packets_are_lost,
            self.the_path_is_narrow,
            self.viewers_come_and_go,
        ]
        chosen = self._on.place.chance.sample(faults, self._on.place.chance.choice((2, 3)))
        self.log.append(" and ".join(fault.__name__ for fault in chosen))
        await asyncio.gather(*(fault() for fault in chosen))

    async def _pause(self, most: float = 0.5) -> None:
        await asyncio.sleep(self._on.place.chance.random() * most)

    def _signal(self, what: signal.Signals) -> None:
        with suppress(psutil.NoSuchProcess, StopIteration):
            self._on.engine().send_signal(what)

    async def engine_dies(self) -> None:
        await self._pause()
        self._signal(signal.SIGKILL)

    async def engine_talks_nonsense(self) -> None:
        await self._pause()
        self._signal(signal.SIGUSR1)

    async def engine_stands_still(self) -> None:
        await self._pause()
        self._signal(signal.SIGSTOP)
        await self._pause(2.0)
        self._signal(signal.SIGCONT)

    async def control_is_cut(self) -> None:
        await self._pause()
        self._on.place.relay.cut()

    async def packets_are_lost(self) -> None:
        ways = self._path.down, self._path.up
        for way in ways:
            way.change(loss=self._on.place.chance.random() * 0.3, burst=3.0)
        await self._pause(2.0)
        for way in ways:
            way.change(loss=0.0)

    async def the_path_is_narrow(self) -> None:
        way = self._path.down
        way.change(rate=200_000, delay=0.2)
        await self._pause(2.0)
        way.change(rate=None, delay=0.0)

    async def viewers_come_and_go(self) -> None:
        for _ in range(3):
            await self._pause(0.3)
            async with self._on.passing() as guest:
                # The avatar may be away at this moment.
                await guest.ask("rois.stream.connect_stream", component_ref=VIDEO, parameters=[])
                await self._pause(0.3)


async def watches(on: Stage, app: Spectator) -> None:
    """See and hear the avatar once it is there, by the streams that there are, or by others where they have ended."""
    await on.place.attached("avatar")
    assert await app.becomes(VIDEO, "READY") == "READY"
    for ref in (VIDEO, AUDIO):
        stream_id = app.playing.get(ref)
        if stream_id is None:
            if not app.playing:
                app.path = await on.path()
            stream_id = await app.connect(ref)
        await app.is_now(stream_id, "RUNNING")
        await app.sees(stream_id)


@pytest.mark.parametrize("seed", lasting(0))
async def test_f44_several_faults_at_a_time(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with stage(seed, tmp_path, caplog, game=SMALL_GAME) as on:
        app = await on.spectator()
        storm = Storm(on, app)
        try:
            await watches(on, app)
            for _ in range(ROUNDS):
                await storm.strike()
                await watches(on, app)
        except BaseException as error:
            error.add_note(f"seed {seed}: " + ", then ".join(storm.log))
            raise
