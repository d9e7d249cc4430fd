"""The simulated robot: commands in, events out, driven by the clock."""

from math import dist, hypot, pi, remainder, tau

import pytest
from openrois_body.messages import (
    Completed,
    Drive,
    Floor,
    Halt,
    Look,
    Place,
    Reached,
    React,
    Silence,
    Things,
    Walk,
    Waypoint,
)
from openrois_body.motion.ground import Ground
from openrois_body.motion.planning import plan as way_to
from openrois_body.motion.wayfinding import BODY
from openrois_robots.simulated.physics import RADIUS
from openrois_robots.simulated.world.plan import APARTMENT

from tests.support.simulated_robot import Rooms, at

pytestmark = pytest.mark.extra(name="robot")

GROUND = Ground(APARTMENT.floor, BODY)


def walk(rooms: Rooms, *path: Waypoint, speed: float = 1.0) -> None:
    rooms.told.clear()
    rooms.simulation.send(Walk("1", path, speed))


def go(rooms: Rooms, x: float, y: float) -> Completed:
    """Drive to a place round all that the map has."""
    here = rooms.place
    walk(rooms, *(Waypoint(*point) for point in way_to(GROUND, (here.x, here.y), here.th, (x, y), "time")))
    return rooms.outcome()


def test_it_begins_with_floor_place_and_things() -> None:
    rooms = Rooms()
    floor, place, things = rooms.told
    assert floor == APARTMENT.floor
    assert isinstance(place, Place)
    assert (place.x, place.y, place.th) == pytest.approx((-4, -2.5, pi / 4), abs=1e-6)
    assert isinstance(things, Things)
    assert {thing.name for thing in things.things} >= {"reader", "cook", "clerk", "dock", "sofa"}


@pytest.mark.parametrize("goal", [(2.5, 1.0), (1.2, -0.9), (-1.5, 2.7), (4.4, 2.4), (-3.5, 2.75), (4.5, -0.2)])
def test_it_drives_from_room_to_room(goal: tuple[float, float]) -> None:
    rooms = Rooms()
    assert go(rooms, *goal) == Completed("1", "OK")
    assert dist((rooms.place.x, rooms.place.y), goal) < 0.05
    reached = [each for each in rooms.told if isinstance(each, Reached)]
    assert [each.index for each in reached] == list(range(len(reached)))
    places = [each for each in rooms.told if isinstance(each, Place)]
    assert dist((places[-1].x, places[-1].y), goal) < 0.05


def test_places_are_reported_often_but_not_too_often() -> None:
    rooms = Rooms()
    walk(rooms, Waypoint(-1.5, -2.5))
    places = []
    for _ in range(200):
        rooms.told.clear()
        rooms.run(0.01, 0.01)
        places += [each for each in rooms.told if isinstance(each, Place)]
    assert 30 <= len(places) <= 41


def test_the_same_commands_at_the_same_times_do_the_same() -> None:
    tracks = []
    for turn in (0.1, 0.05):
        rooms = Rooms(visitor=True)
        walk(rooms, Waypoint(-1.6, -2.4), Waypoint(-1.6, 0.0))
        rooms.run(6, turn)
        tracks.append(rooms.place)
    assert tracks[0] == tracks[1]


@pytest.mark.parametrize("angle", [0.0, 0.3, pi / 2, 2.0, pi, -1.0])
def test_whatever_it_is_driven_into_it_stays_in_the_room(angle: float) -> None:
    rooms = Rooms(at(-2.6, -0.5, angle))
    solid = Ground(Floor(APARTMENT.floor.outline, APARTMENT.floor.obstacles), RADIUS - 0.02)
    for _ in range(80):
        rooms.simulation.send(Drive(2.0, 0.0, 0.0))
        rooms.run(0.1)
        assert solid.clear_at((rooms.place.x, rooms.place.y))
    moved = rooms.place
    rooms.simulation.send(Drive(2.0, 0.0, 0.0))
    rooms.run(0.4)
    assert hypot(rooms.place.x - moved.x, rooms.place.y - moved.y) < 0.02, "it stands before what is in the way"


