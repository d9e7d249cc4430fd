"""Whose input is taken: that of the application that holds the component while it is started."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_body.teleoperation.pilot import PATIENCE, Pilot
from openrois_body.teleoperation.steering import STANDING, Steering
from openrois_streaming.input.messages import Held, Pointer
from openrois_streaming.input.reader import AT_ONCE, MALFORMED_LIMIT
from openrois_streaming.peer.input_channels import InputSink

from openrois.contract import Client
from openrois.errors import OutOfResources
from openrois.types.streams import HolderNotification
from tests.support.streaming import VirtualClock
from tests.support.teleoperation import Hand, LoggedControls, text

REF = "avatar/teleoperation"
GAZE = "avatar/gaze"


class Room:
    """A seat, and applications that would like to have it."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.controls = LoggedControls(self.clock)
        self.seat = OperatorControl(REF, self.clock, GAZE)
        self.told: dict[str, list[Any]] = {"ann": [], "bob": []}
        self.clients = {name: Client(name, lambda _method, _params: None) for name in self.told}
        self.hands: dict[str, InputSink] = {name: self.sit(name) for name in self.told}
        self.hand = Hand()
        self.reasons: list[str] = []
        self.pilot = Pilot(
            self.controls,
            Steering,
            self.clock,
            self.reasons.append,
            may_turn_eyes=lambda: self.seat.may_turn_eyes,
        )

    def sit(self, name: str) -> InputSink:
        return self.seat.input_sink(self.clients[name], lambda said: self.told[name].append(json.loads(said)))

    def tell(self, name: str, *, holds: bool = True, epoch: int = 1, component_ref: str = REF) -> None:
        told = HolderNotification(component_ref=component_ref, holds=holds, epoch=epoch)
        self.seat.apply_holder(told, self.clients[name])

    def press(self, name: str) -> None:
        self.hands[name].input_came("input", text(self.hand.state()))

    def point(self, name: str) -> None:
        """Point to the upper left corner of the picture."""
        self.hands[name].input_came("input", text(self.hand.state(Held(pointer=Pointer(0, 0)))))

    @asynccontextmanager
    async def operated(self) -> AsyncIterator["asyncio.Future[str]"]:
        with self.seat.operated(self.pilot) as vacated:
            yield vacated


@pytest.fixture
def room() -> Room:
    return Room()


async def test_the_holder_operates_once_it_is_started(room: Room) -> None:
    room.tell("ann")
    room.press("ann")
    assert room.controls.done == []
    async with room.operated():
        room.press("ann")
        room.hands["ann"].input_came("control", text(room.hand.key("KeyA")))
        assert room.controls.words == ["drive", "drive"]
    room.press("ann")
    assert room.controls.words == ["drive", "drive", "halt"]
    assert (room.seat.figures.taken, room.seat.figures.refused) == (2, 2)
    assert room.reasons == ["teleoperation was stopped"]


async def test_input_of_another_application_is_refused_once_a_second(room: Room) -> None:
    room.tell("ann")
    async with room.operated():
        for _ in range(3):
            room.press("bob")
        await room.clock.advance(1)
        room.press("bob")
    assert room.controls.done == []
    assert room.seat.figures.refused == 4
    assert room.told["bob"] == [{"event": "refused", "reason": f"{REF} has to be bound and started first"}] * 2


async def test_start_is_refused_while_no_application_holds_it(room: Room) -> None:
    room.tell("ann", component_ref="avatar/reaction")
    with pytest.raises(OutOfResources, match=REF):
        async with room.operated():
            pass
    room.tell("ann")
    room.tell("ann", holds=False)
    with pytest.raises(OutOfResources, match=REF):
        async with room.operated():
            pass


@pytest.mark.parametrize("how", ["released", "gone", "bound"])
async def test_who_does_not_hold_it_any_more_is_stopped_at_once(room: Room, how: str) -> None:
    room.tell("ann")
    async with room.operated() as vacated:
        room.press("ann")
        if how == "released":
            room.tell("ann", holds=False)
        elif how == "gone":
            room.seat.forget_client(room.clients["ann"])
        else:
            room.tell("bob", epoch=2)
        assert room.controls.words == ["drive", "halt"]
        assert how in await vacated
        room.press("ann")
        room.press("bob")
        assert room.controls.words == ["drive", "halt"]


async def test_what_is_said_again_or_too_late_changes_nothing(room: Room) -> None:
    room.tell("ann", epoch=5)
    async with room.operated() as vacated:
        room.press("ann")
        room.tell("ann", epoch=5)
        room.tell("bob", epoch=4)
        room.tell("bob", holds=False, epoch=4)
        room.seat.forget_client(room.clients["bob"])
        room.press("ann")
        assert not vacated.done()
        assert room.controls.words == ["drive", "drive"]


