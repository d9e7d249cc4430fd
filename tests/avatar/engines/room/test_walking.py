from itertools import pairwise
from math import cos, hypot, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_avatar.engines.room.plan import HOME, ROOM
from openrois_avatar.engines.room.walking import FASTEST, HOLD, QUICKEST, RADIUS, Pace, Walker, limits
from openrois_avatar.link.messages import Completed, Drive, Place, Reached, Walk, Waypoint
from openrois_body.messages.motion import Point

FRAME = 1 / 30


def walker(place: Place = HOME) -> Walker:
    return Walker(ROOM, place, 0.0)


def walked(
    figure: Walker, seconds: float, start: float = 0.0, others: tuple[Point, ...] = ()
) -> list[tuple[float, Place]]:
    """Where the figure is in every picture until a time, and when."""
    places = []
    for number in range(round(seconds / FRAME) + 1):
        figure.advance(start + number * FRAME, others)
        places.append((start + number * FRAME, figure.place))
    return places


def walk(*path: Waypoint, speed: float = 1.0, id: str = "a") -> Walk:
    return Walk(id, path, speed)


def test_figure_stands_where_it_begins() -> None:
    figure = walker()
    assert {place for _, place in walked(figure, 1.0)} == {HOME}
    assert (figure.pace, figure.is_walking, figure.news()) == (Pace(), False, [])


def test_walk_goes_straight_to_each_point_and_reports_it() -> None:
    figure = walker()
    figure.walk(walk(Waypoint(0.0, 2.0), Waypoint(1.0, 1.0), Waypoint(0.0, 0.0, -pi / 2)))
    heard: dict[int, Place] = {}
    for number in range(600):
        figure.advance(number * FRAME)
        for event in figure.news():
            if isinstance(event, Reached):
                heard[event.index] = figure.place
            else:
                assert (event, figure.is_walking) == (Completed("a", "OK"), False)
    assert list(heard) == [0, 1, 2]
    # A picture may come a moment after.
    assert hypot(heard[0].x - 0.0, heard[0].y - 2.0) < 0.05
    assert hypot(heard[1].x - 1.0, heard[1].y - 1.0) < 0.05
    assert heard[2] == figure.place == HOME


def test_speed_is_kept_and_changes_softly() -> None:
    figure = walker(Place(0.0, -0.5, pi / 2))
    figure.walk(walk(Waypoint(0.0, 3.0), speed=0.8))
    speeds = []
    for number in range(180):
        figure.advance(number * FRAME)
        speeds.append(figure.pace.ahead)
    assert max(speeds) == pytest.approx(0.8)
    assert sum(speed > 0.79 for speed in speeds) > 80
    # It stands at the end of its way: the last centimetres are slow.
    assert max(abs(later - earlier) for earlier, later in pairwise(speeds)) < 0.15
    assert figure.place == Place(0.0, 3.0, pi / 2)


def test_figure_turns_smoothly_and_faces_along_its_way() -> None:
    figure = walker()
    figure.walk(walk(Waypoint(2.0, 0.0), Waypoint(2.0, 0.8), speed=0.7))
    places = walked(figure, 8.0)
    turns = [abs(later.th - earlier.th) for (_, earlier), (_, later) in pairwise(places)]
    assert max(turns) <= QUICKEST * FRAME * 1.01
    assert next(place.th for _, place in places if place.x > 1.0) == pytest.approx(0.0, abs=0.05)
    assert next(place.th for _, place in places if place.y > 0.6) == pytest.approx(pi / 2, abs=0.2)


def test_figure_turns_before_it_goes() -> None:
    figure = walker()
    figure.walk(walk(Waypoint(0.0, 2.0)))
    figure.advance(0.3)
    assert figure.place.y < 0.02
    assert abs(figure.pace.turn) > 0.5


def test_a_point_with_a_direction_is_reached_facing_there() -> None:
    figure = walker()
    figure.walk(walk(Waypoint(1.0, 0.0, pi / 2), Waypoint(-1.0, 0.0, 0.0)))
    facing = {}
    for number in range(600):
        figure.advance(number * FRAME)
        facing.update({event.index: figure.place.th for event in figure.news() if isinstance(event, Reached)})
    assert facing[0] == pytest.approx(pi / 2, abs=0.2)
    assert facing[1] == 0.0


def test_a_point_where_it_stands_is_a_turn_on_the_spot() -> None:
    figure = walker()
    figure.walk(walk(Waypoint(0.0, 0.0, 0.0)))
    places = walked(figure, 2.0)
    assert {(place.x, place.y) for _, place in places} == {(0.0, 0.0)}
    assert figure.place.th == 0.0
    assert figure.news() == [Reached("a", 0), Completed("a", "OK")]
    figure.walk(walk(Waypoint(0.0, 0.0)))
    figure.advance(2.1)
    assert figure.news() == [Reached("a", 0), Completed("a", "OK")]


