"""The adapter around a game engine that comes when it likes: what the components say, and what is expected of it."""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from openrois_avatar.adapter import serve_scene
from openrois_avatar.link.client import LinkClient
from openrois_avatar.link.messages import Completed, React, VideoShape
from openrois_avatar.scene import Scene, external_scene
from openrois_body.components.reaction import Reaction
from openrois_media.streaming_interface import Published
from openrois_streaming.codecs import CodecUnavailable

from openrois.errors import Unsupported
from openrois.types.codes import ComponentStatus
from tests.support.avatar_link import HELLO
from tests.support.streaming import VirtualClock, settle

NOD = "urn:x-rois:def:reaction:OMG::1"


def reaction_of(scene: Scene) -> Reaction:
    (found,) = (each for each in scene.components if isinstance(each, Reaction))
    return found


async def until(happened: Callable[[], bool]) -> None:
    async with asyncio.timeout(60):
        while not happened():
            await settle()


def is_there(scene: Scene) -> bool:
    return not scene.observe().failure


async def test_the_components_follow_an_engine_that_comes_goes_and_comes_otherwise(tmp_path: Path) -> None:
    clock, address = VirtualClock(now=1000), f"unix:{tmp_path}/engine"
    async with (
        external_scene("avatar", address, "secret", clock) as scene,
        serve_scene("avatar", scene, clock) as avatar,
    ):
        reaction = reaction_of(scene)

        def sizes() -> list[tuple[int, int, float]]:
            rungs = (each.rung for each in avatar.video.renditions("video/H264"))
            return [(rung.width, rung.height, rung.frame_rate) for rung in rungs if rung is not None]

        assert scene.observe().failure == f"no game engine is connected to {address}"
        assert reaction.condition() is ComponentStatus.ERROR
        assert await reaction.available_reactions() == ()

        hello = replace(HELLO, video=VideoShape(640, 360, 25, "i420"))
        first = await asyncio.to_thread(LinkClient.connect, address, hello)
        await until(lambda: is_there(scene))
        assert NOD in await reaction.available_reactions()
        assert sizes()[0] == (640, 360, 25)
        reaction.reaction_ref = NOD
        playing = asyncio.create_task(reaction.start())
        (command,) = await asyncio.to_thread(first.poll_commands, 5)
        assert isinstance(command, React)
        first.send_event(Completed(command.id, "OK"))
        await playing

        await asyncio.to_thread(first.close, "coffee")
        await until(lambda: not is_there(scene))
        assert scene.observe().failure == "the game engine is gone: coffee"
        assert reaction.condition() is ComponentStatus.ERROR

        hello = replace(HELLO, video=VideoShape(320, 240, 60), reactions=("dance",))
        second = await asyncio.to_thread(LinkClient.connect, address, hello)
        await until(lambda: is_there(scene))
        assert await reaction.available_reactions() == ("urn:x-rois:def:reaction:OpenRoIS::dance",)
        assert sizes()[0] == (320, 240, 60)
        await asyncio.to_thread(second.close)
        await until(lambda: not is_there(scene))

        encoding = replace(HELLO, video=VideoShape(640, 360, 30, "h264"))
        third = await asyncio.to_thread(LinkClient.connect, address, encoding)
        await until(lambda: is_there(scene))
        assert avatar.video.codecs() == ("video/H264",)
        with pytest.raises(CodecUnavailable):
            avatar.video.renditions("video/VP8")
        published = Published(avatar.video, "video", codecs=avatar.video.codecs)
        assert published.choose(("VP8", "H264")) == ("video/H264",)
        with pytest.raises(
            Unsupported, match="the pictures come encoded as video/H264, which the application does not"
        ):
            published.choose(("VP8", "VP9"))
        assert sizes()[0] == (640, 360, 30)
        await asyncio.to_thread(third.close)
