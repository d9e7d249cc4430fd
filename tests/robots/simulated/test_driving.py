"""How the base of a simulated robot drives, without physics: it goes where its velocity takes it."""

from dataclasses import dataclass, field
from math import cos, hypot, inf, pi, remainder, sin, tau

import pytest
from openrois_body.messages import Completed, Drive, Place, Reached, Walk, Waypoint
from openrois_robots.simulated.driving import HOLD, STUCK, BaseSettings, DriveControl, Velocity

pytestmark = pytest.mark.extra(name="robot")

STEP = 1 / 60


@dataclass
class Track:
    """A base in an empty plane, or held fast."""

    base: DriveControl = field(default_factory=lambda: DriveControl(BaseSettings()))
    place: Place = field(default_factory=lambda: Place(0.0, 0.0, 0.0))
    now: float = 100.0
    room: float = inf
    is_held: bool = False
    velocities: list[Velocity] = field(default_factory=list)
    places: list[Place] = field(default_factory=list)

    def step(self) -> None:
        velocity = self.base.choose(self.place, self.now, STEP, self.room)
        x, y = (0.0, 0.0) if self.is_held else (velocity.x * STEP, velocity.y * STEP)
        th = remainder(self.place.th + (0.0 if self.is_held else velocity.turn * STEP), tau)
        self.place = Place(self.place.x + x, self.place.y + y, th)
        self.now += STEP
        self.velocities.append(velocity)
        self.places.append(self.place)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.step()

    def walk(self, *path: Waypoint, speed: float = 5.0) -> list[Reached | Completed]:
        """Walk to the end, a minute at most, and return what was told."""
        self.base.walk(Walk("1", path, speed), self.place, self.now)
        end = self.now + 60
        while not any(isinstance(each, Completed) for each in self.base.news) and self.now < end:
            self.step()
        return self.base.news

    @property
    def fastest(self) -> float:
        return max(velocity.speed for velocity in self.velocities)


@pytest.fixture
def track() -> Track:
    return Track()


@pytest.mark.parametrize(
    "path",
    [
        (Waypoint(3, 0),),
        (Waypoint(0, 2), Waypoint(3, 2), Waypoint(3, 0, pi)),
        (Waypoint(-1, 0, 0.0),),
        (Waypoint(0, 0, 2.0),),
        (Waypoint(0, 0),),
        (Waypoint(0.1, 0.03), Waypoint(0.1, -0.03), Waypoint(0.13, 0.0, -3.0)),
        (Waypoint(-0.4, 0, 0.0), Waypoint(-0.8, 0, 0.0), Waypoint(-1, 0, 0.0)),
    ],
)
def test_a_path_is_driven_to_its_end(track: Track, path: tuple[Waypoint, ...]) -> None:
    told = track.walk(*path)
    assert told == [*(Reached("1", index) for index in range(len(path))), Completed("1", "OK")]
    end = path[-1]
    assert hypot(track.place.x - end.x, track.place.y - end.y) < 0.03
    if end.th is not None:
        assert abs(remainder(track.place.th - end.th, tau)) < 0.05
    track.run(1)
    assert track.base.is_at_rest


def test_speeds_and_accelerations_are_kept(track: Track) -> None:
    track.base = DriveControl(BaseSettings(speed=0.6, turn=1.0, acceleration=0.8, braking=1.5, turn_acceleration=4.0))
    track.walk(Waypoint(2, 0), Waypoint(2, 2), Waypoint(-1, 2, 0.0))
    for before, after in zip(track.velocities, track.velocities[1:], strict=False):
        assert after.speed <= 0.6 + 1e-9
        assert abs(after.turn) <= 1.0 + 1e-9
        change = hypot(after.x - before.x, after.y - before.y)
        assert change <= (1.5 if after.speed < before.speed else 0.8) * STEP + 1e-6 or change <= 1.5 * STEP + 1e-6
        assert abs(after.turn - before.turn) <= 4.0 * STEP + 1e-9
    assert track.fastest == pytest.approx(0.6)


def test_a_walk_is_as_fast_as_it_asks(track: Track) -> None:
    track.walk(Waypoint(2, 0), speed=0.25)
    assert track.fastest == pytest.approx(0.25)


def test_a_corner_is_not_cut_by_more_than_a_hand(track: Track) -> None:
    track.walk(Waypoint(2, 0), Waypoint(2, 2))
    corner = min(hypot(at.x - 2, at.y) for at in track.places)
    assert corner < 0.08
    assert max(at.x for at in track.places) < 2.08


