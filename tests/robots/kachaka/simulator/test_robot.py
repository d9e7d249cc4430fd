"""The simulated robot on a clock that is moved by hand."""

from math import hypot, pi

import pytest
from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_robots.kachaka.simulator.errors import ErrorCode, error_code_json
from openrois_robots.kachaka.simulator.house import HOUSE, Pose
from openrois_robots.kachaka.simulator.robot import RobotSettings, SimulatedKachaka
from openrois_robots.kachaka.simulator.view import SIZE, draw, encode, persons_in_view


def robot(**settings: object) -> SimulatedKachaka:
    made = SimulatedKachaka(RobotSettings(**settings))  # type: ignore[arg-type]
    made.advance(100.0)
    return made


def to(x: float, y: float, yaw: float = 0.0) -> pb2.Command:
    return pb2.Command(move_to_pose_command=pb2.MoveToPoseCommand(x=x, y=y, yaw=yaw))


def forward(metres: float, speed: float = 0.0) -> pb2.Command:
    return pb2.Command(move_forward_command=pb2.MoveForwardCommand(distance_meter=metres, speed=speed))


SPEAK = pb2.Command(speak_command=pb2.SpeakCommand(text="x" * 50))
HOME = pb2.Command(return_home_command=pb2.ReturnHomeCommand())


def run(robot: SimulatedKachaka, seconds: float) -> None:
    robot.advance(robot.now + seconds)


def outcome(robot: SimulatedKachaka, command: pb2.Command, seconds: float = 200.0) -> ErrorCode:
    error, command_id = robot.start(command, cancel_all=False)
    assert error is ErrorCode.NONE
    run(robot, seconds)
    assert robot.last is not None
    assert robot.last.id == command_id
    return robot.last.error


def test_it_goes_as_far_as_time_has_passed() -> None:
    made = robot()
    made.start(forward(1.5), cancel_all=False)
    run(made, 2.0)
    assert made.body.pose.x == pytest.approx(0.6)
    run(made, 10.0)
    assert made.body.pose.x == pytest.approx(1.5)


def test_it_goes_slower_and_back() -> None:
    made = robot()
    made.start(forward(-0.2, 0.1), cancel_all=False)
    run(made, 1.0)
    assert made.body.pose.x == pytest.approx(-0.1)


def test_it_finds_its_way_round_what_stands_there() -> None:
    made = robot()
    made.start(to(4.5, 0.0, pi / 2), cancel_all=False)
    nearest = 1000.0
    for _ in range(400):
        run(made, 0.1)
        nearest = min(nearest, hypot(made.body.pose.x - 3.6, made.body.pose.y))
    assert (made.body.pose.x, made.body.pose.y) == (pytest.approx(4.5), pytest.approx(0.0))
    assert made.body.pose.th == pytest.approx(pi / 2)
    assert nearest > 0.6, "the table is there"


@pytest.mark.parametrize("goal", [to(3.6, 0.0), to(50.0, 0.0)])
def test_there_is_no_way_into_furniture_and_out_of_the_house(goal: pb2.Command) -> None:
    assert outcome(robot(), goal) is ErrorCode.NO_WAY


def test_what_is_in_the_way_blocks_it() -> None:
    made = robot()
    assert outcome(made, forward(3.5)) is ErrorCode.BLOCKED
    assert 2.9 < made.body.pose.x <= 3.0


@pytest.mark.parametrize(
    ("command", "error"),
    [
        (pb2.Command(), ErrorCode.UNSUPPORTED),
        (pb2.Command(dock_shelf_command=pb2.DockShelfCommand()), ErrorCode.NO_SHELF),
        (pb2.Command(undock_shelf_command=pb2.UndockShelfCommand()), ErrorCode.NO_SHELF),
        (pb2.Command(return_shelf_command=pb2.ReturnShelfCommand()), ErrorCode.NO_SHELF),
        (
            pb2.Command(move_shelf_command=pb2.MoveShelfCommand(target_shelf_id="S9", destination_location_id="L01")),
            ErrorCode.UNKNOWN_TARGET,
        ),
        (pb2.Command(lock_command=pb2.LockCommand(duration_sec=1)), ErrorCode.NONE),
        (pb2.Command(localize_command=pb2.LocalizeCommand()), ErrorCode.NONE),
    ],
)
def test_what_cannot_be_done_is_told(command: pb2.Command, error: ErrorCode) -> None:
    assert outcome(robot(), command) is error


def test_it_takes_the_shelf_before_it_and_sets_it_down() -> None:
    made = robot()
    assert outcome(made, to(1.2, 1.5, pi / 2)) is ErrorCode.NONE
    assert outcome(made, pb2.Command(dock_shelf_command=pb2.DockShelfCommand())) is ErrorCode.NONE
    assert made.premises.carried == "S01"
    assert outcome(made, pb2.Command(undock_shelf_command=pb2.UndockShelfCommand())) is ErrorCode.NONE
    assert made.premises.carried == ""
    assert made.premises.shelf_poses["S01"].y == pytest.approx(1.5)
    assert outcome(made, pb2.Command(return_shelf_command=pb2.ReturnShelfCommand(target_shelf_id="S01"))) is (
        ErrorCode.NONE
    )
    assert made.premises.shelf_poses["S01"].y == pytest.approx(1.8)


