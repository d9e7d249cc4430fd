import json
from collections.abc import AsyncIterator, Callable, Mapping
from typing import Any

import pytest
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_body.teleoperation.pilot import Pilot
from openrois_body.teleoperation.steering import Steering
from openrois_media.streaming_interface import Published, StreamingInterface
from openrois_signaling.messages import IceServer
from openrois_streaming.adaptation.rung import ladder
from openrois_streaming.adaptation.viewer import VIDEO_SHARE, Caps
from openrois_streaming.network.session_limits import SESSIONS_LIMIT

from openrois.contract import Client
from openrois.errors import BadParameter, OutOfResources, RoISError, Unsupported
from openrois.types.streams import HolderNotification
from tests.support.streaming import VirtualClock, settle
from tests.support.teleoperation import Hand, LoggedControls, text
from tests.support.viewing import FakeInlet, FedPublisher, WirelessConnection

VIDEO, AUDIO, SCREEN = "avatar/video_streaming", "avatar/audio_streaming", "avatar/Screen"
VP8 = json.dumps({"codecs": ["video/VP8"]})
OK = {"return_code": "OK"}
HOLDS = HolderNotification(component_ref="avatar/teleoperation", holds=True, epoch=1)


class Stage:
    """The streams of an avatar whose pictures are given by hand, on a clock that stands still."""

    def __init__(self, cap: Callable[[Client], Caps] | None = None) -> None:
        self.clock = VirtualClock()
        self.operator = OperatorControl("avatar/teleoperation", self.clock)
        self.publisher = FedPublisher()
        self.camera, self.microphone = FakeInlet(), FakeInlet()
        self.come_encoded: tuple[str, ...] | None = None
        published = {
            VIDEO: Published(self.publisher, "video", self.camera, lambda: self.come_encoded),
            AUDIO: Published(self.publisher, "audio", self.microphone),
            SCREEN: Published(self.publisher, "video"),
        }
        self.streams = StreamingInterface("avatar", published, self.clock, cap=cap, operator=self.operator)
        self._reports = 0

    async def play(self) -> None:
        """Let frames flow to the newest viewer for half a second."""
        for number in range(5):
            await self.publisher.renditions("video/VP8")[0].show(keyframe=number == 0)
            self._reports += 1
            WirelessConnection.made[-1].report(self._reports)
            await self.clock.advance(0.1)


class Caller:
    """An application, as the parent's connection brings it."""

    def __init__(self, stage: Stage, client_id: str = "alice") -> None:
        self.told: list[tuple[str, Mapping[str, Any]]] = []
        self._streams = stage.streams
        self.client = Client(client_id, lambda name, params: self.told.append((name, params)))

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        return await self._streams.call(method, params, self.client)

    async def connect(
        self,
        encoding: str = VP8,
        component_ref: str = VIDEO,
        direction: str | None = None,
        *,
        wants_input: bool = False,
        wants_speech: bool = False,
        **more: Any,
    ) -> str:
        parameters = [{"name": "encoding_parameters", "data_type_ref": "String", "value": encoding}]
        if direction is not None:
            value = json.dumps({"direction": direction, "input": wants_input, "speech": wants_speech})
            parameters.append({"name": "transport_parameters", "data_type_ref": "String", "value": value})
        answer = await self.ask(
            "rois.stream.connect_stream", component_ref=component_ref, parameters=parameters, **more
        )
        assert answer["return_code"] == "OK"
        stream_id = answer["stream_id"]
        assert isinstance(stream_id, str)
        return stream_id

    async def answer(self) -> Mapping[str, Any]:
        """Answer the newest offer and let the connection come up; returns the offer."""
        await settle()
        offer = self.all("signaling.offer")[-1]
        about = {"peer_id": offer["peer_id"], "generation": offer["generation"]}
        assert await self.ask("signaling.answer", **about, sdp="answer") == OK
        WirelessConnection.made[-1].answers_questions = True
        WirelessConnection.made[-1].become("connected")
        await settle()
        return offer

    def all(self, method: str) -> list[Mapping[str, Any]]:
        return [params for name, params in self.told if name == method]

    def statuses(self) -> list[str]:
        return [params["status"] for params in self.all("rois.stream.notify_stream_status")]


