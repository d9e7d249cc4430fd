"""What a person does, over whichever peer connections a session has."""

from collections.abc import AsyncIterator

import pytest
from openrois_streaming.input.reader import Label
from openrois_streaming.liveness import SILENCE

from tests.support.streaming import settle
from tests.support.viewing import Application, FakeChannels, FedPublisher, WirelessConnection


class Player(Application):
    """An application that plays, and the input received from it."""

    def __init__(self) -> None:
        super().__init__(self)
        self.came: list[tuple[Label, str | bytes]] = []
        self.lost: list[str] = []

    def input_came(self, label: Label, data: str | bytes) -> None:
        self.came.append((label, data))

    def input_lost(self, reason: str) -> None:
        self.lost.append(reason)

    def connect(self, stream_id: str = "v") -> None:
        self.session.connect(stream_id, "engine/Video", FedPublisher(), "video")

    async def up(self) -> FakeChannels:
        """Answer the newest offer, connect, and open its channels."""
        await self.answer()
        connection = WirelessConnection.made[-1]
        connection.become("connected")
        connection.answers_questions = True
        assert connection.channels is not None
        connection.channels.are_open = True
        await settle()
        return connection.channels


@pytest.fixture
async def player(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Player]:
    WirelessConnection.stand_in(monkeypatch)
    made = Player()
    async with made.session:
        yield made


async def test_channels_are_in_the_first_offer_and_there_is_no_second(player: Player) -> None:
    player.connect()
    player.session.input.open()
    player.session.input.open()
    player.connect("w")
    channels = await player.up()
    channels.come("input", "{}")
    player.session.input.send_message("hello")
    await settle()
    assert (len(player.offers), player.came, channels.told) == (1, [("input", "{}")], ["hello"])


async def test_channels_are_opened_before_the_first_stream_or_later(player: Player) -> None:
    player.session.input.open()
    player.session.input.send_message("lost")
    player.connect()
    await player.up()
    assert len(player.offers) == 1


async def test_channels_opened_late_are_offered_then(player: Player) -> None:
    player.connect()
    await player.answer()
    assert WirelessConnection.made[0].channels is None
    player.session.input.open()
    await player.up()
    assert [offer.generation for offer in player.offers] == [1, 2]


async def test_no_channels_without_open(player: Player) -> None:
    player.connect()
    await player.answer()
    player.session.end_peer("engine/p1", "enough")
    assert WirelessConnection.made[0].channels is None
    assert player.lost == []


async def test_closed_channels_are_notified_and_streams_go_on(player: Player) -> None:
    player.connect()
    player.session.input.open()
    (await player.up()).close()
    assert player.lost == ["the application closed its data channels"]
    assert player.session.stream_ids == ("v",)


async def test_lost_viewer_is_notified(player: Player) -> None:
    player.connect()
    player.session.input.open()
    await player.up()
    WirelessConnection.made[0].answers_questions = False
    await player.clock.advance(SILENCE + 1)
    assert player.lost == ["the viewer is gone"]


async def test_while_one_of_two_peers_has_channels_nothing_is_lost(player: Player) -> None:
    player.connect()
    player.session.input.open()
    before = await player.up()
    player.session.restart("engine/p1")
    now = await player.up()
    before.close()
    before.come("control", "late")
    now.come("control", "new")
    player.session.end_peer("engine/p1", "it was replaced")
    assert (player.lost, player.came) == ([], [("control", "late"), ("control", "new")])
    player.session.input.send_message("still here")
    assert now.told == ["still here"]
    player.session.end_peer("engine/p2", "enough")
    assert player.lost == ["enough"]
