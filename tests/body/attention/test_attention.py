"""Senses follow the visitor that is attended to, and what they announce names it, as far as it consents."""

import asyncio
import gc
import weakref
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress

import numpy as np
import pytest
from openrois_body.attention.attention import Attention
from openrois_body.attention.faces import INTERVAL, FaceSizes
from openrois_body.attention.rule import LOUDEST
from openrois_body.components.visitors import Visitors
from openrois_body.vision.box import Box, Face
from openrois_body.vision.view import View
from openrois_media.devices import Camera, Microphone
from openrois_media.visitors.registry import VisitorRegistry
from openrois_streaming.source.source import RawAudio, RawVideo

from openrois.contract import Event
from openrois.engine.registry import LocalRegistry
from openrois.errors import BadParameter
from openrois.types.codes import Purpose
from openrois.types.messages import Argument
from tests.media.visitors.test_visitor import BOTH, LIVE, Sender, block
from tests.support.loopback import PATIENCE
from tests.support.streaming import FedSource, VirtualClock, settle

LOUD, QUIET = 16_000, 30


class BrightFaces:
    """A finder that takes bright pictures for near faces, and notes what it was asked for."""

    def __init__(self) -> None:
        self.looked = 0

    def available(self) -> tuple[bool, str]:
        return True, ""

    def find(self, view: View, known: Sequence[Face]) -> Sequence[Face]:
        self.looked += 1
        side = float(view.raw.data[0, 0]) / 255
        return [Face(Box(0.0, 0.0, side, side))] if side else []


def picture(brightness: int, at: float) -> RawVideo:
    return RawVideo(np.full((24, 16), brightness, np.uint8), "i420", 16, 16, 0, at)