def test_a_step_aside_is_taken_without_turning_away() -> None:
    figure = walker()
    figure.walk(walk(Waypoint(0.4, 0.0, -pi / 2)))
    places = walked(figure, 3.0)
    assert {place.th for _, place in places} == {-pi / 2}
    assert figure.place == Place(0.4, 0.0, -pi / 2)


def test_points_with_a_direction_that_it_faces_already_are_passed_without_a_stop() -> None:
    figure = walker(Place(0.0, 0.0, 0.0))
    figure.walk(walk(*(Waypoint(-0.2 * step, 0.0, 0.0) for step in range(1, 6))))
    speeds = []
    for number in range(200):
        figure.advance(number * FRAME)
        if 0.1 < -figure.place.x < 0.9:
            speeds.append(figure.pace.ahead)
    assert figure.place == Place(-1.0, 0.0, 0.0)
    assert [event.index for event in figure.news() if isinstance(event, Reached)] == [0, 1, 2, 3, 4]
    # Backwards, in small steps, and in one go.
    assert min(speeds) > -0.51
    assert max(speeds) < -0.4


def test_where_it_does_not_face_yet_it_turns_before_it_goes_on() -> None:
    figure = walker(Place(0.0, 0.0, 0.0))
    figure.walk(walk(Waypoint(0.3, 0.0, -pi / 2), Waypoint(1.0, 0.0), speed=2.0))
    facing = []
    for number in range(300):
        figure.advance(number * FRAME)
        facing += [figure.place.th for event in figure.news() if event == Reached("a", 0)]
    assert facing == [pytest.approx(-pi / 2, abs=0.3)]
    assert figure.place.x == 1.0


def test_a_curve_of_many_points_is_one_movement() -> None:
    figure = walker(Place(1.0, 0.0, pi / 2))
    points = [Waypoint(cos(turn / 300 * pi), sin(turn / 300 * pi)) for turn in range(1, 301)]
    figure.walk(walk(*points, speed=0.9))
    speeds, seconds = [], 0
    while figure.is_walking and seconds < 300:
        seconds += 1
        figure.advance(seconds * FRAME)
        speeds.append(hypot(figure.pace.ahead, figure.pace.left))
    assert len(figure.news()) == 301
    assert sum(speed > 0.75 for speed in speeds) > 0.6 * len(speeds)
    # 3.14 m
    assert seconds * FRAME < 5.0


def test_corners_are_taken_slowly() -> None:
    sharp = limits((0.0, 0.0), walk(Waypoint(1.0, 0.0), Waypoint(0.0, 0.1), Waypoint(5.0, 0.1)))
    assert sharp == [0.0, 0.0, 0.0]
    wide = limits((0.0, 0.0), walk(Waypoint(1.0, 0.0), Waypoint(3.0, 0.5), Waypoint(5.0, 0.5)))
    assert 0.8 < wide[0] < 1.0
    facing = limits((0.0, 0.0), walk(Waypoint(1.0, 0.0, 0.05), Waypoint(2.0, 0.0, pi), Waypoint(9.0, 0.0)))
    assert facing == [1.0, 0.5, 0.0]
    close = limits((0.0, 0.0), walk(Waypoint(1.0, 0.0), Waypoint(1.02, 0.0)))
    assert 0.1 < close[0] < 0.4
    assert limits((0.0, 0.0), walk(Waypoint(0.0, 0.0), Waypoint(5.0, 0.0)))[0] == 1.0


def test_no_order_makes_it_faster_than_it_can_be() -> None:
    figure = walker(Place(-2.5, -0.5, 0.0))
    figure.walk(walk(Waypoint(2.5, -0.5), speed=10.0))
    places = walked(figure, 4.0)
    assert max(later.x - earlier.x for (_, earlier), (_, later) in pairwise(places)) <= FASTEST * FRAME * 1.01
    assert figure.place.x == 2.5


def test_another_walk_takes_the_place_of_the_first_without_a_stop() -> None:
    figure = walker(Place(0.0, -0.5, pi / 2))
    figure.walk(walk(Waypoint(0.0, 3.0)))
    walked(figure, 1.5)
    figure.walk(walk(Waypoint(0.0, 2.0), id="b"))
    assert figure.news() == [Completed("a", "ABORT")]
    figure.advance(1.6)
    assert figure.pace.ahead > 0.9
    walked(figure, 3.0, 1.6)
    assert figure.news() == [Reached("b", 0), Completed("b", "OK")]


def test_halt_is_now() -> None:
    figure = walker(Place(0.0, -0.5, pi / 2))
    figure.walk(walk(Waypoint(0.0, 3.0)))
    walked(figure, 1.5)
    here = figure.place
    figure.halt()
    walked(figure, 1.0, 1.5)
    assert (figure.place, figure.pace, figure.news()) == (here, Pace(), [Completed("a", "ABORT")])
    figure.halt()
    assert figure.news() == []


