import asyncio
import logging
from collections.abc import AsyncIterator
from dataclasses import replace

import pytest
from openrois_signaling.messages import Direction, MediaKind
from openrois_streaming.liveness import STALL, Verdict
from openrois_streaming.peer.peers import REPLACE_TIMEOUT
from openrois_streaming.peer.uplink import Uplink
from openrois_streaming.source.uplink_sink import UplinkSelector
from openrois_streaming.state import StreamStatus

from tests.support.streaming import VirtualClock, settle
from tests.support.viewing import Application, FakeInlet, FakeReception, FedPublisher, WirelessConnection

MICROPHONE, CAMERA = "engine/Audio", "engine/Video"


class Operator(Application):
    """An application that sends, on a connection without a network."""

    def __init__(self) -> None:
        super().__init__()
        self.publisher = FedPublisher()
        self.inlet = FakeInlet()

    def connect(self, stream_id: str, direction: Direction = "sendonly", kind: MediaKind = "audio") -> None:
        self.session.connect(
            stream_id,
            MICROPHONE if kind == "audio" else CAMERA,
            None if direction == "sendonly" else self.publisher,
            kind,
            direction=direction,
            inlet=None if direction == "recvonly" else self.inlet,
        )

    async def up(self, number: int = 0, **answers: str) -> WirelessConnection:
        """Answer the newest offer, sections as `m0="inactive"` say, and connect."""
        await settle()
        connection = WirelessConnection.made[number]
        connection.answers = {mid.removeprefix("m"): answered for mid, answered in answers.items()}  # type: ignore[misc]
        await self.answer()
        connection.become("connected")
        connection.answers_questions = True
        await settle()
        return connection

    def reception(self, connection: WirelessConnection, mid: int = 0) -> FakeReception:
        reception = connection.sections[mid].reception
        assert isinstance(reception, FakeReception)
        return reception

    async def send(self, connection: WirelessConnection, mid: int = 0, seconds: float = 0.5) -> None:
        for _ in range(round(seconds * 10)):
            self.reception(connection, mid).arrive(self.clock.now())
            await self.clock.advance(0.1)
        await settle()

    @property
    def last(self) -> tuple[str, str]:
        return self.told[-1]


@pytest.fixture
async def operator(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Operator]:
    WirelessConnection.stand_in(monkeypatch)
    operator = Operator()
    async with operator.session:
        yield operator
    assert operator.inlet.sources == {}
    assert all(
        not section.reception.passing
        for connection in WirelessConnection.made
        for section in connection.sections
        if isinstance(section.reception, FakeReception)
    )
    others = asyncio.all_tasks() - {asyncio.current_task()}
    assert [task.get_name() for task in others if "session" in task.get_name()] == []


async def test_a_way_is_plugged_in_while_it_is_there_and_read_while_it_is_wanted() -> None:
    clock, reception, inlet = VirtualClock(), FakeReception(), FakeInlet()
    uplink = Uplink(reception, UplinkSelector("s", inlet), clock)
    uplink.follow(there=True, wanted=False)
    assert (reception.passing, inlet.sources) == (False, {"s": reception.source})
    assert uplink.judge(clock.now()) is Verdict.UNDECIDED
    uplink.follow(there=True, wanted=True)
    uplink.follow(there=True, wanted=True)
    assert reception.passing
    reception.arrive(clock.now())
    assert uplink.judge(clock.now()) is Verdict.FLOWING
    assert uplink.judge(clock.now() + STALL) is Verdict.STALLED
    uplink.close()
    assert (reception.passing, inlet.sources) == (False, {})
    assert inlet.calls == [("plug", "s"), ("unplug", "s")]


async def test_an_uplink_counts_what_came_since_it_was_made() -> None:
    reception = FakeReception()
    reception.figures = replace(reception.figures, packets=10, packets_lost=1, concealed=0.5, jitter=0.001)
    uplink = Uplink(reception, UplinkSelector("s", FakeInlet()), VirtualClock())
    assert (uplink.figures.packets, uplink.figures.concealed) == (0, 0.0)
    reception.figures = replace(reception.figures, packets=15, packets_lost=3, jitter=0.002, playout_delay=0.03)
    assert (uplink.figures.packets, uplink.figures.packets_lost) == (5, 2)
    assert (uplink.figures.jitter, uplink.figures.playout_delay) == (0.002, 0.03)