async def test_the_eyes_are_those_of_the_application_that_holds_the_gaze(room: Room) -> None:
    room.tell("ann")
    async with room.operated():
        room.point("ann")
        assert room.controls.done[-1][1:] == ("look", (-1, 1))
        room.tell("bob", component_ref=GAZE, epoch=3)
        room.tell("ann", component_ref=GAZE, epoch=2)
        room.point("ann")
        assert room.controls.words == ["look"]
        room.press("ann")
        assert room.controls.words == ["look", "drive"], "its input drives all the same"
        room.tell("bob", component_ref=GAZE, holds=False, epoch=3)
        room.point("ann")
        assert room.controls.words[2:] == ["look", "halt"], "the eyes may have been turned away meanwhile"


@pytest.mark.parametrize("how", ["it is its own", "its holder is gone"])
async def test_an_operator_turns_the_eyes_where_no_other_application_holds_the_gaze(room: Room, how: str) -> None:
    room.tell("ann")
    async with room.operated():
        room.tell("bob", component_ref=GAZE)
        if how == "it is its own":
            room.tell("ann", component_ref=GAZE, epoch=2)
        else:
            room.seat.forget_client(room.clients["bob"])
        room.point("ann")
        assert room.controls.words == ["look"]


async def test_a_lost_link_lets_go(room: Room) -> None:
    room.tell("ann")
    async with room.operated():
        room.press("ann")
        room.hands["bob"].input_lost("the viewer is gone")
        assert room.reasons == []
        room.hands["ann"].input_lost("the viewer is gone")
        assert room.reasons == ["the viewer is gone"]
        room.seat.notify_operator("stopped", "the viewer is gone")
    assert room.told["ann"] == [{"event": "stopped", "reason": "the viewer is gone"}]
    room.seat.notify_operator("stopped", "not delivered")
    assert len(room.told["ann"]) == 1


async def test_what_was_held_when_it_stopped_counts_as_let_go(room: Room) -> None:
    room.tell("ann")
    async with room.operated():
        watching = asyncio.ensure_future(room.pilot.watch())
        room.hands["ann"].input_came("control", text(room.hand.key("KeyW")))
        assert room.pilot.velocity.ahead > 0
        await room.clock.advance(PATIENCE)
        assert room.pilot.velocity == STANDING
        room.hands["ann"].input_came("control", text(room.hand.key("KeyA")))
        assert (room.pilot.velocity.ahead, room.pilot.velocity.turn > 0) == (0, True)
        room.hands["ann"].input_came("control", text(room.hand.key("KeyD")))
        assert room.pilot.velocity == STANDING, "what contradicts itself comes to nothing: the other one is held still"
        watching.cancel()


async def test_how_long_the_way_is_decides_how_fast_the_figure_goes(room: Room) -> None:
    round_trips = iter((0.2, 1.0))
    hands = room.seat.input_sink(room.clients["ann"], lambda _text: None, lambda: next(round_trips))
    room.tell("ann")
    async with room.operated():
        for ahead in (0.8, 0.4):
            hands.input_came("input", text(room.hand.state()))
            assert room.pilot.velocity.ahead == pytest.approx(ahead)


async def test_what_was_held_before_it_was_started_has_to_be_told_again(room: Room) -> None:
    room.tell("ann")
    room.hands["ann"].input_came("control", text(room.hand.key("KeyW")))
    async with room.operated():
        room.hands["ann"].input_came("control", text(room.hand.key("KeyA")))
        assert (room.pilot.velocity.ahead, room.pilot.velocity.turn > 0) == (0, True)
        room.press("ann")
        assert room.pilot.velocity.ahead > 0


async def test_stale_malformed_and_excessive_messages_are_counted_and_do_nothing(room: Room) -> None:
    room.tell("ann")
    async with room.operated():
        late = text(room.hand.state())
        room.press("ann")
        room.hands["ann"].input_came("input", late)
        room.hands["ann"].input_came("input", b"")
        assert (room.seat.figures.dropped, room.seat.figures.malformed) == (1, 1)
        for _ in range(AT_ONCE):
            room.press("ann")
        assert room.seat.figures.dropped == 4
        assert room.controls.words == ["drive"] * (AT_ONCE - 2)


async def test_who_sends_nonsense_is_cut_and_told(room: Room) -> None:
    room.tell("ann")
    async with room.operated():
        for _ in range(MALFORMED_LIMIT):
            room.hands["ann"].input_came("control", "nonsense")
        assert room.told["ann"][0]["event"] == "refused"
        assert "not JSON" in room.told["ann"][0]["reason"]
        room.press("ann")
        assert room.controls.done == []
        room.hands["ann"] = room.sit("ann")
        room.press("ann")
        assert room.controls.words == ["drive"]
