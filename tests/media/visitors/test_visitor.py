"""What a visitor sends passes one gate: nothing that it does not consent to is decoded, delivered or kept."""

import asyncio
from collections.abc import AsyncIterator

import numpy as np
import pytest
from openrois_media.uplinks import AudioUplink
from openrois_media.visitors.registry import MAX_VISITORS, VisitorRegistry
from openrois_media.visitors.visitor import ConsentedSource
from openrois_streaming.source.source import RawAudio

from openrois.contract import Client
from openrois.errors import OutOfResources, Unsupported
from openrois.types.codes import Purpose
from tests.support.streaming import FedSource, VirtualClock, settle

LIVE, RECOGNITION, AGENT = frozenset({Purpose.LIVE}), frozenset({Purpose.RECOGNITION}), frozenset({Purpose.AGENT})
BOTH = LIVE | RECOGNITION


def application(name: str = "ann") -> Client:
    return Client(name, lambda _method, _params: None)


def block(at: float, level: int = 1000) -> RawAudio:
    """20 ms of sound."""
    return RawAudio(np.full((960, 2), level, np.int16), at)


class Sender:
    """A visitor that sends a microphone, and its source."""

    def __init__(self, visitors: VisitorRegistry, consent: frozenset[Purpose] | None = BOTH, name: str = "ann") -> None:
        self.client = application(name)
        self.visitors = visitors
        self.sink = visitors.sink(self.client, visitors.microphones, "audio")
        self.source: FedSource[RawAudio] = FedSource()
        self.stream_id = f"{name}/microphone"
        visitors.add_stream(self.client, self.stream_id, self.sink, consent)
        self.sink.plug(self.stream_id, self.source)
        self.visitor = self.sink.visitor

    def consent(self, *purposes: Purpose) -> None:
        self.visitors.set_consent(self.client, self.stream_id, frozenset(purposes))


class Reader:
    """A reader that takes all that it gets, or nothing while it is `slow`."""

    def __init__(self, source: ConsentedSource[RawAudio]) -> None:
        self.got: list[RawAudio] = []
        self.may_read = asyncio.Event()
        self.may_read.set()
        self._reading = asyncio.ensure_future(self._read(source))

    async def _read(self, source: ConsentedSource[RawAudio]) -> None:
        async with source.open() as items:
            async for item in items:
                self.got.append(item)
                await self.may_read.wait()

    async def end(self) -> None:
        self._reading.cancel()
        await asyncio.wait({self._reading})

    @property
    def times(self) -> list[float]:
        """Capture times of what it got."""
        return [each.captured_at for each in self.got]


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


@pytest.fixture
def visitors(clock: VirtualClock) -> VisitorRegistry:
    return VisitorRegistry("robot", clock)


@pytest.fixture
async def ann(visitors: VisitorRegistry) -> Sender:
    return Sender(visitors)


@pytest.fixture
async def recogniser(ann: Sender) -> AsyncIterator[Reader]:
    reader = Reader(ann.visitor.source("audio", RECOGNITION))
    await settle()
    yield reader
    await reader.end()
    await settle()
    assert not ann.source.is_open


async def test_a_reader_gets_what_is_consented_to_and_it_names_its_sender(ann: Sender, recogniser: Reader) -> None:
    await ann.source.feed(block(0.0), block(0.02))
    assert recogniser.times == [0.0, 0.02]
    assert {each.sender for each in recogniser.got} == {ann.visitor.visitor_ref}


async def test_from_the_next_block_on_nothing_is_delivered_after_a_withdrawal(
    ann: Sender, recogniser: Reader, clock: VirtualClock
) -> None:
    await ann.source.feed(block(0.0))
    ann.consent(Purpose.LIVE)
    await ann.source.feed(block(0.02), block(0.04))
    assert recogniser.times == [0.0]
    clock.jump(1.0)
    ann.consent(Purpose.LIVE, Purpose.RECOGNITION)
    # What was on its way since before is not delivered later.
    await ann.source.feed(block(clock.now() - 0.02), block(clock.now()))
    assert recogniser.times == [0.0, clock.now()]


async def test_what_waits_for_a_slow_reader_is_dropped(ann: Sender, recogniser: Reader, clock: VirtualClock) -> None:
    recogniser.may_read.clear()
    await ann.source.feed(block(0.0), block(0.02), block(0.04))
    ann.consent()
    ann.consent(Purpose.RECOGNITION)
    recogniser.may_read.set()
    clock.jump(1.0)
    await settle()
    assert recogniser.times == [0.0]


async def test_without_any_consent_nothing_is_decoded(ann: Sender, recogniser: Reader) -> None:
    assert ann.source.is_open
    ann.consent()
    await settle()
    assert not ann.source.is_open
    assert ann.visitor.microphone.stream_id is None
    ann.consent(Purpose.AGENT)
    await settle()
    assert ann.source.is_open


async def test_readers_of_one_purpose_do_not_lose_what_is_withdrawn_for_another(ann: Sender) -> None:
    live, recognising = (Reader(ann.visitor.source("audio", each)) for each in (LIVE, RECOGNITION))
    await settle()
    await ann.source.feed(block(0.0))
    ann.consent(Purpose.LIVE)
    await ann.source.feed(block(0.02))
    assert (live.times, recognising.times) == ([0.0, 0.02], [0.0])
    assert ann.source.opened == 1
    for reader in (live, recognising):
        await reader.end()