def test_a_drive_holds_for_less_than_half_a_second(track: Track) -> None:
    track.place = Place(0, 0, pi / 2)
    track.base.drive(Drive(0.5, 0.0, 0.0), track.now)
    track.run(HOLD - 0.02)
    assert track.place.y > 0.05
    assert not track.base.is_at_rest
    track.run(0.3)
    assert track.base.is_at_rest
    assert abs(track.place.x) < 1e-6


def test_a_drive_goes_sideways_and_turns(track: Track) -> None:
    for _ in range(10):
        track.base.drive(Drive(0.0, 0.4, 1.0), track.now)
        track.run(0.1)
    assert track.velocities[-1].turn == pytest.approx(1.0)
    assert track.velocities[-1].speed == pytest.approx(0.4, abs=0.05)
    assert track.place.y > 0.1


def test_a_drive_is_no_faster_than_the_base(track: Track) -> None:
    for _ in range(20):
        track.base.drive(Drive(5.0, 5.0, 0.0), track.now)
        track.run(0.1)
    assert track.fastest == pytest.approx(0.8)
    for _ in range(20):
        track.base.drive(Drive(0.0, 0.0, 9.0), track.now)
        track.run(0.1)
    assert max(velocity.turn for velocity in track.velocities) == pytest.approx(1.8)


@pytest.mark.parametrize("end", ["halt", "drive", "walk"])
def test_what_comes_after_a_walk_aborts_it(track: Track, end: str) -> None:
    track.base.walk(Walk("1", (Waypoint(5, 0),), 1.0), track.place, track.now)
    track.run(1)
    match end:
        case "halt":
            track.base.end_motion("ABORT")
        case "drive":
            track.base.drive(Drive(0, 0, 0), track.now)
        case "walk":
            track.base.walk(Walk("2", (Waypoint(0, 0),), 1.0), track.place, track.now)
    assert track.base.news == [Completed("1", "ABORT")]


def test_a_halt_brakes_to_a_stand(track: Track) -> None:
    track.base.walk(Walk("1", (Waypoint(5, 0),), 1.0), track.place, track.now)
    track.run(2)
    at = track.place.x
    track.base.end_motion("ABORT")
    track.run(0.4)
    assert track.base.is_at_rest
    assert 0.02 < track.place.x - at < 0.2, "0.8 m/s are braked with 2.5 m/s^2 over 0.13 m"


def test_a_base_that_is_held_fast_is_stuck(track: Track) -> None:
    track.place = Place(0.54, 0.0, 0.0)
    track.is_held = True
    began = track.now
    told = track.walk(Waypoint(1, 0))
    reason = "stuck 0.46 m before the goal: something that the map does not have is in the way"
    assert told == [Completed("1", "ERROR", reason)]
    assert track.now - began == pytest.approx(STUCK, abs=0.1)


def test_a_base_that_cannot_turn_is_stuck(track: Track) -> None:
    track.is_held = True
    assert [type(each) for each in track.walk(Waypoint(0, 0, 2.0))] == [Completed]


def test_a_slow_walk_is_not_stuck(track: Track) -> None:
    assert track.walk(Waypoint(0.6, 0), speed=0.02)[-1] == Completed("1", "OK")


def test_without_room_ahead_it_stands(track: Track) -> None:
    track.base.walk(Walk("1", (Waypoint(5, 0),), 1.0), track.place, track.now)
    track.run(2)
    track.room = 0.05
    track.run(0.1)
    assert track.base.velocity.speed == 0.0
    track.room = inf
    track.run(1)
    assert track.base.velocity.speed > 0.5


@pytest.mark.parametrize("angle", [0.0, 1.0, -2.5])
def test_a_drive_is_in_the_axes_of_the_base(track: Track, angle: float) -> None:
    track.place = Place(0, 0, angle)
    track.base.drive(Drive(0.4, 0.0, 0.0), track.now)
    track.run(0.3)
    length = hypot(track.place.x, track.place.y)
    assert (track.place.x / length, track.place.y / length) == pytest.approx((cos(angle), sin(angle)))


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({"speed": 3.0}, "base.speed must be between 0.05 and 2, not 3"),
        ({"turn": 0.0}, "base.turn must be between 0.1 and 10, not 0"),
        ({"acceleration": float("nan")}, "base.acceleration must be between 0.1 and 10, not nan"),
    ],
)
def test_impossible_bases_are_refused(settings: dict[str, float], why: str) -> None:
    with pytest.raises(ValueError, match=why.replace(".", r"\.")):
        BaseSettings(**settings)