def test_a_way_through_furniture_is_not_possible() -> None:
    figure = walker()
    figure.walk(walk(Waypoint(1.6, 0.0), Waypoint(1.6, 3.5)))
    walked(figure, 6.0)
    assert figure.news() == [Reached("a", 0), Completed("a", "ERROR")]
    assert 1.5 < figure.place.y < 1.85
    assert figure.pace == Pace()


def test_walk_waits_for_a_figure_in_the_way() -> None:
    figure = walker(Place(0.0, -0.5, pi / 2))
    figure.walk(walk(Waypoint(0.0, 2.0)))
    walked(figure, 4.0, others=((0.0, 1.0),))
    assert figure.place.y == pytest.approx(0.45, abs=0.05)
    assert figure.is_walking
    # A figure behind is not in the way.
    walked(figure, 4.0, 4.0, others=((0.0, -0.1),))
    assert figure.place.y == 2.0


def test_a_drive_stops_by_itself_within_half_a_second() -> None:
    figure = walker()
    figure.drive(0.0, Drive(0.5, 0.2, 0.8))
    places = walked(figure, 2.0)
    moving = [time for (_, earlier), (time, later) in pairwise(places) if earlier != later]
    assert 0.4 < moving[-1] <= 0.5
    assert HOLD < 0.5
    assert figure.pace == Pace()
    # It goes to where it faces: towards the viewer, and to its left, which is the picture's right.
    assert figure.place.y < -0.1
    assert figure.place.x > 0.03
    assert figure.place.th > -pi / 2


def test_repeated_drive_goes_on() -> None:
    figure = walker(Place(0.0, -0.5, pi / 2))
    for number in range(20):
        figure.drive(number / 10, Drive(1.0, 0.0, 0.0))
        figure.advance((number + 1) / 10)
    assert figure.place.y == pytest.approx(-0.5 + 2.0 - 1.0 / 6 / 2, abs=0.03)
    assert figure.pace.ahead == pytest.approx(1.0)


def test_a_drive_ends_a_walk_and_a_walk_a_drive() -> None:
    figure = walker()
    figure.walk(walk(Waypoint(0.0, 2.0)))
    figure.drive(0.0, Drive(0.0, 0.0, 0.0))
    assert figure.news() == [Completed("a", "ABORT")]
    figure.drive(0.1, Drive(1.0, 0.0, 0.0))
    figure.walk(walk(Waypoint(0.0, 0.0, -pi / 2), id="b"))
    walked(figure, 1.0, 0.1)
    assert figure.place == HOME


def test_driven_figure_slides_along_a_wall_and_stands_in_a_corner() -> None:
    figure = walker(Place(2.0, -0.5, -pi / 4))
    for number in range(60):
        figure.drive(number / 10, Drive(1.0, 0.0, 0.0))
        figure.advance((number + 1) / 10)
    assert figure.place.x == pytest.approx(3.0 - RADIUS, abs=0.03)
    assert figure.place.y == pytest.approx(-1.0 + RADIUS, abs=0.03)


def test_driven_figure_stops_before_another_one() -> None:
    figure = walker()
    for number in range(10):
        figure.drive(number / 10, Drive(1.0, 0.0, 0.0))
        figure.advance((number + 1) / 10, ((0.0, -0.7),))
    assert figure.place.y > -0.2


def test_a_long_absence_is_not_made_up_for() -> None:
    figure = walker(Place(0.0, -0.5, pi / 2))
    figure.walk(walk(Waypoint(0.0, 3.0), speed=0.5))
    figure.advance(3600.0)
    assert 0 < figure.place.y + 0.5 < 0.5
    walked(figure, 8.0, 3600.0)
    assert figure.place.y == 3.0


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.one_of(
            st.builds(
                lambda x, y, th, speed: walk(Waypoint(x, y, th), speed=speed),
                st.floats(-4, 4),
                st.floats(-2, 5),
                st.none() | st.floats(-2 * pi, 2 * pi),
                st.floats(0.01, 10),
            ),
            st.builds(Drive, st.floats(-10, 10), st.floats(-10, 10), st.floats(-10, 10)),
        ),
        max_size=6,
    )
)
def test_nothing_takes_it_out_of_the_floor_or_into_furniture(orders: list[Walk | Drive]) -> None:
    figure, time = walker(), 0.0
    walks = 0
    for order in orders:
        if isinstance(order, Drive):
            figure.drive(time, order)
        else:
            figure.walk(order)
            walks += 1
        for _ in range(20):
            time += FRAME
            figure.advance(time)
            assert ROOM.fits(figure.place.x, figure.place.y, 0.11)
            assert abs(figure.place.th) <= pi
            assert Place.from_json(figure.place.to_json())
    figure.halt()
    assert sum(isinstance(event, Completed) for event in figure.news()) == walks
