"""Each process of the demo dies or is stopped: the page is live again by itself, and nothing is left over."""

import asyncio
import signal
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Final

import psutil
import pytest
import pytest_asyncio
from playwright.async_api import Browser, expect

from tests.support.browser import GATEWAY_AWAY, Visit, visiting
from tests.support.conversation import SAYING, meet, say
from tests.support.demo import Demo, running_demo

pytestmark = [pytest.mark.browser, pytest.mark.engine, pytest.mark.asyncio(loop_scope="session")]

_VOICE: Final = "avatar/speech_synthesizer"
PROCESSES: Final = {
    "gateway": "gateway",
    "adapter": "avatar",
    "engine": "openrois_avatar.engines.puppet",
    "speech": "openrois_body.speech.espeak_child",
}
"""The processes that a demo starts, and the word of their command line that distinguishes them."""
BACK: Final = 90.0
"""Seconds that all may take to be back: what hangs is found after 10 s at the latest, then programs start."""
RESTARTS: Final = 20


def left_over(folder: Path) -> list[Path]:
    """Leftovers of killed programs: folders of sockets, and shared memory."""
    return [path for place in (folder, Path("/dev/shm")) for path in place.glob("*openrois*")]


class Watched:
    """A demo, and the page that watches it all the time."""

    def __init__(self, demo: Demo, visit: Visit) -> None:
        self.demo = demo
        self.visit = visit

    def running(self) -> dict[str, list[int]]:
        """The ids of its processes, by name; a zombie counts as another one."""
        found: dict[str, list[int]] = {}
        for process in self.demo.tree():
            try:
                words = [] if process.status() == psutil.STATUS_ZOMBIE else process.cmdline()
            except psutil.NoSuchProcess:
                continue
            name = next((name for name, word in PROCESSES.items() if word in words), "another one")
            found.setdefault(name, []).append(process.pid)
        return found

    def complete(self) -> bool:
        """Whether each process runs once, and no other one."""
        return {name: len(ids) for name, ids in self.running().items()} == dict.fromkeys(PROCESSES, 1)

    async def live(self) -> None:
        """Wait until the avatar is seen, heard and obeys, with each process once."""
        async with asyncio.timeout(BACK):
            await self._seen()
            while not await self._speaks():
                pass
            while not self.complete():  # noqa: ASYNC110 - the system sends no event
                await asyncio.sleep(0.1)

    async def _seen(self) -> None:
        await self.visit.no_banner()
        await self.visit.plays()
        for kind in ("video", "audio"):
            await self.visit.status(kind, "RUNNING")
        await expect(self.visit.item("say-text")).to_be_enabled(timeout=BACK * 1000)

    async def _speaks(self) -> bool:
        """Say a sentence, wait for its end on the page, and return whether it was spoken whole."""
        before = len(self.visit.executed(_VOICE, "start"))
        await say(self.visit, "Hello.")
        await self.visit.until(f"!['speaking', 'paused'].includes({SAYING})")
        # A command that was refused, because the adapter has just died, has no end.
        started = self.visit.executed(_VOICE, "start")[before:]
        told = [each for one in started for each in self.visit.told("rois.command.completed", command_id=one)]
        return [each["status"] for each in told] == ["OK"]

    async def harm(self, name: str, how: signal.Signals) -> None:
        """Harm a process, and wait until all is live again, with another one in its place."""
        (pid,) = self.running()[name]
        psutil.Process(pid).send_signal(how)
        await self.another(name, pid)
        await self.live()

    async def another(self, name: str, than: int) -> None:
        """Wait until a process is replaced; speech detects a dead or hanging voice only when it needs one."""
        async with asyncio.timeout(BACK):
            while than in self.running().get(name, []):
                if name == "speech":
                    await self._speaks()
                await asyncio.sleep(0.1)


@pytest_asyncio.fixture(loop_scope="session")
async def watched(browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Watched]:
    with tempfile.TemporaryDirectory() as folder:
        # Others use the usual one at the same time, and pytest's is too long for a socket.
        monkeypatch.setenv("TMPDIR", folder)
        with running_demo(tmp_path, "puppet") as demo:
            async with visiting(browser, demo.page, tolerated=[GATEWAY_AWAY]) as visit:
                await meet(visit)
                yield (one := Watched(demo, visit))
                await one.live()
            assert "Traceback" not in demo.log(), demo.log()
            # The sockets of the engine, and the tokens for programs.
            assert len(left_over(Path(folder))) == 2
            assert demo.interrupt() == 0
        assert left_over(Path(folder)) == []


@pytest.mark.long
async def test_page_is_live_again_after_each_process_died(watched: Watched) -> None:
    await watched.live()
    for name in PROCESSES:
        await watched.harm(name, signal.SIGKILL)


@pytest.mark.long
@pytest.mark.timeout(600)
@pytest.mark.parametrize("name", PROCESSES)
async def test_page_is_live_again_after_a_process_was_stopped(watched: Watched, name: str) -> None:
    await watched.live()
    await watched.harm(name, signal.SIGSTOP)


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", PROCESSES)
async def test_page_is_live_again_after_a_process_died_repeatedly(watched: Watched, name: str) -> None:
    await watched.live()
    descriptors = psutil.Process(watched.demo.process.pid).num_fds()
    for _ in range(RESTARTS):
        await watched.harm(name, signal.SIGKILL)
    assert psutil.Process(watched.demo.process.pid).num_fds() <= descriptors + 1
