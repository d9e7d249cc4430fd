from dataclasses import FrozenInstanceError, replace

import pytest
from openrois_avatar.engines.animation.pose import Arm, Mouth, Pose, channels, from_channels


def test_a_pose_survives_its_channels() -> None:
    pose = Pose(head_yaw=0.2, mouth=Mouth(jaw=0.5), left=Arm(curl=0.9), right=Arm(out=2.0))
    flat = channels(pose)
    assert (flat["head_yaw"], flat["mouth.jaw"], flat["left.curl"], flat["right.out"]) == (0.2, 0.5, 0.9, 2.0)
    assert from_channels(flat) == pose


def test_a_channel_that_is_missing_is_named() -> None:
    flat = channels(Pose())
    del flat["mouth.jaw"]
    with pytest.raises(KeyError, match=r"mouth\.jaw"):
        from_channels(flat)


def test_a_pose_does_not_change() -> None:
    pose = Pose()
    with pytest.raises(FrozenInstanceError):
        pose.lean = 1.0  # type: ignore[misc]
    assert replace(pose, lean=1.0) != pose
