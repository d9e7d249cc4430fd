"""What the adapter hears and sees of its operator, without a network."""

import asyncio
import re
from collections.abc import AsyncIterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openrois_body.components.operator import Operator
from openrois_media.devices import LEVEL_INTERVAL, Camera, Microphone
from openrois_streaming.source.loudness import SILENCE, Level
from openrois_streaming.source.source import RawAudio, RawVideo

from openrois.engine.registry import LocalRegistry
from openrois.errors import ComponentFailed
from tests.support.streaming import FedSource, VirtualClock, picture, settle


def sound(value: int) -> RawAudio:
    return RawAudio(np.full((480, 2), value, np.int16), 0.0)


class Stage:
    """An operator's component whose microphone and camera are fed by hand."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.microphone, self.camera = Microphone(self.clock), Camera()
        self.voice: FedSource[RawAudio] = FedSource()
        self.face: FedSource[RawVideo] = FedSource()
        self.registry = LocalRegistry("avatar", [Operator(self.microphone, self.camera)])
        self.levels: list[Level] = []
        self.microphone.level_changed.add(self.levels.append)

    async def ask(self, query: str) -> dict[str, str]:
        return {result.name: result.value for result in await self.registry.query("avatar/operator", query)}

    async def speak(self, value: int, seconds: float = LEVEL_INTERVAL) -> None:
        for _ in range(round(seconds * 100)):
            await self.voice.feed(sound(value))
            await self.clock.advance(0.01)


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    stage = Stage()
    listening = asyncio.create_task(stage.microphone.listen())
    await settle()
    yield stage
    listening.cancel()
    with suppress(asyncio.CancelledError):
        await listening
    assert stage.voice.opened == stage.voice.closed
    assert stage.face.opened == stage.face.closed


async def test_microphone_without_sender_is_silent(stage: Stage) -> None:
    assert await stage.ask("microphone") == {"connected": "false", "rms": "-100.0", "peak": "-100.0"}
    await stage.clock.advance(10)
    assert stage.levels == []


async def test_listeners_get_changed_levels_and_the_end(stage: Stage) -> None:
    stage.microphone.inlet.plug("s", stage.voice)
    await stage.speak(1000, 1.0)
    assert stage.levels == [Level(-30.3, -30.3)]
    assert await stage.ask("microphone") == {"connected": "true", "rms": "-30.3", "peak": "-30.3"}
    await stage.speak(2000, 1.0)
    assert stage.levels[-1] == Level(-24.3, -24.3)
    assert len(stage.levels) <= 3
    stage.microphone.inlet.unplug("s")
    await stage.clock.advance(2 * LEVEL_INTERVAL)
    assert stage.levels[-1] == stage.microphone.level == SILENCE
    await settle()
    assert stage.clock.sleepers == 0


async def test_the_peak_is_not_the_mean(stage: Stage) -> None:
    events: list[Any] = []
    subscription = await stage.registry.subscribe("avatar/operator", "microphone_level", events.append)
    stage.microphone.inlet.plug("s", stage.voice)
    for _ in range(15):
        await stage.speak(2000, 0.01)
        await stage.speak(0, 0.01)
    for told in ({result.name: result.value for result in events[-1].results}, await stage.ask("microphone")):
        assert (float(told["rms"]), told["peak"]) == (pytest.approx(-27.3, abs=0.3), "-24.3")
    await stage.registry.unsubscribe(subscription)


async def test_listeners_get_each_block(stage: Stage) -> None:
    heard: list[RawAudio] = []
    stage.microphone.sound_received.add(heard.append)
    stage.microphone.inlet.plug("s", stage.voice)
    block = sound(1)
    await stage.voice.feed(block, block)
    assert heard == [block, block]


async def test_levels_are_events_of_the_component(stage: Stage) -> None:
    events: list[Any] = []
    subscription = await stage.registry.subscribe("avatar/operator", "microphone_level", events.append)
    stage.microphone.inlet.plug("s", stage.voice)
    await stage.speak(1000, 0.3)
    assert len(events) == 1
    assert {result.name: result.value for result in events[0].results} == {"rms": "-30.3", "peak": "-30.3"}
    await stage.registry.unsubscribe(subscription)


async def test_camera_is_decoded_on_request(stage: Stage) -> None:
    with pytest.raises(ComponentFailed, match="no camera"):
        await stage.ask("camera")
    stage.camera.inlet.plug("s", stage.face)
    await settle()
    assert not stage.face.is_open
    asking = asyncio.create_task(stage.ask("camera"))
    await settle()
    await stage.face.feed(picture(0))
    assert await asking == {"width": "160", "height": "90", "brightness": "0.511"}
    assert not stage.face.is_open


async def test_a_camera_without_pictures_is_said_so(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    async def none(timeout: float = 2.0) -> RawVideo:
        raise TimeoutError

    monkeypatch.setattr(stage.camera, "picture", none)
    stage.camera.inlet.plug("s", stage.face)
    with pytest.raises(ComponentFailed, match="sends no pictures"):
        await stage.ask("camera")


async def test_a_wait_for_a_picture_ends(stage: Stage) -> None:
    stage.camera.inlet.plug("s", stage.face)
    with pytest.raises(TimeoutError):
        await stage.camera.picture(timeout=0)


async def test_example_of_the_guide_reads_the_microphone(stage: Stage) -> None:
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "adapter.md").read_text(encoding="utf-8")
    [example] = [piece for piece in re.findall(r"(?s)```python\n(.*?)```", page) if "openrois_media.devices" in piece]
    made: dict[str, Any] = {"__name__": "tests.example"}
    exec(example, made)
    registry = LocalRegistry("avatar", [made["Attention"]("Attention", stage.microphone, stage.camera)])

    async def speaks() -> str:
        [result] = await registry.query("avatar/Attention", "speaks")
        return result.value

    assert await speaks() == "false"
    stage.microphone.inlet.plug("s", stage.voice)
    await stage.speak(3000)
    await stage.clock.advance(LEVEL_INTERVAL)
    assert await speaks() == "true"
