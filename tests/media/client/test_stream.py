"""A stream of an application while its gateway is away."""

import asyncio

from openrois_media.client.stream import ClientStream, ReceivedStream
from openrois_media.client.stream_state import Desire, Verb

from openrois.types.codes import StreamStatus
from tests.support.streaming import VirtualClock, settle


class Gateway:
    """What a stream needs of all streams: a connection that comes and goes, and a note of each look at it."""

    def __init__(self) -> None:
        self.is_there = True
        self.looks = 0
        self.connected = asyncio.Event()

    def ready(self) -> bool:
        self.looks += 1
        return self.is_there

    async def connect(self, stream: ClientStream) -> str:
        self.connected.set()
        return "stream"

    async def perform(self, verb: Verb, stream_id: str) -> None:
        raise AssertionError(f"nothing is asked for but a connection, not {verb}")

    def relocate(self, stream: ClientStream) -> None:
        pass


async def test_it_rests_until_the_gateway_is_back_however_long_its_next_attempt_is_due() -> None:
    gateway, clock = Gateway(), VirtualClock()
    stream = ReceivedStream("robot/camera", "video", gateway, clock)
    running = asyncio.create_task(stream.run())
    stream.want(Desire.RUNNING)
    await gateway.connected.wait()
    gateway.is_there = False
    stream.lost(None)
    clock.jump(60.0)
    await settle()
    gateway.looks = 0
    await settle()
    assert gateway.looks == 0
    gateway.connected.clear()
    gateway.is_there = True
    stream.retry_now()
    await gateway.connected.wait()
    await settle()
    assert stream.state.status is StreamStatus.STREAMING_NOT_RUNNING
    running.cancel()
    await asyncio.wait({running})
