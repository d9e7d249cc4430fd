"""Media of an application at a gateway that asks for tokens: what roles, scope and control let it receive and send."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import pytest
from openrois_streaming.clock import SystemClock
from openrois_streaming.source.shared_inlet import SharedInlet
from openrois_streaming.source.source import RawAudio, RawVideo
from openrois_streaming.synthetic import ColourBars, Tone

from openrois.client import OutOfResources, RoISError, Unsupported
from openrois.gateway.settings import GatewaySettings
from openrois.types.codes import StreamStatus
from tests.support.components import Lamp
from tests.support.loopback import PATIENCE
from tests.support.media_body import CAMERA, MICROPHONE, Body, application, body, read
from tests.support.streaming import FedSource
from tests.support.tokens import issue, key_file

pytestmark = pytest.mark.media

LAMP = "robot/lamp"


def token(**claims: object) -> str:
    return issue(time.time(), **claims)


def operator(subject: str = "alice") -> str:
    return token(sub=subject, scope=["robot/*"])


@pytest.fixture
async def robot(tmp_path: Path) -> AsyncIterator[Body]:
    settings = GatewaySettings(port=0, auth_keys=(key_file(tmp_path),))
    adapter = token(sub="robot", roles=["adapter"], scope=["robot/*"])
    async with body(settings, token=adapter, others=[Lamp()]) as one:
        yield one


async def until(so: Callable[[], object]) -> None:
    """Wait for what is not announced."""
    async with asyncio.timeout(PATIENCE):
        while not so():  # noqa: ASYNC110 - see above
            await asyncio.sleep(0.01)


async def arrives(*sinks: SharedInlet[RawVideo] | SharedInlet[RawAudio]) -> None:
    """Wait until each has something of an application."""
    async with asyncio.timeout(PATIENCE):
        for sink in sinks:
            async with sink.subscribe(1) as items:
                await items.get()


async def test_what_operates_a_body_sends_to_it_also_after_its_connection_was_lost(robot: Body) -> None:
    clock = SystemClock()
    async with (
        application(robot, operator()) as (client, media),
        client.component(LAMP).bound(),
        media.send(camera=ColourBars(160, 120, 15, clock=clock), microphone=Tone(clock=clock)) as sending,
        media.frames(CAMERA) as frames,
    ):
        await read(frames)
        await arrives(robot.screen, robot.speaker)
        peers = {peer for session in robot.sessions for peer in session.peer_ids}
        robot.relay.cut()
        await until(lambda: any(set(each.peer_ids) - peers for each in robot.sessions))
        await until(lambda: set(sending.status.values()) == {StreamStatus.STREAMING_RUNNING})
        await arrives(robot.screen, robot.speaker)
        assert sending.problem == ""


async def test_without_control_of_the_body_nothing_is_sent_and_the_refusal_says_what_to_bind(robot: Body) -> None:
    async with application(robot, operator()) as (_, media):
        with pytest.raises(OutOfResources, match="sending to robot needs control of it: bind one of its actuation"):
            async with media.send(camera=FedSource[RawVideo]()):
                pass
        async with media.frames(CAMERA) as frames:
            await read(frames)


async def test_what_loses_control_sends_no_more_and_goes_on_with_it(robot: Body) -> None:
    camera = ColourBars(160, 120, 15, clock=SystemClock())
    async with application(robot, operator()) as (client, media):
        lamp = client.component(LAMP)
        await lamp.bind()
        async with media.send(camera=camera) as sending:
            await arrives(robot.screen)
            await lamp.release()
            await until(lambda: "needs control" in sending.problem)
            assert robot.screen.stream_id is None
            await lamp.bind()
            await arrives(robot.screen)
            await until(lambda: sending.problem == "")


async def test_a_viewer_receives_and_may_not_send(robot: Body) -> None:
    viewer = token(roles=["viewer"], scope=["robot/*"])
    async with application(robot, viewer) as (_, media):
        async with media.frames(CAMERA) as frames, media.blocks(MICROPHONE) as blocks:
            await read(frames)
            await read(blocks)
        with pytest.raises(Unsupported, match="the roles of this application only allow receiving streams"):
            async with media.send(camera=FedSource[RawVideo]()):
                pass


async def test_out_of_scope_there_is_nothing_to_receive_or_to_send_to(robot: Body) -> None:
    async with application(robot, token(scope=["robot/lamp", MICROPHONE])) as (client, media):
        async with client.component(LAMP).bound(), media.send(microphone=Tone(clock=SystemClock())):
            await arrives(robot.speaker)
        with pytest.raises(Unsupported, match="no component takes the video of an application"):
            async with media.send(camera=FedSource[RawVideo]()):
                pass
        with pytest.raises(RoISError, match=CAMERA):
            await media.snapshot(CAMERA)


async def test_control_of_one_component_is_enough_for_all_of_its_body(robot: Body) -> None:
    async with (
        application(robot, operator("bob")) as (_, watching),
        application(robot, operator()) as (client, media),
        client.component(LAMP).bound(),
        media.send(camera=ColourBars(160, 120, 15, clock=SystemClock()), to=LAMP),
    ):
        await arrives(robot.screen)
        with pytest.raises(OutOfResources, match="sending to robot needs control of it"):
            async with watching.send(microphone=Tone(clock=SystemClock())):
                pass
