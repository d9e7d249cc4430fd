"""The dead man's switch and what is done before it, on a clock that is turned by hand."""

import asyncio
from collections.abc import AsyncIterator

import pytest
from openrois_body.teleoperation.pilot import PATIENCE, Pilot
from openrois_body.teleoperation.steering import STANDING, Steering, Velocity
from openrois_streaming.input.messages import NOTHING, Gamepad, Held, Pointer

from tests.support.streaming import VirtualClock, settle
from tests.support.teleoperation import Hand, LoggedControls, W

LIMIT = 0.5
"""Seconds within which motion has to stop when nothing comes any more."""


class Flight:
    """A pilot, what it does, and why it stopped."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.controls = LoggedControls(self.clock)
        self.hand = Hand()
        self.reasons: list[str] = []
        self.paced: list[str] = []
        self.pilot = Pilot(
            self.controls,
            lambda: Steering(max_speed=1, max_turn=1),
            self.clock,
            self.reasons.append,
            self.paced.append,
        )

    def hold(self, held: Held = W) -> None:
        self.pilot.handle_input(self.hand.state(held), held)


@pytest.fixture
async def flight() -> AsyncIterator[Flight]:
    made = Flight()
    watching = asyncio.ensure_future(made.pilot.watch())
    await settle()
    yield made
    assert not watching.done()
    watching.cancel()


async def test_figure_is_driven_while_states_come_and_stops_soon_after_the_last(flight: Flight) -> None:
    for _ in range(20):
        flight.hold()
        await flight.clock.advance(0.1)
    assert flight.controls.words == ["drive"] * 20
    assert (flight.pilot.is_active, flight.pilot.velocity) == (True, Velocity(ahead=1))
    last, _, _ = flight.controls.done[-1]
    await flight.clock.advance(10)
    stopped, what, reason = flight.controls.done[-1]
    assert (what, reason, flight.reasons) == ("halt", "no input came for 0.4 s", ["no input came for 0.4 s"])
    assert flight.controls.words.count("halt") == 1
    assert stopped - last == pytest.approx(PATIENCE)
    assert stopped - last < LIMIT
    assert (flight.pilot.is_active, flight.pilot.velocity) == (False, STANDING)


async def test_figure_goes_on_when_states_come_again(flight: Flight) -> None:
    flight.hold()
    await flight.clock.advance(1)
    flight.hold()
    assert flight.controls.words == ["drive", "halt", "drive"]
    await flight.clock.advance(1)
    assert len(flight.reasons) == 2


async def test_release_by_the_operator_is_no_stop(flight: Flight) -> None:
    flight.hold()
    flight.hold(NOTHING)
    await flight.clock.advance(10)
    assert flight.controls.words == ["drive", "halt"]
    assert flight.reasons == []


async def test_input_without_held_keys_sends_no_commands(flight: Flight) -> None:
    for held in (NOTHING, Held(gamepad=Gamepad((0.04, -0.04)))):
        flight.hold(held)
    await flight.clock.advance(10)
    assert (flight.controls.done, flight.reasons) == ([], [])


async def test_a_key_that_moves_nothing_is_released_for_the_engine(flight: Flight) -> None:
    flight.hold(Held(frozenset({"KeyX"})))
    await flight.clock.advance(1)
    assert flight.controls.done == []
    assert [message["event"] for message in flight.controls.passed] == ["state", "release"]
    assert flight.controls.passed[-1]["why"] == "lost"
    assert flight.reasons == ["no input came for 0.4 s"]


@pytest.mark.parametrize("why", ["blur", "hidden", "bye", "lost"])
async def test_a_release_stops_at_once_and_says_why(flight: Flight, why: str) -> None:
    flight.hold()
    flight.pilot.handle_input(flight.hand.release(why), NOTHING)
    assert flight.controls.words == ["drive", "halt"]
    assert len(flight.reasons) == 1
    flight.pilot.handle_input(flight.hand.release(why), NOTHING)
    await flight.clock.advance(10)
    assert len(flight.reasons) == 1


async def test_a_lost_link_stops_at_once(flight: Flight) -> None:
    flight.hold()
    flight.pilot.lose("the viewer is gone")
    flight.pilot.lose("the viewer is gone")
    assert [done[1:] for done in flight.controls.done[1:]] == [("halt", "the viewer is gone")]
    assert flight.reasons == ["the viewer is gone"]


async def test_eyes_turn_to_a_new_target(flight: Flight) -> None:
    for x in (0.5, 0.5, 1.0):
        flight.hold(Held(pointer=Pointer(x, 0.5)))
    flight.hold(NOTHING)
    assert [how for _, what, how in flight.controls.done if what == "look"] == [(0.0, 0.0), (1.0, 0.0)]
    assert not flight.pilot.is_active


async def test_an_engine_that_is_back_looks_where_the_one_before_did(flight: Flight) -> None:
    pointing = Held(W.keys, pointer=Pointer(1.0, 0.5))
    flight.hold(pointing)
    flight.controls.failure = "the game engine is gone"
    flight.hold(pointing)
    flight.controls.failure = ""
    flight.hold(pointing)
    assert flight.controls.words == ["look", "drive"] * 2


async def test_failure_of_the_engine_is_reported_once(flight: Flight) -> None:
    flight.hold()
    flight.controls.failure = "the game engine is gone"
    for _ in range(5):
        flight.hold()
    assert flight.reasons == ["the game engine is gone"]
    assert (flight.pilot.is_active, flight.pilot.velocity) == (False, STANDING)
    flight.controls.failure = ""
    flight.hold()
    assert flight.pilot.velocity == Velocity(ahead=1)
    flight.controls.failure = "the game engine is gone"
    flight.hold()
    assert len(flight.reasons) == 2


async def test_on_a_long_way_it_goes_slower_and_says_so_once(flight: Flight) -> None:
    for round_trip in (None, 0.5, 0.52, 1.0, None, 2.0, 0.52, 0.3, 0.3):
        flight.pilot.handle_input(flight.hand.state(), W, round_trip)
    driven = [how.ahead for _, _, how in flight.controls.done if isinstance(how, Velocity)]
    assert driven == pytest.approx([1, 1, 0.5 / 0.52, 0.5, 0.5, 0.25, 0.5 / 0.52, 1, 1])
    assert flight.paced == [
        "the round trip to the body takes 1.0 s: it goes slower",
        "the body goes at full speed again",
    ]
    assert flight.reasons == []
