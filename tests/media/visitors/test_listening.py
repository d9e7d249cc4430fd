"""A visitor sends to a body over WebRTC, and a listener receives it from there, as far as the visitor consents."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from openrois_body.attention.attention import Attention
from openrois_body.attention.rule import LOUDEST
from openrois_body.components.visitors import Visitors
from openrois_media import Media, Stream
from openrois_media.devices import Camera, Microphone
from openrois_media.streams import AdapterStreams
from openrois_media.visitors.registry import VisitorRegistry
from openrois_streaming.clock import SystemClock
from openrois_streaming.source.source import RawAudio
from openrois_streaming.synthetic import ColourBars, Tone

from openrois import adapter
from openrois.aio.tasks import TaskScope
from openrois.client import BadParameter, Client, Unsupported
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.testing import FaultRelay
from openrois.types.codes import Purpose, StreamStatus
from tests.support.components import Lamp
from tests.support.loopback import PATIENCE, some_address
from tests.support.media_body import read
from tests.support.sounds import paced
from tests.support.tokens import issue, key_file

pytestmark = pytest.mark.media

LIVE, AGENT = Purpose.LIVE, Purpose.AGENT


def token(role: str) -> str:
    return issue(time.time(), sub=role, roles=[role], scope=["robot/*"], jti=role)


@dataclass
class Body:
    """A body that takes what visitors send, behind a gateway that asks for tokens."""

    url: str
    visitors: VisitorRegistry
    microphone: Microphone
    attention: Attention
    streams: AdapterStreams
    revocations: Path

    @asynccontextmanager
    async def application(self, role: str, url: str = "") -> AsyncIterator[Media]:
        async with Client(url or self.url, token=token(role)) as client, Media(client) as media:
            yield media

    @property
    def streams_count(self) -> int:
        """Streams of all applications, sent and received."""
        return sum(len(session.stream_ids) for session in self.streams.interface.sessions)


@pytest.fixture
async def body(tmp_path: Path) -> AsyncIterator[Body]:
    revocations = tmp_path / "revoked"
    revocations.write_text("")
    settings = GatewaySettings(port=0, auth_keys=(key_file(tmp_path),), auth_revocations=revocations)
    (tmp_path / "token").write_text(token("adapter"))
    clock = SystemClock()
    visitors = VisitorRegistry("robot", clock)
    uplinks = {
        "video_streaming": Stream(uplink=visitors.cameras),
        "audio_streaming": Stream(uplink=visitors.microphones),
    }
    streams = AdapterStreams("robot", uplinks, clock=clock)
    microphone = Microphone(clock, visitors)
    attention = Attention(visitors, microphone, Camera(visitors), clock)
    with some_address():
        async with (
            TaskScope() as tasks,
            run_gateway(settings) as gateway,
            adapter.serve(
                *streams.components.values(),
                Visitors("robot", visitors, attention),
                Lamp(),
                engine_id="robot",
                gateway=gateway.url,
                token_file=tmp_path / "token",
                extension=streams,
            ),
        ):
            await until(lambda: gateway.engine.components)
            tasks.start(microphone.listen())
            tasks.start(attention.run())
            url = gateway.url.replace("http", "ws", 1)
            yield Body(url, visitors, microphone, attention, streams, revocations)


async def until(so: Callable[[], object]) -> None:
    """Wait for what is not announced."""
    async with asyncio.timeout(PATIENCE):
        while not so():  # noqa: ASYNC110 - see above
            await asyncio.sleep(0.01)


class Noise:
    """Noise of one loudness without a break, in blocks of 20 ms."""

    def __init__(self, level: int) -> None:
        self._block = np.random.default_rng(1).integers(-level, level, (960, 1), np.int16)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawAudio]]:
        yield paced(lambda _number: self._block)


async def test_of_two_visitors_the_loudest_is_heard(body: Body) -> None:
    heard: list[RawAudio] = []
    body.microphone.sound_received.add(heard.append)
    body.attention.set_mode(LOUDEST)
    async with (
        body.application("visitor") as quiet,
        quiet.send(microphone=Noise(40), consent=[LIVE]),
        body.application("visitor") as loud,
        loud.send(microphone=Noise(12_000), consent=[LIVE]),
    ):
        await until(lambda: len(body.visitors.present) == 2)
        first, second = (each.visitor_ref for each in body.visitors.present)
        await until(lambda: heard)
        assert heard[0].sender == first
        await until(lambda: body.attention.attended == second)
        await until(lambda: heard[-1].sender == second)
        changed_at = next(place for place, each in enumerate(heard) if each.sender == second)
        assert {each.sender for each in heard[changed_at:]} == {second}


async def test_a_listener_hears_and_sees_a_visitor_that_consents_and_no_more_when_it_withdraws(body: Body) -> None:
    clock = SystemClock()
    async with (
        body.application("visitor") as sender,
        sender.send(
            camera=ColourBars(160, 120, 15, clock=clock), microphone=Tone(clock=clock), consent=[LIVE, AGENT]
        ) as sending,
        body.application("listener") as listener,
    ):
        (visitor,) = await listener.visitors("robot", purposes=[AGENT])
        assert (visitor.devices, visitor.consent, visitor.is_attended) == (
            {"microphone", "camera"},
            {"live", "agent"},
            True,
        )
        assert visitor.visitor_ref == body.visitors.present[0].visitor_ref
        async with visitor.microphone.blocks() as blocks, visitor.camera.frames() as frames:
            # The tone sounds once a second.
            while not np.any(np.abs((await read(blocks))[0].samples) > 100):
                pass
            seen = await read(frames, 2)
            assert seen[0].data.shape == (120, 160, 3)
            assert (await visitor.camera.snapshot())[:2] == b"\xff\xd8"
            await sending.consent(LIVE)
            assert sending.visitor_ref == visitor.visitor_ref
            await until(lambda: blocks.status is StreamStatus.STREAMING_NOT_CONNECTED)
            await until(lambda: "does not consent to agent" in blocks.problem + frames.problem)
            # Given again, it goes on by itself.
            await sending.consent(LIVE, AGENT)
            await until(lambda: blocks.status is StreamStatus.STREAMING_RUNNING)
            await read(blocks)
        await sending.consent()
        assert body.visitors.present[0].consent.purposes == set()


async def test_what_waits_at_a_listener_is_dropped_with_the_consent_to_it(body: Body) -> None:
    clock = SystemClock()
    async with (
        body.application("visitor") as sender,
        sender.send(microphone=Tone(clock=clock), consent=[LIVE]) as sending,
        body.application("listener") as listener,
    ):
        (visitor,) = await listener.visitors("robot", purposes=[LIVE])
        async with visitor.microphone.blocks() as blocks:
            # A second of sound waits for it.
            await until(lambda: blocks.dropped)
            await sending.consent()
            await until(lambda: blocks.status is StreamStatus.STREAMING_NOT_CONNECTED)
            again = clock.now()
            await sending.consent(LIVE)
            assert (await read(blocks))[0].local_time >= again


async def test_a_visitor_that_comes_back_has_consented_to_what_it_said_last(body: Body) -> None:
    async with (
        FaultRelay(body.url) as relay,
        body.application("visitor", relay.url) as sender,
        sender.send(microphone=Tone(clock=SystemClock()), consent=[LIVE, AGENT]) as sending,
    ):
        await sending.consent(LIVE)
        before = body.visitors.present[0].visitor_ref
        relay.cut()
        # To the body it is another visitor, of whom nothing is assumed.
        await until(lambda: [each for each in body.visitors.present if each.visitor_ref != before])
        assert body.visitors.present[-1].consent.purposes == {LIVE}
        await sending.consent()
        relay.cut()
        await until(lambda: body.visitors.present and not body.visitors.present[-1].consent.purposes)


async def test_nothing_of_it_passes_the_gateway(body: Body) -> None:
    """What a visitor sends after the cables of all applications to the gateway were pulled arrives as before."""
    clock = SystemClock()
    async with (
        FaultRelay(body.url) as relay,
        body.application("visitor", relay.url) as sender,
        sender.send(camera=ColourBars(160, 120, 15, clock=clock), microphone=Tone(clock=clock), consent=[LIVE]),
        body.application("listener", relay.url) as listener,
    ):
        (visitor,) = await listener.visitors("robot", purposes=[LIVE])
        async with visitor.microphone.blocks() as blocks, visitor.camera.frames() as frames:
            await read(blocks)
            await read(frames)
            relay.half_open()
            pulled, swallowed = clock.now(), relay.swallowed
            while (await read(blocks))[0].local_time < pulled + 1.0:
                pass
            while (await read(frames))[0].local_time < pulled + 1.0:
                pass
            # No more than a few messages of the wire would have passed: a second of sound alone is 4 kB.
            assert relay.swallowed - swallowed < 4_000


async def test_a_listener_whose_token_is_revoked_receives_no_more(body: Body) -> None:
    async with (
        body.application("visitor") as sender,
        sender.send(microphone=Tone(clock=SystemClock()), consent=[LIVE]),
        Client(body.url, token=token("listener"), reconnect=None) as client,
        Media(client) as listener,
    ):
        (visitor,) = await listener.visitors("robot", purposes=[LIVE])
        async with visitor.microphone.blocks() as blocks:
            await read(blocks)
            assert body.streams_count == 2
            body.revocations.write_text("jti listener\n")
            await until(lambda: body.streams_count == 1)


async def test_a_listener_says_what_it_is_for_and_gets_nothing_else(body: Body) -> None:
    async with (
        body.application("visitor") as sender,
        sender.send(microphone=Tone(clock=SystemClock()), consent=[LIVE]),
        body.application("listener") as listener,
        body.application("operator") as operator,
    ):
        with pytest.raises(ValueError, match="give one purpose at least"):
            await listener.visitors("robot", purposes=[])
        (visitor,) = await listener.visitors("robot/lamp", purposes=[LIVE, Purpose.RECORDING])
        with pytest.raises(Unsupported, match="does not consent to recording"):
            async with visitor.microphone.blocks():
                pass
        with pytest.raises(ValueError, match="a visitor's microphone has audio, not video"):
            async with listener.frames(visitor.microphone):
                pass
        (visitor,) = await listener.visitors("robot", purposes=[LIVE])
        with pytest.raises(Unsupported, match="sends no camera"):
            await visitor.camera.snapshot()
        (visitor,) = await operator.visitors("robot", purposes=[LIVE])
        with pytest.raises(Unsupported, match="only the role listener"):
            async with visitor.microphone.blocks():
                pass


async def test_a_visitor_states_its_consent_and_needs_no_lease(body: Body) -> None:
    tone = Tone(clock=SystemClock())
    async with body.application("visitor") as sender, body.application("listener") as listener:
        with pytest.raises(BadParameter, match="set consent in transport_parameters"):
            async with sender.send(microphone=tone):
                pass
        assert await listener.visitors("robot", purposes=[LIVE]) == ()
        async with sender.send(microphone=tone, consent=[], to="robot") as sending:
            await until(lambda: body.visitors.present)
            # Nothing is decoded that is for nothing.
            assert body.visitors.present[0].microphone.stream_id is None
            await sending.consent(LIVE)
            await until(lambda: body.visitors.present[0].microphone.stream_id is not None)
        await until(lambda: not body.visitors.present)


async def test_a_body_that_tells_no_visitors_apart_says_so(body: Body) -> None:
    async with body.application("listener") as listener:
        with pytest.raises(Unsupported, match="other tells no visitors apart"):
            await listener.visitors("other", purposes=[LIVE])