def test_commands_wait_for_each_other_and_cancel_all_ends_them() -> None:
    made = robot()
    made.start(forward(1.0), cancel_all=False)
    made.start(SPEAK, cancel_all=False)
    run(made, 1.0)
    assert [job.has_begun for job in made.jobs] == [True, False]
    made.start(HOME, cancel_all=True)
    assert [each.error for each in made.history] == [ErrorCode.CANCELLED] * 2
    assert [job.command for job in made.jobs] == [HOME]


def test_it_speaks_beside_a_motion_where_it_is_set_to() -> None:
    made = robot(speaks_while_driving=True)
    made.start(forward(2.0), cancel_all=False)
    made.start(SPEAK, cancel_all=False)
    run(made, 4.0)
    assert made.last is not None
    assert made.last.command == SPEAK
    assert made.jobs[0].command == forward(2.0), "which goes on"


def test_a_velocity_holds_for_half_a_second() -> None:
    made = robot()
    assert made.set_velocity(1.0, 0.0) is ErrorCode.MANUAL_CONTROL_OFF
    assert made.set_manual(True) is ErrorCode.NONE
    assert made.set_velocity(1.0, 0.0) is ErrorCode.NONE
    run(made, 5.0)
    assert made.body.pose.x == pytest.approx(0.15, abs=0.02)
    assert not made.stops
    made.set_velocity(0.0, 0.0)
    assert made.stops == pytest.approx([made.now])


def test_manual_control_ends_by_itself_and_excludes_commands() -> None:
    made = robot()
    made.set_manual(True)
    assert made.start(HOME, cancel_all=False)[0] is ErrorCode.MANUAL_CONTROL_ON
    run(made, 10.1)
    assert made.start(HOME, cancel_all=False)[0] is ErrorCode.NONE
    assert made.set_manual(True) is ErrorCode.COMMAND_RUNS


def test_an_emergency_stop_ends_everything_until_it_is_released() -> None:
    made = robot()
    made.start(forward(1.0), cancel_all=False)
    made.stop_in_emergency()
    assert not made.jobs
    assert made.start(HOME, cancel_all=False)[0] is ErrorCode.EMERGENCY_STOP
    assert made.set_manual(True) is ErrorCode.EMERGENCY_STOP
    made.release()
    assert made.start(HOME, cancel_all=False)[0] is ErrorCode.NONE


def test_the_battery_is_used_and_charged() -> None:
    made = robot(battery=50.0)
    outcome(made, forward(1.0))
    assert made.battery < 50.0
    assert outcome(made, HOME) is ErrorCode.NONE
    before = made.battery
    run(made, 100.0)
    assert made.battery == pytest.approx(before + 10.0)


def test_with_an_empty_battery_only_the_charger_is_left() -> None:
    made = robot(battery=0.5)
    assert made.start(forward(1.0), cancel_all=False)[0] is ErrorCode.EMPTY_BATTERY
    assert made.start(HOME, cancel_all=False)[0] is ErrorCode.NONE


def test_cursors_are_of_one_clock() -> None:
    made = robot()
    made.start(forward(0.1), cancel_all=False)
    began = made.topics.cursor("state")
    run(made, 5.0)
    assert made.topics.is_news("result", began), "as the vendor's client asks"
    assert not made.topics.is_news("result", made.topics.cursor("result"))
    assert made.topics.is_news("result", 0)


def test_pictures_change_with_the_place_and_with_their_number() -> None:
    pictures = [
        draw(HOUSE, Pose(0, 0), 1, "front"),
        draw(HOUSE, Pose(0, 0), 2, "front"),
        draw(HOUSE, Pose(1, 0), 1, "f"),
    ]
    assert all(each.shape == (SIZE[1], SIZE[0], 3) for each in pictures)
    assert (pictures[0] != pictures[1]).any()
    assert (pictures[0] != pictures[2]).any()
    assert encode(pictures[0]).startswith(b"\xff\xd8")


def test_persons_are_seen_where_they_stand() -> None:
    (near,) = persons_in_view(HOUSE, Pose(0.0, 0.0))
    assert near.distance == pytest.approx(hypot(2.4, 0.2))
    assert near.left + near.width / 2 < SIZE[0] / 2, "to the left"
    assert persons_in_view(HOUSE, Pose(0.0, 0.0, pi)) == ()


def test_every_error_has_a_text() -> None:
    told = error_code_json()
    assert all(f'"code": {int(code)},' in told for code in ErrorCode if code is not ErrorCode.NONE)


def test_the_map_shows_walls_and_furniture_where_they_stand() -> None:
    grid = HOUSE.grid()
    assert grid.shape == (100, 140)
    assert not grid[[0, -1], :].any()
    assert not grid[:, [0, -1]].any()
    row, column = round((2.5 - 0.0) / 0.05), round((3.6 + 0.5) / 0.05)
    assert grid[row, column] == 0, "the table"
    assert grid[row, column - 40] == 255


def test_the_map_begins_at_the_corner_of_the_house_and_covers_it() -> None:
    height, width = HOUSE.grid().shape
    assert (HOUSE.origin.x, HOUSE.origin.y) == (HOUSE.outline.left, HOUSE.outline.bottom)
    assert HOUSE.origin.x + width * HOUSE.resolution == pytest.approx(HOUSE.outline.right)
    assert HOUSE.origin.y + height * HOUSE.resolution == pytest.approx(HOUSE.outline.top)
