"""The parts of the avatar: what acts names its part, and the whole part has one holder."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from openrois_avatar.adapter import serve_scene
from openrois_avatar.scene import external_scene
from openrois_streaming.clock import SystemClock

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.session.session import EngineHost
from openrois.types.codes import ComponentFunction
from tests.support.authorization import Place, principal

PARTS = {
    "speech_synthesizer": "voice",
    "speech_stream": "voice",
    "dialogue": "voice",
    "speech_progress": "voice",
    "gaze": "gaze",
    "reaction": "gesture",
    "teleoperation": "legs",
    "navigation": "legs",
    "follower": "legs",
    "move": "legs",
}


@asynccontextmanager
async def avatar(folder: Path) -> AsyncIterator[EngineHost]:
    clock = SystemClock()
    async with (
        external_scene("avatar", f"unix:{folder}/engine", "secret", clock) as scene,
        serve_scene("avatar", scene, clock) as served,
    ):
        yield served.host


@pytest.fixture
async def here(tmp_path: Path) -> AsyncIterator[Place]:
    """The avatar behind a gateway."""
    engine = Engine("gateway")
    async with avatar(tmp_path) as host, TaskScope() as tasks:
        await engine.attach(host.engine)
        yield Place(EngineHost(engine, tasks), {})


async def test_what_acts_names_its_part(tmp_path: Path) -> None:
    async with avatar(tmp_path) as host:
        profiles = host.engine.directory.component_profiles.values()
    acting = {each.name: each.part for each in profiles if each.function is ComponentFunction.ACTUATION}
    assert acting == PARTS
    assert {each.part for each in profiles if each.function is not ComponentFunction.ACTUATION} == {None}


@pytest.mark.parametrize(
    ("wanted", "held"),
    [("teleoperation", "navigation"), ("move", "teleoperation"), ("speech_stream", "speech_synthesizer")],
)
async def test_a_part_is_taken_whole_or_not_at_all(here: Place, wanted: str, held: str) -> None:
    operator = principal("operator", "*", subject="ann", rank="person"), principal("operator", "*", subject="program")
    async with here.application(operator[0]) as ann, here.application(operator[1]) as program:
        assert await program.code("rois.command.bind", {"component_ref": f"avatar/{held}"}) == "OK"
        assert await ann.code("rois.command.bind", {"component_ref": f"avatar/{wanted}"}) == "OUT_OF_RESOURCES"
        assert await ann.code("openrois.lease.borrow", {"component_ref": f"avatar/{wanted}"}) == "OK"
        leases = here.host.leases.model.holding
        of_part = [name for name, part in PARTS.items() if part == PARTS[wanted]]
        holders = {leases.holder(f"avatar/{name}") for name in of_part}
        assert len({holder for holder, _ in filter(None, holders)}) == 1
        epochs = [each[1] for each in holders if each is not None]
        assert len(set(epochs)) == len(of_part), "an epoch of its own each"
        # Of the other parts nothing has changed hands.
        assert all(leases.holder(f"avatar/{name}") is None for name in PARTS if name not in of_part)
