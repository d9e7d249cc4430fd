from collections.abc import Callable
from itertools import pairwise
from math import pi
from pathlib import Path

import cv2
import numpy as np
import pytest
from openrois_avatar.engines import size_choice
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.animation.reactions import REACTIONS
from openrois_avatar.engines.room.plan import ROOM
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.room.shot import VIEWPOINTS
from openrois_avatar.engines.runner import AHEAD, LINK_LOST, UNAVAILABLE, Runner, i420, main, still_pose
from openrois_avatar.engines.settings import Picture, Pixels
from openrois_avatar.engines.sound import Samples
from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE
from openrois_avatar.link.messages import (
    Command,
    Completed,
    Demand,
    Drive,
    Event,
    Floor,
    Halt,
    Idle,
    Log,
    Look,
    Place,
    Quit,
    Reached,
    React,
    Silence,
    Speak,
    Stop,
    Things,
    Viewpoint,
    Viseme,
    Walk,
    Waypoint,
)
from openrois_avatar.link.protocol import PixelFormat

from tests.support.hearing import stereo_48k, voice

SIZE = Picture(32, 16, 30)


class Clock:
    def __init__(self) -> None:
        self.time = 100.0

    def __call__(self) -> float:
        return self.time


class Drawing:
    """Remembers the poses it was asked for; each takes `seconds` on the clock."""

    def __init__(self, clock: Clock, seconds: float = 0.004) -> None:
        self.clock, self.seconds = clock, seconds
        self.poses: list[Pose] = []
        self.scenes: list[Scene] = []
        self.sizes: list[Picture] = []

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        self.poses.append(pose)
        self.scenes.append(scene)
        self.clock.time += self.seconds
        return np.full((SIZE.height, SIZE.width, 4), 128, np.uint8)

    def resize(self, picture: Picture) -> None:
        self.sizes.append(picture)


