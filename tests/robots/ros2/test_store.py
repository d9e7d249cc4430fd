"""Definitions are found by name: the user's, those of a distribution, and those of all."""

from pathlib import Path

import pytest
from openrois_robots.ros2.interfaces.definitions import DefinitionError
from openrois_robots.ros2.interfaces.store import DISTRIBUTIONS, Interfaces

GO = "nav2_msgs/action/NavigateToPose"


@pytest.mark.parametrize(
    ("distribution", "result", "last"),
    [
        ("humble", ["result"], "distance_remaining"),
        ("jazzy", ["error_code", "error_msg"], "distance_remaining"),
        ("kilted", ["error_code", "error_msg"], "distance_remaining"),
        ("lyrical", ["error_code", "error_msg"], "heading_tracking_error"),
    ],
)
def test_nav2_has_what_the_distribution_has(distribution: str, result: list[str], last: str) -> None:
    assert distribution in DISTRIBUTIONS
    action = Interfaces(distribution).action(GO)
    assert [each.name for each in action.result.fields] == result
    assert action.feedback.fields[-1].name == last


def test_the_folder_of_the_user_comes_first(tmp_path: Path) -> None:
    folder = tmp_path / "std_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "String.msg").write_text("int32 number\n")
    assert Interfaces(folder=tmp_path).message("std_msgs/msg/String").fields[0].name == "number"
    assert Interfaces(folder=tmp_path).message("std_msgs/msg/Bool").fields[0].name == "data"


def test_what_is_not_there_is_said_with_where_it_may_be() -> None:
    with pytest.raises(
        DefinitionError, match=r"kit_msgs/msg/Kit is not known: name the folder .* /opt/ros/jazzy/share"
    ):
        Interfaces().message("kit_msgs/msg/Kit")


@pytest.mark.parametrize("name", ["Twist", "geometry_msgs/Twist", "../msg/Passwd", "a/srv/B", "a/msg/../B", ""])
def test_what_is_no_name_is_said(name: str) -> None:
    with pytest.raises(DefinitionError, match="is no name of an interface: expected package/msg/Name"):
        Interfaces().message(name)


def test_a_file_that_cannot_be_read_is_said(tmp_path: Path) -> None:
    folder = tmp_path / "kit_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Kit.msg").write_bytes(b"\xff\xfe")
    with pytest.raises(DefinitionError, match=r"Kit\.msg cannot be read"):
        Interfaces(folder=tmp_path).message("kit_msgs/msg/Kit")


def test_the_parts_of_services_and_actions_are_messages() -> None:
    interfaces = Interfaces()
    interfaces.action(GO)
    interfaces.service("action_msgs/srv/CancelGoal")
    for name in (
        f"{GO}_Goal",
        f"{GO}_SendGoal_Request",
        f"{GO}_FeedbackMessage",
        "action_msgs/srv/CancelGoal_Response",
    ):
        assert interfaces.message(name).name == name
