"""The avatar adapter around a scene that the test plays: what the operator says, and what the engine pauses."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import av
import numpy as np
import pytest
from openrois_avatar import adapter
from openrois_avatar.link.messages import Pause
from openrois_avatar.scene import Pauses, Scene, synthetic_scene
from openrois_media.devices import Microphone
from openrois_media.health import Health, Observed
from openrois_media.visitors.registry import VisitorRegistry
from openrois_streaming.clock import SystemClock
from openrois_streaming.session.sessions import StreamSessions
from openrois_streaming.source import stamp
from openrois_streaming.source.source import RawAudio, RawVideo

from tests.support.streaming import FedSource, VirtualClock, settle


class Stage:
    """A scene whose sources give nothing, and what it hears."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.heard: list[RawAudio] = []
        self.pauses = Pauses()
        video: FedSource[RawVideo] = FedSource()
        audio: FedSource[RawAudio] = FedSource()
        health = Health("the stage", self.clock.now())
        unobserved = Observed(None, wanted=False)
        self.scene = Scene(
            video, audio, 30.0, (640, 480), (), health, lambda: unobserved, self.pauses, self.heard.append
        )

    @asynccontextmanager
    async def served(self) -> AsyncIterator[None]:
        async with adapter.serve_scene("avatar", self.scene, self.clock):
            await settle()
            yield


async def test_the_first_viewer_is_offered_the_sizes_of_the_scene_before_any_picture_has_come() -> None:
    stage = Stage()
    async with adapter.serve_scene("avatar", stage.scene, stage.clock) as avatar:
        rungs = [each.rung for each in avatar.video.renditions("video/VP8")]
        assert [(rung.width, rung.height) for rung in rungs if rung is not None] == [(640, 480), (320, 240)]


@pytest.mark.parametrize("stamped", [False, True])
async def test_a_picture_is_stamped_only_where_its_scene_asks_for_that(stamped: bool) -> None:
    clock = SystemClock()
    scene = synthetic_scene(clock, 320, 180, stamped=stamped)
    async with (
        adapter.serve_scene("avatar", scene, clock) as avatar,
        avatar.video.renditions("video/VP8")[0].subscribe() as subscription,
    ):
        frame = await subscription.get()
    decoder = av.CodecContext.create("vp8", "r")
    assert isinstance(decoder, av.VideoCodecContext)
    [decoded] = decoder.decode(av.Packet(frame.data))
    assert (stamp.read(np.asarray(decoded.to_ndarray(format="gray"), np.uint8)) is not None) is stamped


async def test_the_engine_hears_the_operator(monkeypatch: pytest.MonkeyPatch) -> None:
    stage, made = Stage(), list[Microphone]()

    def remember(clock: VirtualClock, visitors: VisitorRegistry) -> Microphone:
        made.append(Microphone(clock, visitors))
        return made[-1]

    monkeypatch.setattr(adapter, "Microphone", remember)
    voice: FedSource[RawAudio] = FedSource()
    sound = RawAudio(np.ones((480, 2), np.int16), 1.0)
    async with stage.served():
        made[0].inlet.plug("s", voice)
        await voice.feed(sound)
        assert stage.heard == [sound]
    assert voice.opened == voice.closed == 1


async def test_pause_of_the_engine_holds_the_viewers_video(monkeypatch: pytest.MonkeyPatch) -> None:
    stage, calls = Stage(), list[tuple[str, ...]]()
    monkeypatch.setattr(StreamSessions, "hold", lambda _self, *what: calls.append(("hold", *what)))
    monkeypatch.setattr(StreamSessions, "release", lambda _self, *what: calls.append(("release", *what)))
    async with stage.served():
        stage.pauses.handle_event(Pause(True))
        stage.pauses.clear()
    assert calls == [("hold", "avatar/video_streaming", "recvonly"), ("release", "avatar/video_streaming")]