class Link:
    """An adapter that says each command at its time and ends the link at `end`; waiting moves the clock."""

    def __init__(self, clock: Clock, end: float, script: dict[float, Command] | None = None) -> None:
        self.clock, self.end = clock, clock.time + end
        self.script = {clock.time + time: command for time, command in (script or {}).items()}
        self.pictures: list[tuple[int, memoryview, PixelFormat]] = []
        self.blocks: list[tuple[int, Samples]] = []
        self.left: list[int] = []
        """When each block left, in nanoseconds."""
        self.told: list[tuple[float, Event]] = []
        self.voice: dict[float, Samples] = {}
        """What the operator says, by the time at which it arrives."""

    @property
    def connected(self) -> bool:
        return self.clock.time < self.end

    def poll_commands(self, timeout: float = 0.0) -> list[Command]:
        assert timeout >= 0.0
        due = self.clock.time + timeout
        said = sorted(time for time in self.script if time <= due)
        self.clock.time = max(said[0], self.clock.time) if said else due
        return [self.script.pop(said[0])] if said else []

    def poll_audio(self) -> list[Samples]:
        due = [time for time in self.voice if time <= self.clock.time]
        return [self.voice.pop(time) for time in sorted(due)]

    def draw_video(
        self, draw: Callable[[Pixels], None], width: int, height: int, format: PixelFormat, timestamp_ns: int
    ) -> None:
        assert (width, height) == (SIZE.width, SIZE.height)
        assert timestamp_ns <= self.clock.time * 1e9
        pixels = np.empty(width * height * 3 // 2, np.uint8)
        draw(pixels)
        self.pictures.append((timestamp_ns, pixels.data, format))

    def send_audio(self, samples: Samples, timestamp_ns: int) -> None:
        self.blocks.append((timestamp_ns, samples))
        self.left.append(round(self.clock.time * 1e9))

    def send_event(self, event: Event) -> None:
        self.told.append((self.clock.time - 100.0, event))

    @property
    def events(self) -> list[tuple[float, Event]]:
        """The events it sent, without those about the room."""
        return [(time, event) for time, event in self.told if not isinstance(event, Place | Floor | Things)]


def played(end: float, script: dict[float, Command] | None = None, seconds: float = 0.004) -> tuple[Link, Drawing]:
    clock = Clock()
    link, drawing = Link(clock, end, script), Drawing(clock, seconds)
    Runner(link, drawing, SIZE, clock).run()
    return link, drawing


def test_pictures_and_sound_leave_at_their_deadlines() -> None:
    link, _ = played(2.0)
    times = [stamp - 100_000_000_000 for stamp, _, _ in link.pictures]
    assert times == [round(number * 1e9 / 30) for number in range(60)]
    # Sound leaves ahead of its time.
    assert [stamp - 100_000_000_000 for stamp, _ in link.blocks] == [number * 20_000_000 for number in range(103)]


@pytest.mark.parametrize("seconds", [0.004, 0.03, 0.05])
def test_sound_is_there_before_its_time_while_pictures_are_drawn(seconds: float) -> None:
    link, _ = played(2.0, seconds=seconds)
    steps = [later - earlier for (earlier, _), (later, _) in pairwise(link.blocks)]
    assert set(steps) == {20_000_000}
    ahead = [stamp - left for (stamp, _), left in zip(link.blocks, link.left, strict=True)]
    # The first three leave together.
    assert min(ahead[3:]) >= (AHEAD - seconds) * 1e9 - 1000
    assert max(ahead) <= AHEAD * 1e9 + 1000


def test_nothing_is_drawn_while_no_pictures_are_wanted() -> None:
    link, drawing = played(4.0, {0.5: Demand(0), 2.51: Demand(1)})
    times = [stamp / 1e9 - 100 for stamp, _, _ in link.pictures]
    asleep = [time for time in times if 0.55 < time < 2.5]
    assert asleep == []
    assert len(drawing.poses) == len(times)
    unheard = [stamp for stamp, _ in link.blocks if 100.6e9 < stamp < 102.5e9]
    assert unheard == [], "silence need not be sent"
    assert {round((stamp - 100e9) / 1e6) % 20 for stamp, _ in link.blocks} == {0}, "and moves nothing"
    woken = [time for time in times if time > 2.5]
    assert woken[0] == pytest.approx(2.51, abs=0.002), "the first picture does not wait for its turn, and is new"
    assert [time - woken[0] for time in woken] == pytest.approx([number / 30 for number in range(len(woken))], abs=1e-6)
    signs = [time for time, event in link.events if isinstance(event, Idle)]
    assert [later - earlier < 0.6 for earlier, later in pairwise([0.5, *signs, 2.51])] == [True] * (len(signs) + 1)
    assert not any(isinstance(event, Log) for _, event in link.events)


def test_sleeping_engine_obeys_commands() -> None:
    walk = Walk("b", (Waypoint(0.3, 0.0),), 0.5)
    link, drawing = played(8.0, {0.0: Demand(0), 0.5: React("a", "wave"), 1.0: walk})
    assert len(drawing.poses) <= 1
    done = [event for _, event in link.told if isinstance(event, Completed)]
    assert done == [Completed("b", "OK"), Completed("a", "OK")] or done == [Completed("a", "OK"), Completed("b", "OK")]
    assert [event for _, event in link.told if isinstance(event, Place)][-1].x == pytest.approx(0.3, abs=0.01)
    cue = [stamp / 1e9 - 100 for stamp, samples in link.blocks if samples.any()]
    assert max(int(np.abs(samples).max()) for _, samples in link.blocks) > 1000
    assert 0.5 <= cue[0] <= 0.62, "it is heard no later than it is seen"
    assert [later - earlier for earlier, later in pairwise(cue)] == pytest.approx([0.02] * (len(cue) - 1), abs=1e-6)


def test_a_reaction_is_seen_when_it_is_heard() -> None:
    link, drawing = played(3.0, {0.5: React("a", "wave")})
    heard = next(stamp for stamp, samples in link.blocks if samples.any())
    shown = [stamp for stamp, _, _ in link.pictures]
    seen = next(index for index, pose in enumerate(drawing.poses) if pose.right.z != drawing.poses[0].right.z)
    assert shown[seen - 1] <= heard < shown[seen]
    assert 500_000_000 <= heard - 100_000_000_000 <= 620_000_000


def test_a_picture_is_i420() -> None:
    link, _ = played(0.1)
    _, pixels, format = link.pictures[0]
    assert format is PixelFormat.I420
    assert len(pixels) == SIZE.width * SIZE.height * 3 // 2


def test_a_slow_renderer_skips_deadlines_and_queues_nothing() -> None:
    link, drawing = played(2.0, seconds=0.1)
    assert 18 <= len(drawing.poses) <= 21
    stamps = [stamp for stamp, _, _ in link.pictures]
    assert all(later - earlier >= 66_000_000 for earlier, later in pairwise(stamps))
    assert len({stamp for stamp, _ in link.blocks}) == len(link.blocks) < 103


def test_skipped_pictures_are_reported_now_and_then() -> None:
    link, _ = played(25.0, seconds=0.05)
    logs = [event.text for _, event in link.events if isinstance(event, Log)]
    assert len(logs) == 2
    assert "pictures" in logs[0]


def test_nothing_is_reported_when_all_is_in_time() -> None:
    link, _ = played(12.0)
    assert link.events == []


def test_a_reaction_is_played_and_completed() -> None:
    link, drawing = played(4.0, {0.5: React("a", "wave")})
    ((time, event),) = link.events
    assert event == Completed("a", "OK")
    assert 0.5 + REACTIONS["wave"].duration <= time <= 0.65 + REACTIONS["wave"].duration
    assert max(pose.right.z for pose in drawing.poses[:14]) < -4
    assert max(pose.right.z for pose in drawing.poses[15:60]) > -1.5
    assert max(int(np.abs(samples).max()) for _, samples in link.blocks) > 1000


def test_stop_completes_with_abort_and_ends_its_sound() -> None:
    link, _ = played(3.0, {0.5: React("a", "wave"), 0.8: Stop("a")})
    ((time, event),) = link.events
    assert event == Completed("a", "ABORT")
    assert 0.8 <= time < 0.91
    assert not any(samples.any() for stamp, samples in link.blocks if stamp > 100_900_000_000)


def test_a_reaction_the_engine_does_not_have_is_an_error() -> None:
    link, _ = played(1.0, {0.2: React("a", "somersault")})
    assert [event for _, event in link.events] == [Completed("a", "ERROR")]


def test_speech_starts_when_its_sound_does_and_silence_ends_it() -> None:
    speech = Speak("s", 101_000_000_000, (Viseme(0.0, "aa", 1.0), Viseme(400.0, "oh", 1.0)), 5000)
    _, drawing = played(3.0, {0.2: speech, 2.0: Silence()})
    jaws = [pose.mouth.jaw for pose in drawing.poses]
    assert max(jaws[:27]) == 0.0
    assert jaws[36] > 0.9
    assert drawing.poses[50].mouth.round > 0.5
    assert jaws[65] == 0.0


def test_the_avatar_looks_where_it_is_told_to() -> None:
    _, drawing = played(2.0, {0.5: Look(1.0, 0.0)})
    assert drawing.poses[55].head_yaw > 0.25


def test_a_loop_that_is_always_late_still_listens() -> None:
    link, drawing = played(9.0, {1.0: React("a", "somersault"), 2.0: Quit()}, seconds=0.2)
    assert [event for _, event in link.events] == [Completed("a", "ERROR")]
    assert len(drawing.poses) <= 12


def test_quit_ends_the_loop_at_once() -> None:
    link, _ = played(9.0, {1.0: Quit()})
    assert 29 <= len(link.pictures) <= 31


def test_the_room_is_told_first_and_then_what_changes_in_it() -> None:
    link, drawing = played(2.0)
    assert [type(event) for _, event in link.told] == [Floor, Things, Place]
    assert link.told[0][1] == ROOM.floor
    assert {scene.place for scene in drawing.scenes} == {Place(0.0, 0.0, -pi / 2)}


def test_viewpoint_is_applied_and_an_unknown_one_changes_nothing() -> None:
    _, drawing = played(3.0, {0.5: Viewpoint("eyes"), 1.5: Viewpoint("the moon"), 2.0: Viewpoint("automatic")})
    own = [scene.shot.own for scene in drawing.scenes]
    assert (own[10], own[20], own[50], own[-1]) == (False, True, True, False)


def test_the_figure_walks_and_tells_where_it_is() -> None:
    link, drawing = played(8.0, {0.5: Walk("a", (Waypoint(0.0, 1.0), Waypoint(-0.5, 1.0, -pi / 2)), 1.0)})
    assert [event for _, event in link.events] == [Reached("a", 0), Reached("a", 1), Completed("a", "OK")]
    places = [(time, event) for time, event in link.told if isinstance(event, Place)]
    assert places[-1][1] == Place(-0.5, 1.0, -pi / 2) == drawing.scenes[-1].place
    assert all(later - earlier >= 0.049 for (earlier, _), (later, _) in pairwise(places[:-1]))
    assert max(pose.left_leg.knee for pose in drawing.poses) > 0.3


def test_figure_speaks_and_waves_while_it_walks() -> None:
    speech = Speak("s", 101_000_000_000, (Viseme(0.0, "aa", 1.0),), 5000)
    walk = Walk("a", (Waypoint(0.0, 3.0),), 0.8)
    link, drawing = played(6.0, {0.2: walk, 0.5: speech, 1.5: React("b", "wave")})
    assert [event for _, event in link.events] == [Completed("b", "OK"), Reached("a", 0), Completed("a", "OK")]
    pose, scene = drawing.poses[80], drawing.scenes[80]
    assert pose.mouth.jaw > 0.9
    assert pose.right.z > -1.6
    assert 0.5 < scene.place.y < 2.5
    assert not scene.shot.is_close


def test_a_lost_driver_leaves_a_figure_that_stands() -> None:
    link, drawing = played(3.0, {0.5: Drive(0.6, 0.0, 0.0), 0.7: Drive(0.6, 0.0, 0.0)})
    moments = [stamp / 1e9 - 100 for stamp, _, _ in link.pictures]
    moving = [
        time
        for time, (before, after) in zip(moments[1:], pairwise(drawing.scenes), strict=True)
        if before.place != after.place
    ]
    assert 0.5 < moving[0] < 0.6
    assert 1.0 < moving[-1] <= 1.2
    assert drawing.scenes[-1].place.y < -0.2


def test_the_radio_is_heard_by_a_figure_that_comes_to_it() -> None:
    link, _ = played(6.0, {0.2: Walk("a", (Waypoint(0.6, 1.2), Waypoint(1.6, 1.6)), 1.5)})
    assert not any(samples.any() for _, samples in link.blocks[:50])
    assert max(int(np.abs(samples).max()) for _, samples in link.blocks[-60:]) > 200


def test_halt_ends_a_walk() -> None:
    link, drawing = played(3.0, {0.2: Walk("a", (Waypoint(0.0, -0.6),), 0.5), 1.0: Halt()})
    ((time, event),) = link.events
    assert event == Completed("a", "ABORT")
    assert 1.0 <= time < 1.1
    assert -0.5 < drawing.scenes[-1].place.y < -0.05


@pytest.mark.parametrize(
    ("begun", "stopped"),
    [
        (Speak("s", 102_000_000_000, (), 5000), Silence()),
        (React("r", "bow"), Stop("r")),
        (React("r", "bow"), Stop(None)),
    ],
    ids=["speech", "reaction", "all reactions"],
)
def test_stopped_reaction_does_not_turn_the_figure_to_the_viewer(begun: Command, stopped: Command) -> None:
    away = Walk("a", (Waypoint(0.0, 0.0, pi / 2),), 0.5)
    link, drawing = played(4.0, {0.0: away, 1.95: begun, 2.3: stopped})
    places = {stamp: scene.place for (stamp, _, _), scene in zip(link.pictures, drawing.scenes, strict=True)}
    before = [place for stamp, place in places.items() if 101.8e9 < stamp < 101.94e9]
    after = [place for stamp, place in places.items() if stamp > 102.43e9]
    assert before[-1].th == pi / 2
    assert after[0] != before[-1], "it has begun to turn"
    assert set(after) == {after[0]}
    assert abs(after[0].th + pi / 2) > 0.5, "and not come to the end of it"


def test_bgra_becomes_limited_range_planes() -> None:
    white = np.full((4, 4, 4), 255, np.uint8)
    planes = i420(white)
    assert planes.shape == (6, 4)
    assert set(planes[:4].ravel()) == {235}
    assert set(planes[4:].ravel()) == {128}


def test_a_still_shows_the_reaction_and_the_viseme() -> None:
    assert still_pose().right.z < -4
    assert still_pose("wave", None, 0.8).right.z > -1.5
    assert still_pose(None, "aa").mouth.jaw > 0.9


def test_a_still_has_its_eyes_open() -> None:
    assert {still_pose(None, None, number / 7).lid_left for number in range(30)} == {0.0}


@pytest.fixture
def quiet_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (ADDRESS_VARIABLE, SECRET_VARIABLE):
        monkeypatch.delenv(name, raising=False)


def stage(picture: Picture) -> Drawing:
    return Drawing(Clock())


def works() -> tuple[bool, str]:
    return True, ""


def test_an_engine_that_cannot_run_says_why(capsys: pytest.CaptureFixture[str]) -> None:
    assert main("test", lambda: (False, "install it"), stage, VIEWPOINTS, []) == UNAVAILABLE
    assert capsys.readouterr().err == "install it\n"


@pytest.mark.usefixtures("quiet_environment")
def test_an_engine_without_an_adapter_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert main("test", works, stage, VIEWPOINTS, ["--size", "320x180"]) == LINK_LOST
    assert "is not set" in capsys.readouterr().err


@pytest.mark.usefixtures("quiet_environment")
@pytest.mark.parametrize(("chosen", "resized"), [((1280, 720), []), ((640, 360), [Picture(640, 360, 25)])])
def test_without_a_size_the_machine_decides(
    chosen: tuple[int, int],
    resized: list[Picture],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    made: list[tuple[Picture, Drawing]] = []

    def factory(picture: Picture) -> Drawing:
        made.append((picture, stage(picture)))
        return made[-1][1]

    monkeypatch.setattr(size_choice, "choose_size", lambda *_: (Picture(*chosen, 25), "this decided"))
    assert main("test", works, factory, VIEWPOINTS, ["--fps", "25"]) == LINK_LOST
    assert "this decided" in capsys.readouterr().err
    ((first, drawing),) = made
    assert first == Picture(1280, 720, 25)
    assert drawing.sizes == resized


def test_a_still_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "still.png"
    arguments = ["--still", str(file), "--viseme", "aa", "--reaction", "wave", "--at", "0.8", "--place", "1,0.5,-1.2"]
    assert main("test", works, stage, VIEWPOINTS, arguments) == 0
    picture = cv2.imread(str(file))
    assert picture is not None
    assert picture.shape == (SIZE.height, SIZE.width, 3)
    assert main("test", works, stage, VIEWPOINTS, ["--still", str(tmp_path / "no" / "still.png")]) == 1
    assert "cannot write" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments", [["--size", "641x360"], ["--size", "big"], ["--fps", "0"], ["--reaction", "fly"], ["--place", "1,2"]]
)
def test_settings_that_make_no_sense_are_refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main("test", works, stage, VIEWPOINTS, arguments)
    assert "error" in capsys.readouterr().err


def test_the_mouth_follows_the_operator() -> None:
    clock = Clock()
    link, drawing = Link(clock, 1.0), Drawing(clock)
    blocks = stereo_48k(voice(0.4))[:, :1].reshape(-1, 960, 1)
    link.voice = {100.2 + number / 50: block for number, block in enumerate(blocks)}
    Runner(link, drawing, SIZE, clock).run()
    jaws = [pose.mouth.jaw for pose in drawing.poses]
    assert jaws[:6] == [0.0] * 6
    assert max(jaws[6:20]) > 0.2
    assert jaws[-1] < 0.05
