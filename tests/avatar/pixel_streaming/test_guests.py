"""Which player operates, when an application comes first, and when the figure stops by itself."""

import asyncio
from collections.abc import AsyncIterator

import pytest
from openrois_avatar.pixel_streaming.guests import FIRST_PRESS, STATE_INTERVAL, Guests
from openrois_avatar.pixel_streaming.player_input import PlayerInput
from openrois_avatar.pixel_streaming.protocol import Message
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_body.teleoperation.pilot import PATIENCE, Pilot
from openrois_body.teleoperation.steering import Steering

from openrois.contract import Client
from openrois.types.streams import HolderNotification
from tests.support.streaming import VirtualClock, settle
from tests.support.teleoperation import LoggedControls

REF = "avatar/teleoperation"


class Room:
    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.controls = LoggedControls(self.clock)
        self.operator_control = OperatorControl(REF, self.clock)
        self.guests = Guests(
            self.operator_control, lambda stopped: Pilot(self.controls, Steering, self.clock, stopped), self.clock
        )
        self.application = Client("application", lambda _method, _params: None)

    def bind(self, *, holds: bool = True) -> None:
        self.operator_control.apply_holder(
            HolderNotification(component_ref=REF, holds=holds, epoch=1), self.application
        )

    def halted(self) -> list[str]:
        return [str(how) for _, what, how in self.controls.done if what == "halt"]


class Player:
    def __init__(self, room: Room) -> None:
        self.owns: list[bool] = []
        self.room = room
        self.player_input = PlayerInput(room.clock.now)
        room.guests.join(self)

    def own(self, on: bool) -> None:
        self.owns.append(on)

    def does(self, name: str, *values: float) -> list[bool]:
        taken = self.player_input.read_changes(Message(name, values))
        return [self.room.guests.operate(self, each, self.player_input) for each in taken]

    def holds_w(self, *, repeats: bool = False) -> list[bool]:
        return self.does("KeyDown", 87, repeats)


@pytest.fixture
async def room() -> AsyncIterator[Room]:
    made = Room()
    running = asyncio.ensure_future(made.guests.run())
    await settle()
    yield made
    assert not running.done()
    running.cancel()
    await settle()


async def test_the_first_operates_and_the_next_when_it_is_gone(room: Room) -> None:
    first, second = Player(room), Player(room)
    room.guests.join(first)
    assert (first.holds_w(), second.holds_w()) == ([True], [False])
    assert room.controls.words == ["drive"]
    room.guests.leave(first, "the player is gone")
    room.guests.leave(first, "it is not there any more")
    assert (first.owns, second.owns, room.halted()) == ([True, False], [True], ["the player is gone"])
    assert first.player_input.held.keys == frozenset()
    assert second.holds_w(repeats=True) == [True]


async def test_an_application_that_binds_comes_first_and_players_after_it(room: Room) -> None:
    player = Player(room)
    player.holds_w()
    room.bind()
    assert room.halted() == ["an application has bound the avatar's teleoperation"]
    assert player.holds_w(repeats=True) == [False]
    late = Player(room)
    room.bind(holds=False)
    assert (player.owns, late.owns) == ([True, False, True], [])
    room.bind()
    room.operator_control.forget_client(room.application)
    assert player.holds_w() == [True]


async def test_a_press_counts_for_a_second_and_a_repeated_one_as_long_as_it_repeats(room: Room) -> None:
    player = Player(room)
    player.holds_w()
    await room.clock.advance(5)
    (halted,) = [at for at, what, _ in room.controls.done if what == "halt"]
    begun = room.controls.done[0][0]
    assert halted - begun == pytest.approx(FIRST_PRESS + PATIENCE, abs=2 * STATE_INTERVAL)
    assert player.player_input.held.keys == frozenset()

    room.controls.done.clear()
    player.holds_w()
    for _ in range(60):
        await room.clock.advance(1 / 30)
        player.holds_w(repeats=True)
    assert room.halted() == []
    last = room.clock.now()
    await room.clock.advance(5)
    (halted,) = [at for at, what, _ in room.controls.done if what == "halt"]
    assert halted - last <= 0.5


async def test_figure_stands_at_once_after_a_release(room: Room) -> None:
    player = Player(room)
    player.holds_w()
    player.does("KeyUp", 87)
    assert room.halted() == ["the operator released the controls"]
    await room.clock.advance(5)
    assert room.controls.words == ["drive", "halt"]


async def test_a_gamepad_that_tells_each_axis_is_passed_on_now_and_then_and_its_end_always(room: Room) -> None:
    player = Player(room)
    for _ in range(60):
        for axis in (1, 2, 3, 4):
            player.does("GamepadAnalog", 0, axis, 0.9 if axis == 2 else 0.0)
        await room.clock.advance(1 / 60)
    assert 10 <= room.controls.words.count("drive") <= 25
    for axis in (1, 2, 3, 4):
        player.does("GamepadAnalog", 0, axis, 0.0)
    await room.clock.advance(STATE_INTERVAL * 2)
    assert room.halted() == ["the operator released the controls"]


async def test_the_end_of_all_stops_the_figure() -> None:
    room = Room()
    running = asyncio.ensure_future(room.guests.run())
    await settle()
    Player(room).holds_w()
    running.cancel()
    await settle()
    assert room.halted() == ["operation by players has ended"]
