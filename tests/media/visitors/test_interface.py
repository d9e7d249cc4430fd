"""Visitors and listeners at the Streaming Interface of an adapter."""

import gc
import itertools
import json
import weakref
from collections.abc import AsyncIterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_media.stream_requests import TransportParameters, read_parameter
from openrois_media.streaming_interface import Published, StreamingInterface
from openrois_media.visitors.figures import VisitorFigures
from openrois_media.visitors.registry import MAX_VISITORS, VisitorRegistry
from openrois_media.visitors.relay import MAX_RELAYED_CAMERAS, MAX_RELAYED_MICROPHONES

from openrois.contract import Client
from openrois.errors import BadParameter, OutOfResources, RoISError, Unsupported
from openrois.types.codes import Purpose
from openrois.types.messages import Parameter
from openrois.types.streams import MAX_PURPOSES
from tests.media.test_streaming_interface import OK, Caller
from tests.support.streaming import VirtualClock, settle
from tests.support.viewing import FakeInlet, FedPublisher, WirelessConnection

VIDEO, AUDIO, SPEAKER = "robot/video_streaming", "robot/audio_streaming", "robot/speaker"


class Stage:
    """The streams of a body to which visitors send, and which has a loudspeaker for one application."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.visitors = VisitorRegistry("robot", self.clock)
        published = {
            VIDEO: Published(FedPublisher(), "video", self.visitors.cameras),
            AUDIO: Published(FedPublisher(), "audio", self.visitors.microphones),
            SPEAKER: Published(None, "audio", FakeInlet()),
        }
        self.streams = StreamingInterface("robot", published, self.clock, visitors=self.visitors)


class Application(Caller):
    """An application that says what the gateway lets through."""

    def __init__(self, stage: Stage, name: str) -> None:
        self.told = []
        self._streams = stage.streams
        self.client = Client(name, lambda method, params: self.told.append((method, params)))

    async def stream(
        self, component_ref: str, role: str | None = None, codecs: tuple[str, ...] | None = None, **transport: Any
    ) -> str:
        told = {"transport_parameters": transport, "encoding_parameters": {} if codecs is None else {"codecs": codecs}}
        parameters = [
            {"name": name, "data_type_ref": "String", "value": json.dumps(members)} for name, members in told.items()
        ]
        more = {} if role is None else {"role": role}
        answer = await self.ask(
            "rois.stream.connect_stream", component_ref=component_ref, parameters=parameters, **more
        )
        return str(answer["stream_id"])

    async def send(self, component_ref: str = AUDIO, consent: Any = ("live",)) -> str:
        return await self.stream(component_ref, "visitor", direction="sendonly", consent=consent)

    async def forget(self, stage: Stage) -> None:
        await stage.streams.forget_client(self.client)

    async def listen(self, visitor_ref: str, component_ref: str = AUDIO, purposes: Any = ("live",)) -> str:
        return await self.stream(component_ref, "listener", visitor_ref=visitor_ref, purposes=purposes)


@pytest.fixture
async def stage(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Stage]:
    WirelessConnection.stand_in(monkeypatch)
    stage = Stage()
    async with stage.streams.sessions:
        yield stage


@pytest.fixture
def ann(stage: Stage) -> Application:
    return Application(stage, "ann")


@pytest.fixture
def eve(stage: Stage) -> Application:
    return Application(stage, "eve")


def refs(stage: Stage) -> list[str]:
    return [each.visitor_ref for each in stage.visitors.present]


async def test_several_applications_send_to_one_component_each_as_a_visitor(stage: Stage, ann: Application) -> None:
    bob = Application(stage, "bob")
    await ann.send(AUDIO, ["live", "recognition"])
    await ann.send(VIDEO, ["live", "recognition"])
    await bob.stream(AUDIO, direction="sendrecv")
    first, second = stage.visitors.present
    assert first.visitor_ref != second.visitor_ref
    assert (first.sends("video"), second.sends("video"), second.sends("audio")) == (True, False, True)
    assert first.consent.purposes == second.consent.purposes == {Purpose.LIVE, Purpose.RECOGNITION}


async def test_consent_is_stated_anew_while_it_is_sent(stage: Stage, ann: Application) -> None:
    stream_id = await ann.send()
    told = {**OK, "visitor_ref": refs(stage)[0]}
    assert await ann.ask("rois.stream.set_consent", stream_id=stream_id, consent=["agent"]) == told
    assert stage.visitors.present[0].consent.purposes == {Purpose.AGENT}
    assert await ann.ask("rois.stream.set_consent", stream_id=stream_id, consent=[]) == told
    assert stage.visitors.present[0].consent.purposes == set()
    for wrong in (["everything"], "live", None, ["live"] * 17):
        with pytest.raises(BadParameter):
            await ann.ask("rois.stream.set_consent", stream_id=stream_id, consent=wrong)


@pytest.mark.parametrize("consent", [["everything"], "live", [1], {"live": True}, ["live"] * 17])
async def test_what_is_no_consent_is_refused_before_anything_is_sent(
    stage: Stage, ann: Application, consent: Any
) -> None:
    with pytest.raises(BadParameter, match="consent"):
        await ann.send(AUDIO, consent)
    assert refs(stage) == []


@given(st.recursive(st.none() | st.booleans() | st.text() | st.sampled_from(Purpose), st.lists, max_leaves=20))
def test_whatever_is_stated_is_a_list_of_purposes_or_refused(stated: Any) -> None:
    text = json.dumps({"consent": stated, "purposes": stated})
    parameter = Parameter(name="transport_parameters", data_type_ref="string", value=text)
    try:
        read = read_parameter((parameter,), "transport_parameters", TransportParameters)
    except BadParameter:
        assert not (isinstance(stated, list) and len(stated) <= MAX_PURPOSES and set(map(str, stated)) <= set(Purpose))
    else:
        assert read.purposes == read.consent == tuple(stated)
        assert set(stated) <= set(Purpose)


async def test_a_visitor_whose_streams_have_ended_has_left(stage: Stage, ann: Application) -> None:
    stream_id = await ann.send()
    assert len(refs(stage)) == 1
    await ann.ask("rois.stream.disconnect_stream", stream_id=stream_id)
    await settle()
    assert refs(stage) == []
    await ann.send()
    await stage.streams.forget_client(ann.client)
    assert refs(stage) == []


async def test_an_uplink_of_one_application_stays_that(stage: Stage, ann: Application, eve: Application) -> None:
    await ann.send(SPEAKER)
    with pytest.raises(OutOfResources, match="another application sends to robot/speaker already"):
        await eve.send(SPEAKER)
    assert len(refs(stage)) == 1


async def test_a_listener_receives_what_a_visitor_consents_to(stage: Stage, ann: Application, eve: Application) -> None:
    await ann.send(AUDIO, ["live", "agent"])
    (ref,) = refs(stage)
    streams = [await eve.listen(ref), await eve.listen(ref, AUDIO, ["agent", "live"])]
    offer = await eve.answer()
    assert [each["stream_id"] for each in offer["streams"]] == streams


@pytest.mark.parametrize(
    ("transport", "role", "refusal", "reason"),
    [
        ({"purposes": ["live"]}, None, Unsupported, "only the role listener"),
        ({"purposes": ["live"]}, "visitor", Unsupported, "only the role listener"),
        ({}, "listener", BadParameter, "set purposes in transport_parameters"),
        ({"purposes": ["live", "recording", "agent"]}, "listener", Unsupported, "does not consent to agent, recording"),
        ({"purposes": ["fun"]}, "listener", BadParameter, "purposes"),
        ({"purposes": ["live"], "direction": "sendonly"}, "listener", Unsupported, "use the direction recvonly"),
        ({"purposes": ["live"], "visitor_ref": "urn:x"}, "listener", Unsupported, "there is no visitor 'urn:x'"),
    ],
)
async def test_what_a_listener_does_not_receive(
    stage: Stage,
    ann: Application,
    eve: Application,
    transport: dict[str, Any],
    role: str | None,
    refusal: type[RoISError],
    reason: str,
) -> None:
    await ann.send()
    with pytest.raises(refusal, match=reason):
        await eve.stream(AUDIO, role, **{"visitor_ref": refs(stage)[0], **transport})
    with pytest.raises(Unsupported, match="sends no camera"):
        await eve.listen(refs(stage)[0], VIDEO)
    with pytest.raises(Unsupported, match="robot/speaker takes nothing of visitors"):
        await eve.listen(refs(stage)[0], SPEAKER)
    assert eve.told == []


async def ended(application: Application) -> list[str]:
    """Return the ids of the streams that have ended."""
    await settle()
    told = application.all("rois.stream.notify_stream_status")
    return [each["stream_id"] for each in told if each["status"] == "STREAMING_NOT_CONNECTED"]


async def test_a_withdrawal_ends_what_rests_on_it_and_nothing_else(
    stage: Stage, ann: Application, eve: Application
) -> None:
    sent = await ann.send(AUDIO, ["live", "agent"])
    (ref,) = refs(stage)
    live, agent = await eve.listen(ref), await eve.listen(ref, AUDIO, ["agent"])
    assert stage.streams.visitor_figures() == VisitorFigures(present=1, relayed=2)
    await ann.ask("rois.stream.set_consent", stream_id=sent, consent=["live"])
    assert await ended(eve) == [agent]
    with pytest.raises(Unsupported, match="does not consent to agent"):
        await eve.listen(ref, AUDIO, ["agent"])
    await stage.streams.forget_client(ann.client)
    assert await ended(eve) == [agent, live]
    assert stage.streams.visitor_figures() == VisitorFigures()


async def test_so_many_cameras_are_relayed_at_a_time(stage: Stage, eve: Application) -> None:
    visitors = [Application(stage, f"visitor {number}") for number in range(MAX_RELAYED_CAMERAS + 1)]
    for each in visitors:
        await each.send(VIDEO)
    *relayed, last = refs(stage)
    streams = [await eve.listen(ref, VIDEO) for ref in relayed]
    await eve.listen(relayed[0], VIDEO)
    with pytest.raises(OutOfResources, match="4 cameras of visitors are relayed, which is the limit"):
        await eve.listen(last, VIDEO)
    await eve.ask("rois.stream.disconnect_stream", stream_id=streams[1])
    await settle()
    await eve.listen(last, VIDEO)


async def test_so_many_microphones_are_relayed_at_a_time_for_whatever_purposes(
    stage: Stage, ann: Application, eve: Application
) -> None:
    await ann.send(AUDIO, list(Purpose))
    (ref,) = refs(stage)
    sets = [purposes for size in (1, 2, 3) for purposes in itertools.combinations(Purpose, size)]
    *relayed, last = sets[: MAX_RELAYED_MICROPHONES + 1]
    for purposes in relayed:
        await eve.listen(ref, AUDIO, purposes)
    with pytest.raises(OutOfResources, match="16 microphones of visitors are relayed, which is the limit"):
        await Application(stage, "carl").listen(ref, AUDIO, last)
    await Application(stage, "bob").listen(ref, AUDIO, relayed[0])


async def test_a_ninth_visitor_is_refused_until_one_has_left(stage: Stage) -> None:
    eight = [Application(stage, f"visitor {number}") for number in range(MAX_VISITORS)]
    streams = [await each.send() for each in eight]
    ninth = Application(stage, "ninth")
    for component_ref in (AUDIO, VIDEO, SPEAKER):
        with pytest.raises(OutOfResources, match="8 visitors send to robot, which is the limit: wait until one"):
            await ninth.send(component_ref)
    # Those that are there may send something else.
    await eight[0].send(VIDEO)
    await eight[3].ask("rois.stream.disconnect_stream", stream_id=streams[3])
    await settle()
    await ninth.send()
    assert len(refs(stage)) == MAX_VISITORS


async def test_what_is_withdrawn_before_the_first_packet_is_not_used(stage: Stage, ann: Application) -> None:
    """Between the offer and its answer."""
    stream_id = await ann.send(AUDIO, ["live"])
    (visitor,) = stage.visitors.present
    await ann.ask("rois.stream.set_consent", stream_id=stream_id, consent=[])
    await ann.answer()
    await settle()
    assert visitor.microphone.stream_id is None
    await ann.ask("rois.stream.set_consent", stream_id=stream_id, consent=["live"])
    assert visitor.microphone.stream_id == stream_id


async def test_of_visitors_and_listeners_that_have_left_nothing_is_kept(stage: Stage, eve: Application) -> None:
    """Also where a listener was refused, and where it left before the visitor."""
    gone = []
    for number in range(200):
        ann = Application(stage, f"visitor {number}")
        await ann.send(AUDIO, ["live", "agent"])
        (visitor,) = stage.visitors.present
        gone.append(weakref.ref(visitor))
        ref = visitor.visitor_ref
        with pytest.raises(Unsupported):
            await eve.stream(AUDIO, "listener", ("audio/none",), visitor_ref=ref, purposes=["agent"])
        listener = Application(stage, f"listener {number}")
        await listener.listen(ref)
        await (listener if number % 2 else ann).forget(stage)
        await (ann if number % 2 else listener).forget(stage)
        del visitor, ann, listener
        WirelessConnection.made.clear()
    await settle()
    gc.collect()
    assert stage.visitors.present == ()
    assert [each for each in gone if each() is not None] == []
    # The one that was refused is an application that tried to connect, and no more.
    assert len(stage.streams._names) == 1
