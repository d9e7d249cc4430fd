from itertools import pairwise
from math import dist, pi

import numpy as np
import pytest
from openrois_avatar.engines.room.life import Life
from openrois_avatar.engines.room.plan import HOME, ROOM
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.room.visitor import PLACES
from openrois_avatar.engines.room.walking import APART, turned
from openrois_avatar.link.messages import Completed, Drive, Event, Floor, Halt, Place, Reached, Things, Walk, Waypoint

FRAME = 1 / 30


def lived(
    life: Life, seconds: float, start: float = 0.0, rate: float = 30.0, expressive: bool = False
) -> tuple[list[Scene], list[tuple[float, Event]]]:
    scenes, told = [], []
    for number in range(round(seconds * rate) + 1):
        time = start + number / rate
        scenes.append(life.advance(time, expressive))
        told += [(time, event) for event in life.news()]
    return scenes, told


def test_figure_begins_at_home_and_reports_the_scene() -> None:
    scenes, told = lived(Life(0.0), 1.0)
    assert [type(event) for _, event in told] == [Floor, Things, Place]
    floor, things, place = (event for _, event in told)
    assert (floor, place) == (ROOM.floor, HOME)
    assert things == Things(ROOM.things)
    assert scenes[-1].visitor is None
    assert (scenes[0].place, scenes[0].shot) == (AT_HOME.place, AT_HOME.shot)


def test_places_and_things_are_told_while_they_change_and_not_too_often() -> None:
    for rate in (30.0, 120.0):
        life = Life(0.0, visited=True)
        life.obey(0.0, Walk("a", (Waypoint(0.0, 3.0), Waypoint(0.0, 0.0)), 0.6))
        scenes, told = lived(life, 20.0, rate=rate)
        for kind, most in ((Place, 20), (Things, 10)):
            times = [time for time, event in told if isinstance(event, kind)]
            for time in times:
                assert sum(time <= other < time + 1 for other in times) <= most + 1
            assert len(times) > 60
        assert [event for _, event in told if isinstance(event, Place)][-1] == scenes[-1].place


def test_the_last_place_comes_before_the_end_of_a_walk() -> None:
    life = Life(0.0)
    life.obey(0.0, Walk("a", (Waypoint(0.0, 1.0, pi / 2),), 1.0))
    _, told = lived(life, 5.0)
    events = [event for _, event in told if not isinstance(event, Things)]
    assert events[-3:] == [Place(0.0, 1.0, pi / 2), Reached("a", 0), Completed("a", "OK")]


def test_the_radio_is_heard_from_nearby() -> None:
    life = Life(0.0)
    assert life.radio == 0.0
    life.obey(0.0, Walk("a", (Waypoint(1.2, 1.5),), 1.0))
    lived(life, 3.0)
    near = life.radio
    assert 0.3 < near < 1.0
    life.obey(3.0, Walk("b", (Waypoint(1.9, 1.65),), 1.0))
    lived(life, 4.0, 3.0)
    assert near < life.radio <= 1.0


def test_steps_are_seen_while_it_walks() -> None:
    life = Life(0.0)
    assert life.walking == {}
    life.obey(0.0, Drive(0.5, 0.0, 0.0))
    lived(life, 0.4)
    assert life.walking["left_leg.knee"] > 0
    life.obey(0.4, Halt())
    scenes, _ = lived(life, 1.0, 0.4)
    assert life.walking == {}
    assert scenes[0].place == scenes[-1].place != HOME


def test_the_visitor_is_in_the_scene_where_things_say() -> None:
    life = Life(0.0, seed=4, visited=True)
    for scene, (_, event) in zip(*lived(life, 20.0), strict=False):
        assert scene.visitor is not None
        if isinstance(event, Things):
            assert event.things[:-1] == ROOM.things
            assert event.things[-1].kind == "person"
            assert ROOM.fits(scene.visitor.place.x, scene.visitor.place.y, 0.2)
    scenes, _ = lived(life, 30.0, 20.0)
    assert any(scene.visitor is not None and scene.visitor.steps for scene in scenes)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 6))])
def test_visitor_and_figure_never_walk_through_each_other(seed: int) -> None:
    random, life, time = np.random.default_rng(seed), Life(0.0, seed, visited=True), 0.0
    near = 0
    for _ in range(60):
        visitor = life.advance(time, False).visitor
        assert visitor is not None
        there, elsewhere = visitor.place, PLACES[int(random.integers(len(PLACES)))]
        commands = (
            Walk("to the visitor", (Waypoint(there.x, there.y),), 2.5),
            Walk("to where it will be", (Waypoint(elsewhere.x, elsewhere.y),), 2.0),
            Drive(2.5, 0.0, random.uniform(-3.0, 3.0)),
        )
        life.obey(time, commands[random.integers(3)])
        scenes, _ = lived(life, 3.0, time, rate=random.choice((1.0, 10.0, 30.0)))
        time += 3.0
        for scene in scenes:
            assert scene.visitor is not None
            apart = dist((scene.place.x, scene.place.y), (scene.visitor.place.x, scene.visitor.place.y))
            assert apart > APART - 0.05
            near += apart < APART + 0.1
    assert near > 10


