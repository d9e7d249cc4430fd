"""The moving components over the figure of a real embedded game engine."""

import asyncio
from importlib import import_module
from math import dist

import pytest
from openrois_avatar.link.messages import Floor, Place, Things
from openrois_avatar.scene import embedded_scene
from openrois_body.motion.wayfinding import BODY
from openrois_streaming.clock import SystemClock

from openrois.client.components import Move, Navigation
from openrois.errors import ComponentFailed
from openrois.testing import harness
from tests.support.floors import room_at


@pytest.mark.engine
async def test_figure_navigates_round_the_furniture_and_moves_back() -> None:
    works, hint = import_module("openrois_avatar.engines.puppet").available()
    if not works:
        pytest.skip(hint)
    async with (
        asyncio.timeout(50),
        embedded_scene(
            "avatar", "openrois_avatar.engines.puppet", SystemClock(), arguments=("--size", "640x360")
        ) as scene,
        harness(*scene.components, engine_id="avatar") as client,
    ):
        world = scene.world
        assert world is not None
        known = asyncio.Event()
        track: list[Place] = []

        def note(change: Place | Floor | Things | None) -> None:
            if isinstance(change, Place):
                track.append(change)
            if world.floor is not None and world.place is not None and world.things:
                known.set()

        world.changed.add(note)
        note(None)
        await known.wait()
        assert {"table", "stool"} <= {thing.name for thing in world.things}
        navigation, move = await client.find(Navigation), await client.find(Move)
        async with navigation.bound(), move.bound(), navigation.reached_target() as reached:
            # The stool is in the straight way there.
            await navigation.set(target_positions=("-2.7,0.7",), routing_policy="distance")
            await navigation.start()
            assert (await anext(aiter(reached))).is_final_target
            floor, place = world.floor, world.place
            assert floor is not None
            assert place is not None
            assert dist((place.x, place.y), (-2.7, 0.7)) < 0.01
            assert min(room_at(floor, (each.x, each.y)) for each in track) > BODY - 0.01
            await move.set(line=(1000, 0))
            with pytest.raises(ComponentFailed, match="an obstacle is in the way"):
                await move.start()
            await move.set(line=(-400, 0))
            await move.start()
            after = world.place
            assert after is not None
            assert dist((place.x, place.y), (after.x, after.y)) == pytest.approx(0.4, abs=0.01)