async def test_a_sender_that_states_nothing_is_heard_live_and_recognised_and_nothing_else(
    visitors: VisitorRegistry,
) -> None:
    sender = Sender(visitors, None)
    assert sender.visitor.consent.purposes == BOTH
    # A second device that states nothing changes nothing.
    sender.consent(Purpose.AGENT)
    camera = visitors.sink(sender.client, visitors.cameras, "video")
    visitors.add_stream(sender.client, "ann/camera", camera, None)
    assert sender.visitor.consent.purposes == AGENT


async def test_microphone_and_camera_of_one_application_are_one_visitor(visitors: VisitorRegistry, ann: Sender) -> None:
    camera = visitors.sink(ann.client, visitors.cameras, "video")
    visitors.add_stream(ann.client, "ann/camera", camera, BOTH)
    assert camera.visitor is ann.visitor
    assert visitors.present == (ann.visitor,)
    assert ann.visitor.visitor_ref.startswith("urn:x-rois:def:visitor:OpenRoIS::robot/")
    with pytest.raises(OutOfResources, match="this application sends a camera to robot already"):
        visitors.sink(ann.client, visitors.cameras, "video")
    visitors.end_stream(ann.client, ann.stream_id)
    visitors.end_stream(ann.client, "ann/camera")
    assert visitors.present == ()
    assert Sender(visitors).visitor is not ann.visitor
    again = visitors.sink(ann.client, visitors.microphones, "audio")
    assert again.visitor is ann.visitor


async def test_a_ninth_visitor_is_told_that_there_are_eight(visitors: VisitorRegistry) -> None:
    senders = [Sender(visitors, name=f"app {number}") for number in range(MAX_VISITORS)]
    assert len({each.visitor.visitor_ref for each in senders}) == MAX_VISITORS == 8
    with pytest.raises(OutOfResources, match="8 visitors send to robot, which is the limit: wait until one has left"):
        Sender(visitors)
    assert visitors.refused == 1
    visitors.sink(senders[0].client, visitors.cameras, "video")
    visitors.forget_client(senders[3].client)
    Sender(visitors)


async def test_of_one_that_has_left_nothing_is_admitted(visitors: VisitorRegistry, ann: Sender) -> None:
    ref, gone = ann.visitor.visitor_ref, []
    visitors.withdrawn.add(lambda visitor, purposes: gone.append((visitor.visitor_ref, purposes)))
    assert visitors.admits(ref, LIVE, 0.0)
    assert visitors.find(ref) is ann.visitor
    visitors.forget_client(ann.client)
    assert gone == [(ref, BOTH)]
    assert not visitors.admits(ref, LIVE, 0.0)
    assert not visitors.holds(ref, LIVE)
    with pytest.raises(Unsupported, match="it has left, or never came"):
        visitors.find(ref)


async def test_consent_ends_with_the_last_stream_and_is_stated_anew_for_the_next(
    visitors: VisitorRegistry, clock: VirtualClock, ann: Sender, recogniser: Reader
) -> None:
    ref, gone = ann.visitor.visitor_ref, []
    visitors.withdrawn.add(lambda visitor, purposes: gone.append((visitor.visitor_ref, purposes)))
    ann.consent(*Purpose)
    recogniser.may_read.clear()
    await ann.source.feed(block(0.0), block(0.02))
    visitors.end_stream(ann.client, ann.stream_id)
    assert gone == [(ref, frozenset(Purpose))]
    assert not visitors.admits(ref, LIVE, clock.now())
    assert not visitors.holds(ref, LIVE)
    clock.jump(1.0)
    sink = visitors.sink(ann.client, visitors.microphones, "audio")
    visitors.add_stream(ann.client, "ann/again", sink, None)
    assert sink.visitor is ann.visitor
    assert ann.visitor.consent.purposes == BOTH
    # What was captured before it left stays out.
    assert not visitors.admits(ref, LIVE, clock.now() - 0.5)
    assert visitors.may_keep(ref)
    recogniser.may_read.set()
    await settle()
    assert recogniser.times == [0.0]


async def test_media_of_the_body_itself_need_no_consent(visitors: VisitorRegistry) -> None:
    assert visitors.admits("", RECOGNITION, 0.0)
    assert visitors.holds("", RECOGNITION)


async def test_consent_is_stated_by_the_sender_alone(visitors: VisitorRegistry, ann: Sender) -> None:
    for client, stream_id in ((application("bob"), ann.stream_id), (ann.client, "ann/picture")):
        with pytest.raises(Unsupported, match="name one that is sent"):
            visitors.set_consent(client, stream_id, AGENT)
    assert ann.visitor.consent.purposes == BOTH


async def test_an_uplink_of_one_sender_at_a_time_gets_what_is_consented_to_be_live(
    visitors: VisitorRegistry, clock: VirtualClock
) -> None:
    speaker, source, client = AudioUplink(), FedSource[RawAudio](), application()
    sink = visitors.sink(client, speaker, "audio")
    visitors.add_stream(client, "ann/1", sink, RECOGNITION)
    sink.plug("ann/1", source)
    assert speaker.stream_id is None
    visitors.set_consent(client, "ann/1", BOTH)
    assert speaker.stream_id == "ann/1"
    async with speaker.subscribe() as blocks:
        await settle()
        clock.jump(1.0)
        visitors.set_consent(client, "ann/1", frozenset())
        visitors.set_consent(client, "ann/1", LIVE)
        await settle()
        await source.feed(block(clock.now() - 0.5), block(clock.now()))
        assert (await blocks.get()).captured_at == clock.now()
    visitors.set_consent(client, "ann/1", frozenset())
    assert speaker.stream_id is None
    sink.unplug("another")
    sink.unplug("ann/1")