async def test_microphone_runs_when_its_sound_arrives(operator: Operator) -> None:
    operator.connect("mic")
    connection = await operator.up()
    assert [(each.stream_id, each.direction) for each in operator.offers[0].streams] == [("mic", "sendonly")]
    assert connection.sections[0].transceiver.direction == "recvonly"
    assert operator.told == [("mic", "not_running")]
    await operator.send(connection)
    assert operator.last == ("mic", "running")
    await operator.clock.advance(STALL + 0.2)
    assert operator.last == ("mic", "not_running")


async def test_suspended_uplink_drops_packets_and_is_notified_before_resuming(operator: Operator) -> None:
    operator.connect("mic")
    connection = await operator.up()
    await operator.send(connection)
    operator.session.suspend("mic")
    await operator.send(connection)
    assert operator.last == ("mic", "suspended")
    assert not operator.reception(connection).passing
    assert "mic" in operator.inlet.sources
    operator.session.resume("mic")
    await settle()
    assert operator.last == ("mic", "not_running")
    await operator.send(connection)
    assert operator.last == ("mic", "running")
    assert operator.changes[-1].resumed
    assert len(operator.offers) == 1


async def test_conversation_runs_when_both_directions_flow(operator: Operator) -> None:
    operator.connect("talk", "sendrecv")
    connection = await operator.up()
    assert connection.sections[0].transceiver.direction == "sendrecv"
    await operator.send(connection)
    assert operator.last == ("talk", "not_running")
    for number in range(5):
        await operator.publisher.renditions("audio/opus")[0].show(keyframe=True)
        connection.report(number + 1)
        await operator.send(connection, seconds=0.1)
    assert operator.last == ("talk", "running")


async def test_a_refused_microphone_ends_its_stream_alone(operator: Operator, caplog: pytest.LogCaptureFixture) -> None:
    operator.connect("v", "recvonly", "video")
    operator.connect("mic")
    with caplog.at_level(logging.INFO):
        connection = await operator.up(m1="inactive")
    assert "the application answers inactive to the sendonly stream mic" in caplog.messages
    assert ("mic", "not_connected") in operator.told
    assert [change.stream_id for change in operator.changes if change.ended] == ["mic"]
    assert operator.session.stream_ids == ("v",)
    assert operator.byes == []
    offer = await operator.offered()
    assert (offer.generation, [each.stream_id for each in offer.streams]) == (2, ["v"])
    assert connection.sections[1].transceiver.direction == "inactive"
    await operator.up()
    operator.connect("mic2")
    await operator.up()
    assert [each.mid for each in operator.offers[-1].streams] == ["0", "1"]
    await operator.send(connection, 1)
    assert operator.last == ("mic2", "running")


async def test_a_conversation_without_the_microphone_goes_on_one_way(operator: Operator) -> None:
    operator.connect("talk", "sendrecv")
    connection = await operator.up(m0="recvonly")
    assert operator.inlet.calls == []
    for number in range(5):
        await operator.publisher.renditions("audio/opus")[0].show(keyframe=True)
        connection.report(number + 1)
        await operator.clock.advance(0.1)
    await settle()
    assert operator.last == ("talk", "running")
    operator.connect("w", "recvonly", "video")
    await operator.up()
    assert operator.inlet.sources == {"talk": operator.reception(connection).source}


async def test_a_conversation_that_is_not_listened_to_goes_on_the_other_way(operator: Operator) -> None:
    operator.connect("talk", "sendrecv")
    connection = await operator.up(m0="sendonly")
    await operator.send(connection)
    assert operator.last == ("talk", "running")
    assert operator.publisher.made == {}