AWAY = Waypoint(0.5, 1.0, pi / 2)
"""With its back to the viewer."""


def away() -> tuple[Life, float]:
    """A figure that has walked and stands with its back to the viewer, and when that is."""
    life = Life(0.0)
    life.obey(0.0, Walk("a", (AWAY,), 1.0))
    scenes, _ = lived(life, 5.0)
    assert scenes[-1].place == Place(AWAY.x, AWAY.y, pi / 2)
    return life, 5.0


def test_figure_turns_to_the_viewer_when_it_begins_to_speak() -> None:
    life, now = away()
    scenes, told = lived(life, 8.0, now, expressive=True)
    assert scenes[-1].place == Place(AWAY.x, AWAY.y, HOME.th)
    assert [event for _, event in told if isinstance(event, Place)][-1] == scenes[-1].place
    turns = [abs(turned(b.place.th - a.place.th)) for a, b in pairwise(scenes)]
    assert max(turns) < 0.15  # it turns, it does not jump
    assert scenes[-1].shot.is_close


def test_figure_does_not_turn_when_it_nearly_faces_the_viewer() -> None:
    life = Life(0.0)
    life.obey(0.0, Walk("a", (Waypoint(0.0, 0.0, HOME.th + 0.3),), 1.0))
    place = lived(life, 2.0)[0][-1].place
    assert lived(life, 3.0, 2.0, expressive=True)[0][-1].place == place != HOME


def test_walking_figure_that_speaks_turns_when_it_has_arrived() -> None:
    life = Life(0.0)
    life.obey(0.0, Walk("a", (Waypoint(0.0, 1.0),), 1.0))
    scenes, _ = lived(life, 6.0, expressive=True)
    assert scenes[60].place.th == pytest.approx(pi / 2, abs=0.2)
    assert scenes[-1].place == Place(0.0, 1.0, HOME.th)


@pytest.mark.parametrize(
    "command",
    [
        Halt(),
        Drive(0.0, 0.0, 0.0),
        Walk("b", (Waypoint(AWAY.x, AWAY.y, 0.0),), 1.0),
    ],
    ids=["halted", "driven", "sent where it faces elsewhere"],
)
def test_command_comes_before_turning(command: Halt | Drive | Walk) -> None:
    life, now = away()
    lived(life, 0.3, now, expressive=True)
    life.obey(now + 0.3, command)
    first = lived(life, 2.0, now + 0.3, expressive=True)[0][-1].place
    later = lived(life, 2.0, now + 2.3, expressive=True)[0][-1].place
    assert first == later
    assert abs(turned(later.th - HOME.th)) > 1.0


def test_figure_with_a_lost_driver_stands_although_it_speaks() -> None:
    life, now = away()
    life.obey(now, Drive(0.1, 0.0, 0.0))
    lived(life, 0.2, now)
    stood = lived(life, 1.0, now + 0.2, expressive=True)[0][-1].place
    assert stood.th == pi / 2
    assert lived(life, 2.0, now + 1.2, expressive=True)[0][-1].place == stood


def test_interrupted_speech_ends_the_turn() -> None:
    life, now = away()
    lived(life, 0.3, now, expressive=True)
    life.stay()
    scenes, _ = lived(life, 2.0, now + 0.3, expressive=True)
    assert scenes[0].place == scenes[-1].place
    assert 1.0 < abs(turned(scenes[-1].place.th - HOME.th)) < pi


def test_interrupted_speech_does_not_stop_a_walk_nor_turn_the_figure_at_its_end() -> None:
    life = Life(0.0)
    life.obey(0.0, Walk("a", (Waypoint(0.0, 1.0),), 1.0))
    lived(life, 0.5, expressive=True)
    life.stay()
    scenes, _ = lived(life, 6.0, 0.5, expressive=True)
    place = scenes[-1].place
    assert (place.x, place.y) == (0.0, 1.0)
    assert place.th == pytest.approx(pi / 2, abs=0.2)


def test_the_room_is_shown_from_a_viewpoint_that_there_is() -> None:
    life = Life(0.0)
    scenes, _ = lived(life, 1.0)
    assert scenes[-1].shot.is_close
    life.show_from("room")
    shot = lived(life, 6.0, 1.0)[0][-1].shot
    assert not shot.is_close
    life.show_from("moon")
    assert lived(life, 3.0, 7.0)[0][-1].shot == shot


def test_halted_figure_turns_with_its_next_sentence() -> None:
    life, now = away()
    lived(life, 0.3, now, expressive=True)
    life.obey(now + 0.3, Halt())
    lived(life, 1.0, now + 0.3, expressive=True)
    lived(life, 1.0, now + 1.3)
    assert lived(life, 3.0, now + 2.3, expressive=True)[0][-1].place.th == HOME.th