def test_what_the_map_does_not_have_is_told_as_stuck() -> None:
    rooms = Rooms(at(3.0, -1.2))
    outcome = go(rooms, 4.6, -3.1)
    away = hypot(4.6 - rooms.place.x, -3.1 - rooms.place.y)
    reason = f"stuck {away:.2f} m before the goal: something that the map does not have is in the way"
    assert outcome == Completed("1", "ERROR", reason)
    assert 0.4 < away < 1.0
    assert go(rooms, 1.2, -0.9) == Completed("1", "OK"), "it gets away from there"


def test_halt_ends_a_walk_and_it_stands_soon() -> None:
    rooms = Rooms()
    walk(rooms, Waypoint(-1.5, -2.5))
    rooms.run(2)
    rooms.simulation.send(Halt())
    rooms.simulation.advance()
    assert [each for each in rooms.told if isinstance(each, Completed)] == [Completed("1", "ABORT")]
    rooms.run(0.5)
    there = rooms.place
    rooms.run(2)
    assert rooms.place == there


def test_a_drive_ends_by_itself() -> None:
    rooms = Rooms()
    rooms.simulation.send(Drive(0.5, 0.0, 0.0))
    rooms.run(1)
    there = rooms.place
    assert dist((there.x, there.y), (-4, -2.5)) > 0.03
    rooms.run(2)
    assert rooms.place == there


def test_it_has_no_reactions_and_ignores_what_is_for_faces() -> None:
    rooms = Rooms()
    rooms.told.clear()
    rooms.simulation.send(Silence())
    rooms.simulation.send(React("2", "wave"))
    assert not any(isinstance(each, Completed) for each in rooms.told), "the sender is told when it has sent"
    rooms.simulation.advance()
    assert Completed("2", "ERROR", "the robot has no reactions") in rooms.told


def test_a_gaze_turns_the_camera() -> None:
    rooms = Rooms()
    ahead = rooms.simulation.view()
    rooms.simulation.send(Look(-1.0, 1.0))
    aside = rooms.simulation.view()
    assert remainder(aside.camera.th - ahead.camera.th, tau) == pytest.approx(0.7), "to the left"
    assert aside.tilt > 0 > ahead.tilt, "it sees the floor ahead"
    assert rooms.place.th == pytest.approx(ahead.camera.th), "the robot stands"


