"""What dies in the middle of speech, navigation and streaming: each command ends once and truly, and all goes on."""

import asyncio
import json
import signal
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, suppress
from typing import Any, Final

import psutil
import pytest

from tests.support.black_box import H264, VIDEO, Application, application
from tests.support.demo import Demo, running_demo

pytestmark = [pytest.mark.media, pytest.mark.engine]

ERROR: Final = "rois.system.notify_error"
_SPEECH: Final = "avatar/speech_synthesizer"
_WALK: Final = "avatar/navigation"
_STORY: Final = "Once upon a time there was an avatar that told long stories to every listener. " * 6
_LONG_WAY: Final = ["-2.5,2.5", "2.5,0"] * 5
_BACK_WITHIN: Final = 30.0


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """A demo of which parts may be killed."""
    with running_demo(tmp_path_factory.mktemp("middle"), "puppet") as demo:
        yield demo
        assert "Traceback" not in demo.log(), demo.log()


class Stage:
    """An application that watches the avatar and has it speak and walk."""

    def __init__(self, app: Application) -> None:
        self.app = app
        self.video = ""
        self._commands = 0

    async def watch(self) -> None:
        """Say who is there, and see the avatar."""
        await self.app.hello()
        await self.attached()
        self.video = await self.app.play(VIDEO, H264)
        assert await self.app.frames(self.video, 5)

    async def attached(self) -> None:
        """Wait until an avatar is there, and usable."""
        known = -1
        while True:
            if VIDEO in (await self.app.ask("rois.system.get_profile"))["component_profiles"]:
                return
            await self.app.news.until(lambda known=known: self._changes() > known, _BACK_WITHIN)  # type: ignore[misc]
            known = self._changes()

    def _changes(self) -> int:
        return len(self.app.told("rois.system.profile_changed"))

    async def usable(self, ref: str) -> None:
        """Wait until a component can be used, or is; it is asked at every picture anew."""
        condition = f"component_ref = '{ref}'"
        async with asyncio.timeout(60):
            while True:
                asked = await self.app.ask("rois.query.query", query_type="component_status", condition=condition)
                if asked["results"][0]["value"] in {"READY", "BUSY"}:
                    return
                await self.app.frames(self.video, 1)

    async def start(self, ref: str, name: str, kind: str, value: Any) -> str:
        """Bind a component, set a parameter and start it; returns the id of the command."""
        assert (await self.app.ask("rois.command.bind", component_ref=ref))["return_code"] == "OK"
        text = value if isinstance(value, str) else json.dumps(value)
        parameter = {"name": name, "data_type_ref": kind, "value": text}
        given = await self.app.ask("rois.command.set_parameter", component_ref=ref, parameters=[parameter])
        assert given["return_code"] == "OK", given
        self._commands += 1
        command_id = f"command {self._commands}"
        unit = {"component_ref": ref, "command_type": "start", "command_id": command_id}
        assert (await self.app.ask("rois.command.execute", command_unit_list=[unit]))["return_code"] == "OK"
        return command_id

    async def speak(self, text: str = _STORY) -> str:
        return await self.start(_SPEECH, "speech_text", "string", text)

    async def walk(self, targets: list[str] = _LONG_WAY) -> str:
        """Begin to walk as soon as the figure can, and wait until it does."""
        await self.usable(_WALK)
        before = await self.place()
        walk = await self.start(_WALK, "target_positions", "string[]", targets)
        while await self.place() == before:
            assert not self.ends(walk), "it does not walk at all"
            await self.app.frames(self.video, 1)
        return walk

    async def place(self) -> str:
        condition = "component_ref = 'avatar/system_info'"
        asked = await self.app.ask("rois.query.query", query_type="robot_position", condition=condition)
        (place,) = next(json.loads(each["value"]) for each in asked["results"] if each["name"] == "position_data")
        return str(place)

    def ends(self, command_id: str) -> list[str]:
        """Return the statuses with which a command was notified to have ended; one is expected."""
        told = self.app.told("rois.command.completed")
        return [each["status"] for each in told if each["command_id"] == command_id]

    async def end(self, command_id: str, within: float = 15.0) -> str:
        await self.app.news.until(lambda: self.ends(command_id), within)
        (status,) = self.ends(command_id)
        return status

    async def works(self) -> None:
        """Speak, walk and show pictures, from beginning to end."""
        speech, walk = await self.speak("Hello."), await self.walk(["0,0.5"])
        assert await self.end(speech) == await self.end(walk, 30) == "OK"
        assert await self.place() != "0.000,0.000,-1.5708"
        assert await self.app.frames(self.video, 5)


