from itertools import pairwise

import pytest
from openrois_avatar.engines.animation.pose import Pose, channels
from openrois_avatar.engines.animation.reactions import REACTIONS

NAMES = (
    "nod",
    "tilt",
    "shake_head",
    "bow",
    "shake_hands",
    "glance_at_watch",
    "wave",
    "look_around",
    "shrug",
    "clap",
    "raise_hand",
    "surprise",
)


WRISTS = {f"{side}.{axis}" for side in ("left", "right") for axis in ("out", "y", "z")}


def test_these_are_the_reactions() -> None:
    assert tuple(REACTIONS) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_reaction_moves_known_channels_from_rest_to_rest(name: str) -> None:
    reaction = REACTIONS[name]
    assert set(reaction.curves) <= set(channels(Pose()))
    assert 0.8 <= reaction.duration <= 4.0
    assert {curve.end for curve in reaction.curves.values()} == {reaction.duration}
    assert set(reaction.at(0.0).values()) == {0.0}
    assert set(reaction.at(reaction.duration).values()) == {0.0}


@pytest.mark.parametrize("name", NAMES)
def test_a_reaction_is_seen_and_does_not_jump(name: str) -> None:
    reaction = REACTIONS[name]
    frames = [reaction.at(n / 60) for n in range(int(reaction.duration * 60) + 2)]
    assert max(abs(value) for frame in frames for value in frame.values()) > 0.15
    for channel in reaction.curves:
        # Wrists travel decimetres, everything else radians or shares.
        bound = (
            0.40 if channel in {f"{side}.{axis}" for side in ("left", "right") for axis in ("out", "y", "z")} else 0.2
        )
        assert max(abs(b[channel] - a[channel]) for a, b in pairwise(frames)) < bound, channel


def test_nodding_is_down_and_up_and_shaking_is_from_side_to_side() -> None:
    nod = [REACTIONS["nod"].at(n / 60)["head_pitch"] for n in range(75)]
    shake = [REACTIONS["shake_head"].at(n / 60)["head_yaw"] for n in range(96)]
    assert min(nod) < -0.2
    assert min(shake) < -0.25
    assert max(shake) > 0.25


@pytest.mark.parametrize(
    ("name", "sides"), [("wave", {"right"}), ("glance_at_watch", {"left"}), ("clap", {"left", "right"})]
)
def test_the_hands_that_belong_to_a_reaction_rise(name: str, sides: set[str]) -> None:
    half = REACTIONS[name].at(REACTIONS[name].duration / 2)
    assert {side for side in ("left", "right") if half.get(f"{side}.z", 0.0) > 1.5} == sides
