"""The moving components over a game engine that comes, cannot walk, goes, and comes back with a figure that can."""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from openrois_avatar.link.client import LinkClient
from openrois_avatar.link.messages import Completed, Halt, Place, Reached, Walk
from openrois_avatar.scene import external_scene
from openrois_body.components.navigation import Navigation

from openrois.errors import ComponentFailed
from openrois.testing import harness
from openrois.types.codes import ComponentStatus
from tests.support.avatar_link import HELLO
from tests.support.streaming import VirtualClock, settle


async def until(happened: Callable[[], bool]) -> None:
    async with asyncio.timeout(60):
        while not happened():
            await settle()


async def test_components_follow_the_capabilities_of_each_engine(tmp_path: Path) -> None:
    address = f"unix:{tmp_path}/engine"

    async def join(walks: bool) -> LinkClient:
        return await asyncio.to_thread(LinkClient.connect, address, replace(HELLO, walks=walks))

    async with (
        external_scene("avatar", address, "secret", VirtualClock()) as scene,
        harness(*scene.components, engine_id="avatar") as client,
    ):
        (navigation,) = (each for each in scene.components if isinstance(each, Navigation))

        def status() -> ComponentStatus:
            return navigation.status

        application = client.component("avatar/navigation")
        assert status() is ComponentStatus.ERROR

        lame = await join(walks=False)
        await until(lambda: not scene.observe().failure)
        assert status() is ComponentStatus.ERROR
        await asyncio.to_thread(lame.close)
        await until(lambda: bool(scene.observe().failure))

        for ends in ("by dying", "by arriving"):
            engine = await join(walks=True)
            await until(lambda: not scene.observe().failure)
            assert status() is ComponentStatus.ERROR, "it would not know where it goes from"
            engine.send_event(Place(0.0, 0.0, 0.0))
            await until(lambda: scene.place() is not None)
            assert status() is ComponentStatus.READY
            async with application.bound():
                await application.set_parameter(target_positions=("1,0",))
                going = asyncio.ensure_future(application.command("start"))
                (walk,) = await asyncio.to_thread(engine.poll_commands, 5)
                assert isinstance(walk, Walk)
                if ends == "by dying":
                    await asyncio.to_thread(engine.close, "a fault")
                    with pytest.raises(ComponentFailed, match="the body is disconnected"):
                        await going
                    assert (status(), scene.place()) == (ComponentStatus.ERROR, None)
                    continue
                engine.send_event(Reached(walk.id, 0))
                engine.send_event(Completed(walk.id, "OK"))
                await going
                assert status() is ComponentStatus.READY
                going = asyncio.ensure_future(application.command("start"))
                (walk,) = await asyncio.to_thread(engine.poll_commands, 5)
                await application.command("stop")
                assert await asyncio.to_thread(engine.poll_commands, 5) == [Halt()]
                going.cancel()
            await asyncio.to_thread(engine.close)