@asynccontextmanager
async def stage(demo: Demo) -> AsyncIterator[Stage]:
    async with application(demo.url) as app:
        found = Stage(app)
        await found.watch()
        yield found


def engine(demo: Demo) -> psutil.Process:
    """The process that renders."""
    return next(each for each in demo.tree() if "openrois_avatar.engines.puppet" in each.cmdline())


@pytest.mark.long
@pytest.mark.parametrize(
    ("harm", "fault", "patience"),
    [(signal.SIGKILL, "COMPONENT_INTERNAL_ERROR", 0), (signal.SIGSTOP, "COMPONENT_NOT_RESPONDING", 5)],
    ids=["dies", "hangs"],
)
async def test_an_engine_that_is_lost_fails_the_walk_and_not_the_voice(
    demo: Demo, harm: signal.Signals, fault: str, patience: float
) -> None:
    async with stage(demo) as on:
        speech, walk = await on.speak(), await on.walk()
        faults, harmed = len(on.app.told(ERROR)), time.monotonic()
        engine(demo).send_signal(harm)
        assert await on.end(walk) == "ERROR"
        assert time.monotonic() - harmed > patience
        await on.app.news.until(lambda: len(on.app.told(ERROR)) > faults)
        assert {told["error_type"] for told in on.app.told(ERROR)[faults:]} == {fault}
        if patience:
            await on.app.until_status(on.video, "NOT_RUNNING")
            await on.app.until_status(on.video, "RUNNING", _BACK_WITHIN)
        assert on.ends(speech) == []
        await on.usable(VIDEO)
        await on.works()
        await on.app.until_status(on.video, "RUNNING", _BACK_WITHIN)
        # One that dies may be back before a second without pictures is over; what hangs is not.
        gaps = len(on.app.statuses(on.video)) // 2 - 1
        assert on.app.statuses(on.video) == ["NOT_RUNNING", "RUNNING"] * (1 + gaps)
        assert gaps == 1 or (gaps == 0 and not patience)
        assert on.ends(walk) == ["ERROR"]
        assert on.ends(speech) == ["ABORT"]  # the next text replaced it: its voice was there to the end


async def test_a_killed_adapter_fails_what_ran_and_its_successor_does_it_again(demo: Demo) -> None:
    async with stage(demo) as on:
        speech, walk = await on.speak(), await on.walk()
        demo.program("avatar").kill()
        assert await on.end(speech) == await on.end(walk) == "ERROR"
        await on.app.until_status(on.video, "NOT_CONNECTED")
        await on.attached()
        on.video = await on.app.play(VIDEO, H264)
        assert await on.place() == "0.000,0.000,-1.5708"
        await on.works()
        assert on.ends(speech) == on.ends(walk) == ["ERROR"]


@pytest.mark.long
async def test_commands_of_a_killed_gateway_pass_to_the_next_client(demo: Demo) -> None:
    async with stage(demo) as orphan:
        speech, walk = await orphan.speak(), await orphan.walk()
        demo.program("gateway").kill()
        await orphan.app.news.until(lambda: orphan.app.ended)
        assert orphan.ends(speech) == orphan.ends(walk) == []
        while True:
            await orphan.app.frames(orphan.video, 1)  # they come past the gateway
            with suppress(ConnectionRefusedError):
                async with stage(demo) as on:
                    await on.works()
                    break