@pytest.fixture
async def stage(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Stage]:
    WirelessConnection.stand_in(monkeypatch)
    stage = Stage()
    async with stage.streams.sessions:
        yield stage
    assert all(connection.closed for connection in WirelessConnection.made)


@pytest.fixture
def alice(stage: Stage) -> Caller:
    return Caller(stage)


async def test_a_stream_is_offered_after_the_reply_and_named_in_the_terms_of_the_wire(alice: Caller) -> None:
    stream_id = await alice.connect()
    assert stream_id.startswith("avatar/")
    assert alice.told == []
    await settle()
    [offer] = alice.all("signaling.offer")
    section = {"mid": "0", "stream_id": stream_id, "component_ref": VIDEO, "kind": "video", "direction": "recvonly"}
    assert offer == {"peer_id": offer["peer_id"], "generation": 1, "sdp": "offer 1", "streams": [section]}
    assert offer["peer_id"].startswith("avatar/")
    status = await alice.ask("rois.stream.query_stream_status", stream_id=stream_id)
    assert status == {**OK, "status": "STREAMING_NOT_CONNECTED"}


async def test_every_change_is_notified_with_rois_names(stage: Stage, alice: Caller) -> None:
    stream_id = await alice.connect()
    await alice.answer()
    await stage.play()
    about = {"stream_id": stream_id}
    assert await alice.ask("rois.stream.suspend_stream", **about) == OK
    assert alice.statuses() == ["STREAMING_NOT_RUNNING", "STREAMING_RUNNING"]
    await settle()
    suspended = await alice.ask("rois.stream.query_stream_status", **about)
    assert suspended == {**OK, "status": "STREAMING_SUSPENDED"}
    assert await alice.ask("rois.stream.resume_stream", **about) == OK
    await stage.play()
    assert await alice.ask("rois.stream.disconnect_stream", **about) == OK
    await settle()
    assert alice.statuses() == [
        "STREAMING_NOT_RUNNING",
        "STREAMING_RUNNING",
        "STREAMING_SUSPENDED",
        "STREAMING_RESUMED",
        "STREAMING_RUNNING",
        "STREAMING_NOT_CONNECTED",
    ]
    for notice in alice.all("rois.stream.notify_stream_status"):
        assert notice == {**about, "component_ref": VIDEO, "status": notice["status"], "timestamp": notice["timestamp"]}
        assert notice["timestamp"].startswith("2027-01-15T08:00:")


async def test_a_viewer_says_how_late_it_plays_until_it_says_otherwise(stage: Stage, alice: Caller) -> None:
    stream_id = await alice.connect()
    [session] = stage.streams.sessions
    assert (await session.stats(stream_id)).playout_delay is None
    for milliseconds in (150, 60_000, 0):
        about = {"stream_id": stream_id, "milliseconds": milliseconds}
        assert await alice.ask("rois.stream.report_playout", **about) == OK
        assert (await session.stats(stream_id)).playout_delay == milliseconds / 1000


async def test_an_application_is_sent_no_more_than_it_wants(stage: Stage, alice: Caller) -> None:
    stage.publisher.rung = ladder(320, 180, 30)[0]
    await alice.connect(json.dumps({"width": 640, "height": 360, "fps": 15, "max_bitrate": 100_000}))
    await alice.answer()
    assert stage.publisher.fps == 15
    assert stage.publisher.renditions("video/VP8")[0].demanded == 100_000 * VIDEO_SHARE


