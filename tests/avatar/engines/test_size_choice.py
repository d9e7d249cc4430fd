import numpy as np
import pytest
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.runner import i420
from openrois_avatar.engines.settings import LARGE, SMALL, Picture, Pixels
from openrois_avatar.engines.size_choice import LONGEST, PICTURES, choose_size, encoding


class Machine:
    """Draws in so many seconds of processor time, which take `busy` times as long."""

    def __init__(self, drawing: float, encoding: float = 0.0, busy: float = 1.0) -> None:
        self.drawing, self.encoding, self.busy = drawing, encoding, busy
        self.spent = self.time = 0.0
        self.poses: list[Pose] = []
        self.encoded: list[int] = []

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        self.poses.append(pose)
        # The first pictures take longer, on every machine.
        self._work(self.drawing * (5.0 if len(self.poses) < 3 else 1.0))
        return np.zeros((2, 2, 4), np.uint8)

    def resize(self, picture: Picture) -> None:
        raise AssertionError("the size is chosen, not taken")

    def encode(self, pixels: Pixels, number: int) -> None:
        self.encoded.append(number)
        self._work(self.encoding)

    def _work(self, seconds: float) -> None:
        self.spent += seconds
        self.time += seconds * self.busy

    def chooses(self, fps: int = 30) -> tuple[Picture, str]:
        return choose_size(self, fps, self.encode, lambda: self.spent, lambda: self.time)


@pytest.mark.parametrize(
    ("machine", "fps", "size"),
    [
        (Machine(0.006, 0.005), 30, LARGE),
        (Machine(0.008, 0.005), 30, SMALL),
        (Machine(0.006, 0.005), 60, SMALL),
        (Machine(0.020, 0.010), 10, LARGE),
        (Machine(0.006, 0.005, busy=5.0), 30, LARGE),
    ],
    ids=["carried", "drawing and encoding together do not fit", "half the time", "three times", "busy for a moment"],
)
def test_the_size_is_large_where_a_third_of_the_time_is_enough(
    machine: Machine, fps: int, size: tuple[int, int]
) -> None:
    assert machine.chooses(fps)[0] == Picture(*size, fps)
    assert machine.encoded == list(range(PICTURES))
    assert len({pose.mouth for pose in machine.poses}) > 3  # a talking figure: its face is drawn anew


def test_the_figure_that_decided_is_told() -> None:
    assert Machine(0.008, 0.005).chooses()[1] == (
        "pictures of 640x360: a picture of 1280x720 takes 13.0 ms to draw and encode; 11.1 ms are allowed"
    )


def test_a_slow_machine_is_not_asked_for_long() -> None:
    machine = Machine(0.4)
    picture, told = machine.chooses()
    assert (picture.width, picture.height) == SMALL
    assert "not even 3 pictures of 1280x720 in 1 s" in told
    assert machine.time <= LONGEST + 5 * 0.4


def test_trial_encodes_a_stream_of_large_pictures() -> None:
    encode, pixels = encoding(30, i420), np.full((LARGE[1], LARGE[0], 4), 90, np.uint8)
    chunks = [encode(pixels, number) for number in range(2)]
    assert all(len(chunk) == 1 for chunk in chunks)
    assert [chunk[0].keyframe for chunk in chunks] == [True, False]