class TestBattery:
    def test_driving_takes_charge_and_the_dock_gives_it_back(self) -> None:
        rooms = Rooms(charge=0.6)
        told: list[tuple[int, bool]] = []
        rooms.simulation.battery_changed.add(lambda battery: told.append((battery.percent, battery.is_charging)))
        rooms.run(30)
        assert told[0][1], "it begins on the mat"
        charged = rooms.simulation.battery.charge
        assert charged > 0.6
        assert go(rooms, 2.5, 1.0).status == "OK"
        assert rooms.simulation.battery.charge < charged
        assert told[-1][1] is False

    def test_time_takes_charge_also_when_nothing_happens_for_long(self) -> None:
        rooms = Rooms(at(-1.6, -1.6), charge=1.0, standing=120)
        rooms.clock.jump(3600)
        rooms.simulation.advance()
        assert rooms.simulation.battery.charge == pytest.approx(0.5, abs=0.001)

    def test_with_a_low_battery_only_the_dock_is_a_goal(self) -> None:
        rooms = Rooms(at(-1.6, -1.6), charge=0.18)
        rooms.told.clear()
        walk(rooms, Waypoint(-1.6, 0.0))
        rooms.simulation.advance()
        reason = "the battery is at 18 %; below 20 % only the dock is a goal"
        assert Completed("1", "ERROR", reason) in rooms.told
        rooms.told.clear()
        assert go(rooms, -3.7, -2.4) == Completed("1", "OK")
        rooms.run(60)
        assert rooms.simulation.battery.is_charging

    def test_a_walk_that_began_before_goes_on_with_a_low_battery(self) -> None:
        rooms = Rooms(at(-1.6, -1.6), charge=0.2001, driving=5, standing=5)
        assert go(rooms, -1.6, 0.4) == Completed("1", "OK")
        assert rooms.simulation.battery.is_low

    def test_an_empty_battery_ends_a_walk(self) -> None:
        rooms = Rooms(at(-1.6, -1.6), charge=0.01, low=0.0, driving=5, standing=5)
        outcome = go(rooms, -1.6, 2.6)
        assert (outcome.status, rooms.simulation.battery.is_empty) == ("ERROR", True)
        assert outcome.reason.startswith("the battery is empty")
        rooms.run(1)
        there = rooms.place
        rooms.simulation.send(Drive(0.5, 0, 0))
        rooms.run(1)
        assert rooms.place == there, "nor can it be driven by hand"

    def test_pushed_to_its_dock_it_is_charged_until_it_drives_again(self) -> None:
        rooms = Rooms(at(-1.6, -1.6), charge=0.0, charging=10)
        rooms.simulation.push_to_dock()
        assert (rooms.place.x, rooms.place.y) == pytest.approx((-4.0, -2.5), abs=1e-5)
        assert [each for each in rooms.told if isinstance(each, Place)][-1] == rooms.place
        rooms.run(20)
        walk(rooms, Waypoint(-3.9, -2.4))
        assert rooms.outcome().status == "ERROR", "it is not charged by a twentieth yet"
        rooms.run(120)
        rooms.told.clear()
        walk(rooms, Waypoint(-3.9, -2.4))
        assert rooms.outcome().status == "OK"

    def test_a_push_ends_what_it_did(self) -> None:
        rooms = Rooms()
        walk(rooms, Waypoint(-1.5, -2.5))
        rooms.run(2)
        rooms.simulation.push_to_dock()
        assert rooms.outcome() == Completed("1", "ABORT", "the robot was pushed to its dock")


class TestVisitor:
    def test_without_one_nothing_moves(self) -> None:
        rooms = Rooms()
        rooms.told.clear()
        rooms.run(30)
        assert rooms.told == []
        assert rooms.simulation.view().visitor is None

    def test_a_visitor_walks_its_round_and_is_reported(self) -> None:
        rooms = Rooms(visitor=True)
        seen = []
        for _ in range(60):
            rooms.told.clear()
            rooms.run(1)
            reports = [each for each in rooms.told if isinstance(each, Things)]
            assert len(reports) <= 11
            seen += [thing for each in reports for thing in each.things if thing.id == "visitor"]
        assert {thing.kind for thing in seen} == {"person"}
        for x, y in APARTMENT.round:
            assert min(dist((thing.x, thing.y), (x, y)) for thing in seen) < 0.1
        assert rooms.simulation.view().step > 10

    def test_robot_and_visitor_keep_apart(self) -> None:
        rooms = Rooms(at(-1.9, -1.5, pi / 2), visitor=True)
        for _ in range(300):
            rooms.run(0.1)
            rooms.simulation.send(Drive(0.6, 0.0, 0.0))
            visitor = rooms.simulation.view().visitor
            assert visitor is not None
            assert dist((visitor.x, visitor.y), (rooms.place.x, rooms.place.y)) > 0.4


def test_after_a_hold_up_it_does_not_race_through_the_rooms() -> None:
    rooms = Rooms()
    walk(rooms, Waypoint(-1.5, -2.5))
    rooms.run(1)
    before = rooms.place
    rooms.clock.jump(100)
    rooms.simulation.advance()
    assert dist((before.x, before.y), (rooms.place.x, rooms.place.y)) < 1.0
