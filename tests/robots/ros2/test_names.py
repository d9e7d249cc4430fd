"""Names of ROS, as they are resolved and as DDS has them."""

import pytest
from openrois_robots.ros2.graph.names import dds_topic, dds_type, reply_topic, request_topic, resolve_name, ros_type


@pytest.mark.parametrize(
    ("name", "namespace", "full"),
    [
        ("cmd_vel", "/", "/cmd_vel"),
        ("cmd_vel", "/robot_1", "/robot_1/cmd_vel"),
        ("camera/image_raw", "/robot_1/", "/robot_1/camera/image_raw"),
        ("/cmd_vel", "/robot_1", "/cmd_vel"),
    ],
)
def test_a_name_is_relative_to_the_namespace_unless_it_begins_at_the_root(name: str, namespace: str, full: str) -> None:
    assert resolve_name(name, namespace) == full


@pytest.mark.parametrize("name", ["", "/", "a//b", "1a", "a/2b", "a b", "a-b", "a__b", "ä", "a/", "~/a", "a" * 241])
def test_what_cannot_be_a_name_is_said(name: str) -> None:
    with pytest.raises(ValueError, match="cannot be a name of ROS: it has words"):
        resolve_name(name)


def test_the_names_of_dds_are_those_of_ros() -> None:
    assert dds_topic("/cmd_vel") == "rt/cmd_vel"
    assert request_topic("/go/_action/send_goal") == "rq/go/_action/send_goalRequest"
    assert reply_topic("/add") == "rr/addReply"


@pytest.mark.parametrize(
    ("ros", "dds"),
    [
        ("geometry_msgs/msg/Twist", "geometry_msgs::msg::dds_::Twist_"),
        ("nav2_msgs/action/Go_SendGoal_Request", "nav2_msgs::action::dds_::Go_SendGoal_Request_"),
    ],
)
def test_types_have_two_names(ros: str, dds: str) -> None:
    assert dds_type(ros) == dds
    assert ros_type(dds) == ros


def test_a_type_that_is_none_of_ros_keeps_its_name() -> None:
    assert ros_type("Other::Thing") == "Other::Thing"