async def test_a_section_is_taken_over_by_the_same_direction_only(operator: Operator) -> None:
    operator.connect("a", "recvonly")
    operator.connect("b", "sendonly")
    operator.connect("c", "sendrecv")
    await operator.up()
    for stream_id in "abc":
        operator.session.disconnect(stream_id)
    await operator.up()
    operator.connect("d", "sendrecv")
    operator.connect("e", "sendonly")
    await operator.up()
    assert [(each.mid, each.stream_id) for each in operator.offers[-1].streams] == [("1", "e"), ("2", "d")]


async def test_a_replacement_is_plugged_in_when_it_plays(operator: Operator) -> None:
    operator.connect("mic")
    old = await operator.up()
    await operator.send(old)
    operator.session.suspend("mic")
    operator.session.restart("engine/p1")
    new = await operator.up(1)
    assert operator.session.status("mic") is StreamStatus.SUSPENDED
    assert not operator.reception(new).passing
    operator.session.resume("mic")
    await operator.send(old)
    assert operator.inlet.sources == {"mic": operator.reception(old).source}
    await operator.send(new)
    assert operator.inlet.sources == {"mic": operator.reception(new).source}
    assert [bye.reason for bye in operator.byes] == ["it was replaced"]
    assert operator.inlet.calls == [("plug", "mic"), ("plug", "mic")]


async def test_a_silent_replacement_takes_over_in_the_end(operator: Operator) -> None:
    operator.connect("mic")
    await operator.up()
    operator.session.restart("engine/p1")
    new = await operator.up(1)
    await operator.clock.advance(REPLACE_TIMEOUT + 0.2)
    assert operator.inlet.sources == {"mic": operator.reception(new).source}


async def test_the_ends_of_a_stream_fit_its_direction(operator: Operator) -> None:
    for direction, publisher, inlet in (
        ("recvonly", None, None),
        ("recvonly", operator.publisher, operator.inlet),
        ("sendonly", operator.publisher, operator.inlet),
        ("sendonly", None, None),
        ("sendrecv", operator.publisher, None),
        ("sendrecv", None, operator.inlet),
    ):
        with pytest.raises(ValueError, match=f"a {direction} stream"):
            operator.session.connect("s", MICROPHONE, publisher, "audio", direction=direction, inlet=inlet)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="sendrecv is for audio alone"):
        operator.connect("s", "sendrecv", "video")
    assert operator.session.stream_ids == ()


async def test_application_cannot_resume_a_stream_held_by_the_engine(operator: Operator) -> None:
    operator.connect("a")
    operator.connect("v", "recvonly", "video")
    connection = await operator.up()
    await operator.send(connection)
    operator.session.hold(MICROPHONE)
    await settle()
    assert operator.last == ("a", "suspended")
    operator.session.resume("a")
    await operator.send(connection)
    assert operator.session.status("a") is StreamStatus.SUSPENDED
    assert operator.session.status("v") is StreamStatus.NOT_RUNNING
    operator.connect("b")
    await operator.up()
    assert operator.session.status("b") is StreamStatus.SUSPENDED
    operator.session.suspend("b")
    operator.session.release(MICROPHONE)
    await operator.send(connection)
    assert operator.session.status("a") is StreamStatus.RUNNING
    assert operator.session.status("b") is StreamStatus.SUSPENDED
    operator.session.resume("b")
    assert operator.session.status("b") is StreamStatus.NOT_RUNNING


async def test_stream_held_by_the_engine_stays_held_over_a_restart(operator: Operator) -> None:
    operator.connect("v", "recvonly", "video")
    await operator.up()
    operator.session.hold(CAMERA)
    operator.session.restart("engine/p1")
    new = await operator.up(1)
    await operator.clock.advance(REPLACE_TIMEOUT + 0.2)
    assert operator.session.peer_ids == ("engine/p2",)
    assert operator.session.status("v") is StreamStatus.SUSPENDED
    rendition = operator.publisher.renditions("video/VP8")[0]
    assert rendition.readers == 0
    operator.session.release(CAMERA)
    await settle()
    assert rendition.readers == 1
    await rendition.show(keyframe=True)
    new.report(1)
    await operator.clock.advance(0.2)
    assert operator.last == ("v", "running")
    assert operator.changes[-1].resumed
