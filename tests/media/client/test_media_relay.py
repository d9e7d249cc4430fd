"""Media of an application over a TURN server alone, with the credentials that its gateway issues: coturn."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar

import pytest
from openrois_media.client import peer
from openrois_signaling.messages import Direction
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.synthetic import ColourBars, Tone
from openrois_streaming.viewing.answering import AnsweringConnection

from openrois.gateway.settings import GatewaySettings
from tests.support.loopback import PATIENCE
from tests.support.media_body import CAMERA, MICROPHONE, Body, application, body, read
from tests.support.turn import Turn, coturn

pytestmark = [pytest.mark.media, pytest.mark.usefixtures("turnserver")]

RELAYED = NetworkSettings(relay_only=True)


@pytest.fixture
async def turn(tmp_path: Path) -> AsyncIterator[Turn]:
    async with coturn(tmp_path) as server:
        yield server


def settings(turn: Turn, *urls: str) -> GatewaySettings:
    return GatewaySettings(port=0, turn=urls or (turn.url(),), turn_secret=turn.secret)


class Relayed(AnsweringConnection):
    """An application's end as behind a firewall that lets nothing but the TURN server through."""

    told: ClassVar[list[str]] = []

    def __init__(self, clock: MediaClock, **options: Any) -> None:
        found = options.pop("on_candidate")
        super().__init__(clock, network=RELAYED, on_candidate=lambda each: self._tell(each, found), **options)

    async def answer_offer(self, sdp: str, directions: Mapping[str, Direction] | None = None) -> str:
        answer = await super().answer_offer(sdp, directions)
        self.told.extend(line for line in answer.splitlines() if line.startswith("a=candidate:"))
        return answer

    def _tell(self, candidate: str | None, found: Callable[[str | None], None]) -> None:
        if candidate:
            self.told.append(candidate)
        found(candidate)


@pytest.fixture
def relayed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The application's end has its relay alone."""
    monkeypatch.setattr(peer, "AnsweringConnection", Relayed)
    monkeypatch.setattr(Relayed, "told", [])
    yield
    assert Relayed.told
    assert all(" typ relay " in each for each in Relayed.told)


async def passes_both_ways(robot: Body) -> None:
    """Check that pictures and sound arrive at the application, and its own at the body."""
    clock = SystemClock()
    async with (
        application(robot) as (_, media),
        media.frames(CAMERA) as frames,
        media.blocks(MICROPHONE) as blocks,
        robot.screen.subscribe(1) as screen,
        robot.speaker.subscribe(1) as speaker,
        media.send(camera=ColourBars(160, 120, 15, clock=clock), microphone=Tone(clock=clock)),
    ):
        assert (await read(frames, 5))[-1].data.shape == (180, 320, 3)
        await read(blocks, 5)
        async with asyncio.timeout(PATIENCE):
            picture, _ = await screen.get(), await speaker.get()
        assert (picture.width, picture.height) == (160, 120)


@pytest.mark.parametrize("transport", ["udp", "tcp"])
async def test_media_pass_both_ways_where_the_body_is_reached_over_its_relay_alone(turn: Turn, transport: str) -> None:
    async with body(settings(turn, turn.url(transport)), RELAYED) as robot:
        await passes_both_ways(robot)


@pytest.mark.usefixtures("relayed")
async def test_media_pass_both_ways_between_two_relays(turn: Turn) -> None:
    async with body(settings(turn), RELAYED) as robot:
        await passes_both_ways(robot)


@pytest.mark.usefixtures("relayed")
async def test_media_pass_both_ways_where_the_application_alone_needs_a_relay(turn: Turn) -> None:
    async with body(settings(turn)) as robot:
        await passes_both_ways(robot)