class Place:
    """A body with attention, and what its microphone hears."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.visitors = VisitorRegistry("robot", self.clock)
        self.microphone = Microphone(self.clock, self.visitors)
        self.camera = Camera(self.visitors)
        self.finder = BrightFaces()
        self.attention = Attention(
            self.visitors, self.microphone, self.camera, self.clock, FaceSizes(self.finder, self.clock)
        )
        self.component = Visitors("robot", self.visitors, self.attention)
        self.registry = LocalRegistry("robot", (self.component,))
        self.events: list[tuple[str, dict[str, str]]] = []
        self.live: list[RawAudio] = []
        self.to_recognise: list[RawAudio] = []
        self.microphone.sound_received.add(self.live.append)
        self.microphone.sound_to_recognise.add(self.to_recognise.append)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        tasks = [asyncio.ensure_future(work) for work in (self.attention.run(), self.microphone.listen())]
        await settle()
        yield
        for task in tasks:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task

    async def sound(self, seconds: float, **levels: int) -> None:
        """Let visitors be heard with these levels for a while, in blocks of 20 ms."""
        for _ in range(round(seconds * 50)):
            for name, level in levels.items():
                await self.senders[name].source.feed(block(self.clock.now(), level))
            await self.clock.advance(0.02)

    senders: dict[str, Sender]

    def come(self, *names: str, consent: frozenset[Purpose] = BOTH) -> None:
        self.senders = {
            **getattr(self, "senders", {}),
            **{name: Sender(self.visitors, consent, name) for name in names},
        }

    def ref(self, name: str) -> str:
        return self.senders[name].visitor.visitor_ref

    async def subscribe(self, *events: str) -> None:
        for event in events:
            await self.registry.subscribe("robot/visitors", event, self._note)

    def _note(self, item: object) -> None:
        assert isinstance(item, Event)
        self.events.append((item.event_type, {result.name: result.value for result in item.results}))


@pytest.fixture
async def place() -> AsyncIterator[Place]:
    place = Place()
    async with place.running():
        yield place


async def test_a_single_visitor_is_attended_to_at_once_and_measured_by_nothing_else(place: Place) -> None:
    place.come("ann")
    assert place.attention.attended == place.ref("ann")
    await settle()
    await place.sound(0.1, ann=LOUD)
    assert {each.sender for each in place.to_recognise} == {place.ref("ann")}
    assert place.senders["ann"].visitor.microphone._fanout.readers == 1


async def test_the_loudest_voice_is_attended_to_and_only_that_one_is_heard(place: Place) -> None:
    place.come("ann", "bob")
    place.attention.set_mode(LOUDEST)
    await place.sound(4.0, ann=QUIET, bob=LOUD)
    assert place.attention.attended == place.ref("bob")
    before = len(place.live)
    await place.sound(0.2, ann=QUIET, bob=LOUD)
    assert {each.sender for each in place.live[before:]} == {place.ref("bob")}


async def test_one_that_leaves_is_followed_by_the_other(place: Place) -> None:
    await place.subscribe("attended")
    place.come("ann", "bob")
    place.visitors.forget_client(place.senders["ann"].client)
    assert place.attention.attended == place.ref("bob")
    await settle()
    await place.sound(0.1, bob=LOUD)
    assert {each.sender for each in place.to_recognise} == {place.ref("bob")}
    place.visitors.forget_client(place.senders["bob"].client)
    told = [params["visitor_ref"] for name, params in place.events if name == "attended"]
    assert told == [place.ref("ann"), place.ref("bob"), ""]


async def test_what_is_consented_to_for_one_purpose_goes_to_that_alone(place: Place) -> None:
    place.come("ann", consent=LIVE)
    await settle()
    await place.sound(0.1, ann=LOUD)
    assert place.live
    assert not place.to_recognise
    place.senders["ann"].consent(Purpose.RECOGNITION)
    place.live.clear()
    await place.sound(0.1, ann=LOUD)
    assert not place.live
    assert place.to_recognise


async def test_one_that_withdraws_everything_is_followed_by_the_other(place: Place) -> None:
    place.come("ann", "bob")
    place.senders["ann"].consent()
    assert place.attention.attended == place.ref("bob")
    assert place.microphone.inlet.stream_id == place.ref("bob")
    place.senders["bob"].consent(Purpose.AGENT)
    assert place.attention.attended == ""
    assert place.microphone.inlet.stream_id is None


async def test_the_nearest_face_is_attended_to_by_one_picture_a_second(place: Place) -> None:
    place.come("ann", "bob")
    cameras: dict[str, FedSource[RawVideo]] = {}
    for name in ("ann", "bob"):
        sender = place.senders[name]
        sink = place.visitors.sink(sender.client, place.visitors.cameras, "video")
        place.visitors.add_stream(sender.client, f"{name}/camera", sink, None)
        cameras[name] = FedSource()
        sink.plug(f"{name}/camera", cameras[name])
    looks, seconds = place.finder.looked, 8
    for _ in range(seconds * 5):
        for name, brightness in (("ann", 50), ("bob", 200)):
            if cameras[name].is_open:
                before = place.finder.looked
                await cameras[name].feed(picture(brightness, place.clock.now()))
                # The finder runs in a thread.
                async with asyncio.timeout(PATIENCE):
                    while place.finder.looked == before:  # noqa: ASYNC110 - see above
                        await asyncio.sleep(0.001)
                await settle()
        await place.clock.advance(0.2)
    assert place.attention.attended == place.ref("bob")
    assert place.camera.inlet.stream_id == place.ref("bob")
    assert 2 <= place.finder.looked - looks <= seconds / INTERVAL


async def test_another_visitor_is_seen_where_the_attended_one_has_no_camera(place: Place) -> None:
    place.come("ann", "bob")
    bob = place.senders["bob"]
    place.visitors.add_stream(
        bob.client, "bob/camera", place.visitors.sink(bob.client, place.visitors.cameras, "video"), None
    )
    assert place.attention.attended == place.ref("ann")
    assert (place.microphone.inlet.stream_id, place.camera.inlet.stream_id) == (place.ref("ann"), place.ref("bob"))


async def test_an_operator_names_whom_to_attend_to(place: Place) -> None:
    place.come("ann", "bob")

    async def attend(text: str) -> None:
        argument = Argument(name="attention", data_type_ref="string", value=text)
        await place.registry.invoke("robot/visitors", "set_parameter", (argument,))

    await attend(place.ref("bob"))
    assert place.attention.attended == place.ref("bob")
    with pytest.raises(BadParameter, match="attention is nearest, loudest or a visitor_ref of now: urn:"):
        await attend("somebody")
    await attend("loudest")
    assert place.attention.mode == LOUDEST


async def test_applications_are_told_who_is_there_and_what_each_consents_to(place: Place) -> None:
    await place.subscribe("visitor_changed")
    place.come("ann", consent=LIVE)
    ref = place.ref("ann")
    results = await place.registry.query("robot/visitors", "visitors")
    assert {result.name: result.value for result in results} == {
        "visitor_ref": f'["{ref}"]',
        "devices": '["microphone"]',
        "consent": '["live"]',
        "attended": ref,
    }
    place.senders["ann"].consent(Purpose.AGENT, Purpose.LIVE)
    place.senders["ann"].consent(Purpose.AGENT, Purpose.LIVE)
    place.visitors.forget_client(place.senders["ann"].client)
    told = [(params["devices"], params["consent"]) for _, params in place.events]
    assert told == [("microphone", "live"), ("microphone", "agent live"), ("", "")]


async def test_of_visitors_that_have_left_nothing_is_kept(place: Place) -> None:
    gone = []
    for number in range(200):
        place.come("ann", "bob")
        for name in ("ann", "bob"):
            sender = place.senders.pop(name)
            gone.append(weakref.ref(sender.visitor))
            place.attention.note_face(sender.visitor.visitor_ref, 0.2)
            if number % 2:
                await settle()
            place.visitors.forget_client(sender.client)
            await sender.source.end()
            del sender
    await place.clock.advance(1.0)
    gc.collect()
    # The inlets of the senses may know the last one until another comes.
    assert sum(each() is not None for each in gone) <= 1
    assert place.component._told == {}
