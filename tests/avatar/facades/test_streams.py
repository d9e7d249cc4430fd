"""The places of applications of a game engine that does WebRTC itself."""

from typing import Any

import pytest
from openrois_avatar.facades.streamer import Offered
from openrois_avatar.facades.streams import FacadeStreams
from openrois_signaling.messages import Offer
from openrois_streaming.network.session_limits import SessionLimits
from openrois_streaming.network.settings import NetworkSettings

from openrois.contract import Client
from openrois.errors import OutOfResources
from tests.support.facade_session import Engine, media, sdp

CAMERA = "avatar/camera"
RULES = SessionLimits(applications=3, kept_for_operators=1, answer_time=2.0)


class MediaTime:
    """A media clock that tests turn by hand."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def now(self) -> float:
        return self.seconds

    def wall(self) -> float:
        return self.seconds

    async def sleep_until(self, deadline: float) -> None:
        raise NotImplementedError


class Applications:
    """Applications at one game engine."""

    def __init__(self) -> None:
        self.clock = MediaTime()
        self.engine = Engine()
        self.streams = FacadeStreams(
            "avatar", {CAMERA: "video"}, lambda: self.engine, str, self.clock, NetworkSettings(sessions=RULES)
        )
        self.clients: dict[str, Client] = {}
        self.told: dict[str, list[tuple[str, dict[str, Any]]]] = {}

    async def comes(self, name: str, *, may_bind: bool = False) -> str:
        """Connect a stream and return its id."""
        told = self.told.setdefault(name, [])
        client = self.clients.setdefault(name, Client(name, lambda method, params: told.append((method, dict(params)))))
        params = {"component_ref": CAMERA, **({} if may_bind else {"may_bind": False})}
        return str((await self.streams.call("rois.stream.connect_stream", params, client))["stream_id"])

    async def answers(self, name: str) -> None:
        """Have the game engine offer to the one that came last, and this one answer."""
        self.look(0.125)
        described = sdp(media("video", "0"))
        self.streams.handle_engine_message(Offered(self.engine.players[-1], described))
        offer = next(params for method, params in self.told[name] if method == Offer.method)
        answer = {"peer_id": offer["peer_id"], "generation": offer["generation"]}
        answer["sdp"] = sdp(media("video", "0", "recvonly"))
        await self.streams.call("signaling.answer", answer, self.clients[name])

    def look(self, seconds: float) -> None:
        """Let time pass, and players come."""
        self.clock.seconds += seconds
        self.streams.check_deadlines()

    def statuses(self, name: str) -> list[str]:
        return [params["status"] for _, params in self.told[name] if "status" in params]


async def test_application_without_an_answer_gives_its_place_to_the_next() -> None:
    applications = Applications()
    await applications.comes("viewer 1")
    await applications.answers("viewer 1")
    await applications.comes("viewer 2")
    applications.look(1.9)
    with pytest.raises(OutOfResources, match="2 of at most 3"):
        await applications.comes("viewer 3")
    applications.look(0.1)
    await applications.comes("viewer 3")
    assert applications.statuses("viewer 2")[-1] == "STREAMING_NOT_CONNECTED"
    assert len(applications.streams) == 2
    # The one that has answered stays, however long ago that was.
    applications.look(3)
    await applications.comes("viewer 4")
    assert applications.statuses("viewer 1")[-1] == "STREAMING_RUNNING"


async def test_application_that_may_bind_by_now_needs_no_place_of_other_applications() -> None:
    applications = Applications()
    for viewer in ("viewer 1", "viewer 2"):
        stream_id = await applications.comes(viewer)
        await applications.answers(viewer)
    client = applications.clients["viewer 2"]
    await applications.streams.call("rois.stream.disconnect_stream", {"stream_id": stream_id}, client)
    await applications.comes("viewer 2", may_bind=True)
    await applications.comes("viewer 3")
    assert len(applications.streams) == 3
