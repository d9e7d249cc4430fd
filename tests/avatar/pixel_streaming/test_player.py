"""A player is an application of the avatar's streams: what it receives, and what its messages cause."""

from collections.abc import AsyncIterator

import pytest
from openrois_avatar.facades.messages import pixel_streaming as wire
from openrois_avatar.facades.messages.reading import Said
from openrois_avatar.pixel_streaming.guests import Guests
from openrois_avatar.pixel_streaming.player import Player, Step
from openrois_avatar.pixel_streaming.protocol import Message, written
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_body.teleoperation.pilot import Pilot
from openrois_body.teleoperation.steering import Steering
from openrois_media.streaming_interface import Published, StreamingInterface
from openrois_streaming.network.session_limits import SessionLimits
from openrois_streaming.peer.data_channel import AnnouncedChannel
from openrois_streaming.state import Party

from openrois.errors import OutOfResources
from tests.support.streaming import VirtualClock, settle
from tests.support.teleoperation import LoggedControls
from tests.support.viewing import FakeChannels, FedPublisher, WirelessConnection

PLACES = ("avatar/video_streaming", "avatar/audio_streaming")


class Stage:
    """The streams of an avatar, and one player of them."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.controls = LoggedControls(self.clock)
        self.operator_control = OperatorControl("avatar/teleoperation", self.clock)
        self.publisher = FedPublisher()
        published = {PLACES[0]: Published(self.publisher, "video"), PLACES[1]: Published(FedPublisher(), "audio")}
        self.streams = StreamingInterface("avatar", published, self.clock, operator=self.operator_control)
        self.guests = Guests(
            self.operator_control, lambda stopped: Pilot(self.controls, Steering, self.clock, stopped), self.clock
        )
        self.said: list[Said] = []
        self.steps: list[Step] = []
        self.player = self.join("ann", self.guests)

    def join(self, player_id: str, guests: Guests | None) -> Player:
        return Player(player_id, self.streams, PLACES, guests, self.said.append, self.steps.append, self.clock)

    async def up(self) -> FakeChannels:
        """Let it answer, and its data channel be open."""
        await self.player.connect(())
        await settle()
        await self.player.apply_answer("answer")
        connection = WirelessConnection.made[-1]
        connection.answers_questions = True
        connection.become("connected")
        await settle()
        assert connection.channels is not None
        assert isinstance(connection.make_channels, AnnouncedChannel)
        connection.channels.are_open = True
        connection.make_channels.on_open()
        return connection.channels

    def of(self, kind: type[Said]) -> list[Said]:
        return [each for each in self.said if isinstance(each, kind)]


@pytest.fixture
async def stage(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Stage]:
    WirelessConnection.stand_in(monkeypatch)
    made = Stage()
    async with made.streams.sessions:
        yield made


async def test_picture_sound_and_data_channel_are_in_one_offer(stage: Stage) -> None:
    channels = await stage.up()
    (offer,) = stage.of(wire.Offer)
    assert isinstance(offer, wire.Offer)
    assert offer.player_id == "ann"
    assert len(stage.of(wire.Offer)) == len(WirelessConnection.made) == 1
    assert [message[0] for message in channels.told if isinstance(message, bytes)] == [255, 255, 12, 12]
    assert channels.told[-1] == b"\x0c\x01"


async def test_its_hands_operate_and_its_end_lets_go(stage: Stage) -> None:
    channels = await stage.up()
    channels.come("control", written(Message("KeyDown", (87, 0))))
    assert stage.controls.words == ["drive"]
    channels.close()
    assert stage.controls.words == ["drive", "halt"]
    await stage.player.leave()
    assert len(stage.streams.sessions) == 0
    assert stage.of(wire.DisconnectPlayer) == []


async def test_without_permission_it_only_looks(stage: Stage) -> None:
    stage.player = stage.join("bob", None)
    channels = await stage.up()
    channels.come("control", written(Message("KeyDown", (87, 0))))
    assert channels.told[-1] == b"\x0c\x00"
    assert stage.controls.done == []
    await stage.player.leave()


async def test_player_gets_a_key_frame_suspends_and_resumes(stage: Stage) -> None:
    channels = await stage.up()
    (session,) = stage.streams.sessions
    video = session.stream_ids[0]
    channels.come("control", written(Message("IFrameRequest")))
    assert (await session.stats(video)).key_frame_requests == 1
    for name, suspended_by in (("StopStreaming", {Party.APPLICATION}), ("StartStreaming", set())):
        channels.come("control", written(Message(name)))
        (step,) = stage.steps
        stage.steps.clear()
        await step()
        assert [each.suspended_by for each in session._streams] == [suspended_by] * 2
    stage.player.over = True
    await stage.player.leave()
    stage.player.show_anew()
    assert stage.player.over


async def test_candidates_pass_both_ways_and_bad_ones_are_dropped(stage: Stage) -> None:
    await stage.player.add_candidate(wire.RtcCandidate(candidate="too early"))
    await stage.player.apply_answer("too early")
    await stage.up()
    await stage.player.add_candidate(wire.RtcCandidate(candidate="candidate:1", sdp_mid="0"))
    await stage.player.add_candidate(wire.RtcCandidate(candidate=""))
    await stage.player.add_candidate(wire.RtcCandidate(candidate="ü" * 1024))
    assert not stage.player.over


async def test_a_peer_connection_that_ends_is_told_once(stage: Stage) -> None:
    await stage.up()
    (session,) = stage.streams.sessions
    session.end_peer(session.peer_ids[0], "the viewer is gone")
    (told,) = stage.of(wire.DisconnectPlayer)
    assert told == wire.DisconnectPlayer(player_id="ann", reason="the viewer is gone")
    assert stage.player.over
    assert len(stage.steps) == 1


async def test_player_that_cannot_be_served_gets_the_reason(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SessionLimits, "has_room", lambda *_: False)
    with pytest.raises(OutOfResources):
        await stage.player.connect(())
    await stage.player.leave()