async def test_an_application_is_sent_no_more_than_it_may_have_whatever_it_wants(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    WirelessConnection.stand_in(monkeypatch)
    caps = {"alice": Caps(max_bitrate=80_000, fps=10), "bob": Caps()}
    stage = Stage(lambda client: caps[client.client_id])
    stage.publisher.rung = ladder(320, 180, 30)[0]
    async with stage.streams.sessions:
        for name, demanded, fps in (("alice", 80_000, 10), ("bob", 90_000, 30)):
            caller = Caller(stage, name)
            await caller.connect(json.dumps({"max_bitrate": 90_000, "fps": 30}))
            await caller.answer()
            assert stage.publisher.renditions("video/VP8", fps)[0].demanded == demanded * VIDEO_SHARE


@pytest.mark.parametrize(
    "wrong",
    [
        {"fps": 0},
        {"fps": "30"},
        {"width": 1.5},
        {"height": -1},
        {"max_bitrate": 10},
        {"max_bitrate": True},
        {"fps": 1e9},
    ],
)
async def test_limits_that_make_no_sense_are_refused(alice: Caller, wrong: dict[str, object]) -> None:
    with pytest.raises(BadParameter, match="encoding_parameters"):
        await alice.connect(json.dumps(wrong))


async def test_a_restart_is_an_offer_that_replaces(alice: Caller) -> None:
    await alice.connect()
    old = await alice.answer()
    assert await alice.ask("signaling.restart", peer_id=old["peer_id"]) == OK
    await settle()
    assert alice.all("signaling.offer")[-1]["replaces"] == old["peer_id"]


async def test_a_peer_that_the_application_cannot_have_is_ended(alice: Caller) -> None:
    await alice.connect()
    await settle()
    [offer] = alice.all("signaling.offer")
    bye = {"peer_id": offer["peer_id"], "reason": "too many"}
    assert await alice.ask("signaling.bye", **bye) == OK
    await settle()
    assert alice.all("signaling.bye") == [bye]
    assert alice.statuses() == ["STREAMING_NOT_CONNECTED"]
    with pytest.raises(Unsupported):
        await alice.ask("signaling.bye", **bye)


async def test_candidates_and_answers_reach_their_peer_connection_and_old_ones_are_dropped(alice: Caller) -> None:
    await alice.connect()
    offer = await alice.answer()
    about = {"peer_id": offer["peer_id"], "generation": 1}
    assert await alice.ask("signaling.candidate", **about, candidate="candidate:1", sdp_mid="0") == OK
    assert WirelessConnection.made[0].candidates == ["candidate:1"]
    with pytest.raises(BadParameter):
        await alice.ask("signaling.candidate", **about, candidate="garbage", sdp_mid="0")


async def test_answer_without_offer_is_refused_with_reason(alice: Caller) -> None:
    await alice.connect()
    offer = await alice.answer()
    for generation, sdp, why in (
        (1, "answer", "the offer of generation 1 has been answered already"),
        (1, "garbage", "the offer of generation 1 has been answered already"),
        (7, "answer", "there was no offer of generation 7"),
    ):
        with pytest.raises(BadParameter, match=f"^{why}$"):
            await alice.ask("signaling.answer", peer_id=offer["peer_id"], generation=generation, sdp=sdp)
    await settle()
    assert alice.all("signaling.bye") == []


async def test_an_answer_that_cannot_be_used_is_refused_and_ends_the_stream(alice: Caller) -> None:
    await alice.connect()
    await settle()
    [offer] = alice.all("signaling.offer")
    with pytest.raises(BadParameter):
        await alice.ask("signaling.answer", peer_id=offer["peer_id"], generation=1, sdp="garbage")
    await settle()
    [bye] = alice.all("signaling.bye")
    assert bye == {"peer_id": offer["peer_id"], "reason": bye["reason"]}


async def test_ice_servers_of_the_gateway_are_used(alice: Caller) -> None:
    await alice.connect(ice_servers=[{"urls": ["stun:192.0.2.1:3478"]}])
    assert list(WirelessConnection.made[0].ice_servers) == [IceServer(urls=("stun:192.0.2.1:3478",))]
    old = await alice.answer()
    fresh = [{"urls": ["turn:192.0.2.1"], "username": "2:avatar", "credential": "new"}]
    assert await alice.ask("signaling.restart", peer_id=old["peer_id"], ice_servers=fresh) == OK
    assert [server.username for server in WirelessConnection.made[1].ice_servers] == ["2:avatar"]


@pytest.mark.parametrize(
    ("encoding", "refusal"),
    [
        ("H264", BadParameter),
        ("null", BadParameter),
        ("[" * 20_000, BadParameter),
        ('{"codecs": "video/H264"}', BadParameter),
        ('{"codecs": [1]}', BadParameter),
        (json.dumps({"codecs": ["x"] * 33}), BadParameter),
        ('{"codecs": []}', Unsupported),
        ('{"codecs": ["video/AV1"]}', Unsupported),
    ],
)
async def test_an_encoding_that_cannot_be_is_refused(alice: Caller, encoding: str, refusal: type[RoISError]) -> None:
    with pytest.raises(refusal):
        await alice.connect(encoding)
    assert WirelessConnection.made == []


@pytest.mark.parametrize("encoding", ["", "{}", '{"codecs": null, "bitrate": 1}'])
async def test_without_a_list_of_codecs_all_are_offered(alice: Caller, encoding: str) -> None:
    assert await alice.connect(encoding)


@pytest.mark.parametrize(
    ("transport", "component_ref", "refusal"),
    [
        ('{"direction": "sendrecv"}', VIDEO, Unsupported),
        ('{"direction": "inactive"}', AUDIO, Unsupported),
        ('{"direction": "sendonly"}', SCREEN, Unsupported),
        ('{"direction": 1}', VIDEO, BadParameter),
        ('{"direction": "' + "x" * 40 + '"}', VIDEO, BadParameter),
        ("recvonly", VIDEO, BadParameter),
    ],
)
async def test_a_direction_that_is_not_there_is_not_supported(
    alice: Caller, transport: str, component_ref: str, refusal: type[RoISError]
) -> None:
    parameter = {"name": "transport_parameters", "data_type_ref": "String", "value": transport}
    with pytest.raises(refusal):
        await alice.ask("rois.stream.connect_stream", component_ref=component_ref, parameters=[parameter])


async def test_an_application_sends_into_a_component(stage: Stage, alice: Caller) -> None:
    camera = await alice.connect(component_ref=VIDEO, direction="sendonly")
    talk = await alice.connect('{"codecs": ["opus"]}', component_ref=AUDIO, direction="sendrecv")
    offer = await alice.answer()
    assert [(each["stream_id"], each["direction"]) for each in offer["streams"]] == [
        (camera, "sendonly"),
        (talk, "sendrecv"),
    ]
    assert set(stage.camera.sources) == {camera}
    assert set(stage.microphone.sources) == {talk}
    await alice.ask("rois.stream.disconnect_stream", stream_id=camera)
    await stage.streams.forget_client(alice.client)
    assert stage.camera.sources == stage.microphone.sources == {}


async def test_only_one_sends_into_a_component_at_a_time(stage: Stage, alice: Caller) -> None:
    bob = Caller(stage, "bob")
    first = await alice.connect(component_ref=VIDEO, direction="sendonly")
    for caller in (alice, bob):
        with pytest.raises(OutOfResources, match="wait until its stream ends"):
            await caller.connect(component_ref=VIDEO, direction="sendonly")
    await bob.connect(component_ref=VIDEO)
    await bob.connect('{"codecs": ["opus"]}', component_ref=AUDIO, direction="sendonly")
    await alice.ask("rois.stream.disconnect_stream", stream_id=first)
    await settle()
    await bob.connect(component_ref=VIDEO, direction="sendonly")
    await stage.streams.forget_client(bob.client)
    await alice.connect(component_ref=VIDEO, direction="sendonly")


async def test_absent_components_and_streams_are_unsupported(alice: Caller) -> None:
    await alice.connect()
    for method, params in (
        ("rois.stream.connect_stream", {"component_ref": "avatar/speech_synthesizer"}),
        ("rois.stream.suspend_stream", {"stream_id": "avatar/1"}),
        ("rois.stream.rewind_stream", {"stream_id": "avatar/1"}),
        ("signaling.restart", {"peer_id": "avatar/1"}),
    ):
        with pytest.raises(Unsupported):
            await alice.ask(method, **params)


@pytest.mark.parametrize(
    ("method", "params"),
    [
        ("rois.stream.connect_stream", {"component_ref": VIDEO, "codec": "H264"}),
        ("rois.stream.suspend_stream", {}),
        ("rois.stream.report_playout", {"stream_id": "avatar/1", "milliseconds": 60_001}),
        ("rois.stream.report_playout", {"stream_id": "avatar/1"}),
        ("signaling.answer", {"peer_id": "avatar/1", "generation": 0, "sdp": "answer"}),
    ],
)
async def test_params_that_do_not_fit_are_refused(alice: Caller, method: str, params: dict[str, Any]) -> None:
    with pytest.raises(BadParameter):
        await alice.ask(method, **params)


async def test_streams_of_another_client_are_unreachable(stage: Stage, alice: Caller) -> None:
    stream_id = await alice.connect()
    offer = await alice.answer()
    mallory = Caller(stage, "mallory")
    await mallory.connect()
    about = {"peer_id": offer["peer_id"], "generation": 1}
    for verb in ("suspend_stream", "resume_stream", "disconnect_stream", "query_stream_status"):
        with pytest.raises(Unsupported):
            await mallory.ask(f"rois.stream.{verb}", stream_id=stream_id)
    with pytest.raises(Unsupported):
        await mallory.ask("rois.stream.report_playout", stream_id=stream_id, milliseconds=1000)
    for method, params in (
        ("signaling.answer", {**about, "sdp": "answer"}),
        ("signaling.candidate", {**about, "candidate": "candidate:1", "sdp_mid": "0"}),
        ("signaling.restart", {"peer_id": offer["peer_id"]}),
    ):
        with pytest.raises(Unsupported):
            await mallory.ask(method, **params)


async def test_the_number_of_applications_and_sections_is_bounded(stage: Stage, alice: Caller) -> None:
    await alice.connect()
    WirelessConnection.made[0].room = 1
    with pytest.raises(OutOfResources):
        await alice.connect()
    for number in range(SESSIONS_LIMIT - 1):
        await Caller(stage, f"client {number}").connect()
    with pytest.raises(OutOfResources):
        await Caller(stage, "one too many").connect()


async def test_an_application_that_is_gone_is_forgotten_with_all_it_had(stage: Stage, alice: Caller) -> None:
    await alice.connect()
    await alice.answer()
    await stage.streams.forget_client(alice.client)
    await stage.streams.forget_client(alice.client)
    await stage.streams.forget_client(Caller(stage, "another").client)
    assert alice.all("signaling.bye")
    assert len(stage.streams.sessions) == 0


async def test_over_a_new_connection_an_application_starts_anew(stage: Stage, alice: Caller) -> None:
    old = await alice.connect()
    await alice.answer()
    later = Caller(stage)
    with pytest.raises(Unsupported):
        await later.ask("rois.stream.suspend_stream", stream_id=old)
    new = await later.connect()
    offer = await later.answer()
    assert [section["stream_id"] for section in offer["streams"]] == [new]

    await stage.streams.forget_client(alice.client)
    assert WirelessConnection.made[0].closed
    assert not WirelessConnection.made[1].closed
    assert await later.ask("rois.stream.suspend_stream", stream_id=new) == OK
    await stage.streams.forget_client(later.client)
    assert len(stage.streams.sessions) == 0


async def test_input_reaches_the_operator_control_of_the_holder(stage: Stage, alice: Caller) -> None:
    await alice.connect(direction="recvonly")
    await alice.answer()
    assert WirelessConnection.made[-1].channels is None
    await alice.connect(direction="recvonly", wants_input=True)
    await alice.answer()
    channels = WirelessConnection.made[-1].channels
    assert channels is not None
    channels.are_open = True
    channels.come("input", text(Hand().state()))
    assert json.loads(channels.told[0])["event"] == "refused"
    await stage.streams.set_holder(HOLDS, alice.client)
    controls, reasons = LoggedControls(stage.clock), list[str]()
    with stage.operator.operated(Pilot(controls, Steering, stage.clock, reasons.append)) as vacated:
        hand = Hand()
        hand.state()
        channels.come("input", text(hand.state()))
        assert controls.words == ["drive"]
        await stage.streams.forget_client(alice.client)
        assert controls.words == ["drive", "halt"]
        assert await vacated == "the application that operated is gone"


async def test_speech_to_a_body_that_speaks_no_sound_is_refused_and_keys_go_to_the_operator_control(
    stage: Stage, alice: Caller
) -> None:
    await alice.connect(direction="recvonly", wants_speech=True)
    await alice.answer()
    channels = WirelessConnection.made[-1].channels
    assert channels is not None
    channels.are_open = True
    for data in (b"sound", "{", '{"event": "end", "utterance": 4}', '{"event": "begin", "utterance": 4}'):
        channels.come("speech", data)
    channels.come("control", '{"event": "clear", "utterance": 4}')
    assert channels.told == []
    channels.come("speech", '{"event": "begin", "utterance": 4, "format": "opus", "rate": 48000}')
    channels.come("control", text(Hand().key("KeyW")))
    told = [json.loads(each) for each in channels.told]
    assert [each["event"] for each in told] == ["refused", "refused"]
    assert (channels.labels, told[0]["utterance"]) == (["speech", "control"], 4)
    assert "plays no sound" in told[0]["reason"]
    channels.close()


async def test_an_avatar_that_cannot_be_operated_offers_no_channels_and_hears_of_no_holder(stage: Stage) -> None:
    published = {VIDEO: Published(stage.publisher, "video")}
    streams = StreamingInterface("avatar", published, stage.clock)
    async with streams.sessions:
        wish = {"name": "transport_parameters", "data_type_ref": "String", "value": '{"input": true}'}
        client = Client("alice", lambda _method, _params: None)
        await streams.call("rois.stream.connect_stream", {"component_ref": VIDEO, "parameters": [wish]}, client)
        await settle()
        assert WirelessConnection.made[-1].channels is None
        await streams.set_holder(HOLDS, client)


@pytest.mark.parametrize(
    ("wanted", "offered"),
    [
        (None, ("video/H264",)),
        (("video/VP8", "h264"), ("video/H264",)),
        (("video/h264",), ("video/H264",)),
    ],
)
def test_pictures_that_come_encoded_are_offered_as_they_are(
    wanted: tuple[str, ...] | None, offered: tuple[str, ...]
) -> None:
    assert Published(FedPublisher(), "video", codecs=lambda: ("video/H264",)).choose(wanted) == offered
    assert Published(FedPublisher(), "video").choose(wanted) == wanted


async def test_application_without_codec_of_encoded_video_is_refused_with_reason(stage: Stage, alice: Caller) -> None:
    stage.come_encoded = ("video/H264",)
    with pytest.raises(Unsupported, match="come encoded as video/H264, which the application does not decode"):
        await alice.connect()
    assert WirelessConnection.made == []
    assert await alice.connect(direction="sendonly")


async def test_a_viewer_for_whose_only_codec_there_is_no_encoder_is_refused(stage: Stage) -> None:
    stage.publisher.full = {"video/VP8"}
    viewer = Caller(stage)
    with pytest.raises(
        OutOfResources,
        match=r"all encoders of the adapter are in use, and none of them encodes video/VP8: disconnect .*max_encoders",
    ):
        await viewer.connect(VP8)
