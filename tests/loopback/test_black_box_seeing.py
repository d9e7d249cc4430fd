"""What the avatar sees of an application's camera, over the gateway and real WebRTC."""

import json
from collections.abc import AsyncIterator
from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from aiortc import VideoStreamTrack
from av import VideoFrame

from tests.support.black_box import VIDEO, VP8, Application, application
from tests.support.demo import Demo
from tests.support.people import Picture, Scene, Sitter, nodding, picture

pytestmark = [pytest.mark.media, pytest.mark.long]

_EVERY = 3
"""The track has 30 pictures a second; each of ours is in so many of them."""
_SECONDS = 4


def scene(moment: float) -> list[Sitter]:
    """A nodding person, and one that sits still."""
    (nods,) = nodding(Sitter("collins", x=0.28, size=0.18), begin=1.5)(moment)
    return [nods, replace(Sitter("hopper"), x=0.74, size=0.18)]


@cache
def film(of: Scene) -> list[Picture]:
    return [picture(of(number * _EVERY / 30), 480, 270) for number in range(_SECONDS * 30 // _EVERY)]


class Camera(VideoStreamTrack):
    """A film of people, over and over."""

    async def recv(self) -> VideoFrame:
        pts, time_base = await self.next_timestamp()
        number = round(pts * time_base * 30) // _EVERY
        pictures = film(scene)
        frame = VideoFrame.from_ndarray(pictures[number % len(pictures)], format="bgr24")
        frame.pts, frame.time_base = pts, time_base
        return frame


@pytest.fixture
async def app(demo: Demo) -> AsyncIterator[Application]:
    film(scene)
    async with application(demo.url) as connected:
        await connected.hello()
        connected.devices = {"video": Camera()}
        yield connected


class Heard:
    """The events of each kind, as they are received."""

    def __init__(self, app: Application) -> None:
        self._app = app
        self._kinds: dict[str, str] = {}

    async def subscribe(self, component: str, event: str) -> None:
        condition = f"component_ref = 'avatar/{component}'"
        answer = await self._app.ask("rois.event.subscribe", event_type=event, condition=condition)
        assert answer["return_code"] == "OK", answer
        self._kinds[event] = answer["subscribe_id"]

    def all(self, event: str) -> list[dict[str, Any]]:
        """The results of all events of a kind so far; lists as such."""
        notices = self._app.told("rois.event.notify_event")
        return [
            {result["name"]: _value(result) for result in notice["results"]}
            for notice in notices
            if notice["subscribe_id"] == self._kinds[event]
        ]

    async def until(self, event: str, **results: Any) -> dict[str, Any]:
        """Wait for an event that says this."""
        return await self._app.news.until(
            lambda: next((told for told in self.all(event) if results.items() <= told.items()), {})
        )


def _value(result: dict[str, str]) -> Any:
    listed = result["data_type_ref"].endswith("[]") or result["data_type_ref"] == "int"
    return json.loads(result["value"]) if listed else result["value"]


async def test_faces_persons_and_a_nod_are_seen_and_gone_with_the_camera(app: Application) -> None:
    heard = Heard(app)
    for component, event in (
        ("face_detecter", "face_detected"),
        ("person_detecter", "person_detected"),
        ("person_localizer", "person_localized"),
        ("gesture_recognizer", "gesture_recognized"),
        ("sight", "seen"),
    ):
        await heard.subscribe(component, event)
    camera = await app.play(VIDEO, VP8, "sendonly")
    await heard.until("face_detected", number=2)
    await heard.until("person_detected", number=2)
    assert await heard.until("gesture_recognized", gesture_ref=["urn:x-rois:def:gesture:OMG::1"])
    both = next(told for told in heard.all("seen") if len(told["person_ref"]) == 2)
    placed = next(told for told in heard.all("person_localized") if len(told["person_ref"]) == 2)
    assert set(both["person_ref"]) == set(placed["person_ref"])
    for box, where in zip(sorted(both["box"]), (0.28, 0.74), strict=True):
        left, _top, width, _height = (float(share) for share in box.split(","))
        assert left + width / 2 == pytest.approx(where, abs=0.04)
    for position, (right, ahead) in zip(sorted(placed["position_data"]), ((-0.18, 0.72), (0.2, 0.72)), strict=True):
        x, y, _th = (float(part) for part in position.split(","))
        assert (x, y) == pytest.approx((right, ahead), rel=0.25)
    assert await app.act("disconnect", camera) == "OK"
    await heard.until("person_detected", number=0)
    assert await app.news.until(lambda: heard.all("seen")[-1]["person_ref"] == [])
