"""The mapping file: what it binds, and the sentence for each mistake."""

import tomllib
from copy import deepcopy
from math import inf, nan
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_robots.ros2.mapping.reading import read_mapping, read_place
from openrois_robots.ros2.mapping.settings import Place, RobotMapping

from tests.support.ros_robot import MAPPING

pytestmark = pytest.mark.extra(name="ros2")

LEAST = '[odometry]\ntopic = "odom"\n'


def read(text: str) -> RobotMapping:
    return read_mapping(tomllib.loads(text))


def test_names_are_in_the_namespace_of_the_robot() -> None:
    mapping = read(
        '[ros]\nnamespace = "robot_1"\n' + LEAST + '[velocity]\ntopic = "/cmd_vel"\n'
        '[navigation]\naction = "navigate_to_pose"\nspeed_limit = "speed_limit"\n'
        '[follow.targets]\nvisitor = "visitor_pose"\n[camera.front]\ntopic = "camera/image"\n'
        '[speech]\ntopic = "say"\nspeaking = "speaking"\nhush = "hush"\n'
    )
    assert mapping.ros.namespace == "/robot_1"
    assert mapping.odometry is not None
    assert mapping.odometry.topic == "/robot_1/odom"
    assert mapping.velocity is not None
    assert mapping.velocity.topic == "/cmd_vel"
    assert mapping.navigation is not None
    assert mapping.navigation.action == "/robot_1/navigate_to_pose"
    assert mapping.navigation.speed_limit == "/robot_1/speed_limit"
    assert mapping.follow is not None
    assert mapping.follow.targets == {"visitor": "/robot_1/visitor_pose"}
    assert mapping.cameras["front"].topic == "/robot_1/camera/image"
    assert mapping.speech is not None
    assert (mapping.speech.topic, mapping.speech.speaking) == ("/robot_1/say", "/robot_1/speaking")
    assert mapping.speech.hush == "/robot_1/hush"


def test_what_a_file_lacks_is_not_there() -> None:
    mapping = read(LEAST)
    lacking = (mapping.pose, mapping.battery, mapping.velocity, mapping.navigation, mapping.follow, mapping.speech)
    assert lacking == (None,) * 6
    assert not mapping.cameras
    assert not mapping.places
    assert (mapping.ros.domain, mapping.ros.backend, mapping.ros.distribution) == (-1, "auto", "jazzy")


def test_places_have_a_direction_or_none() -> None:
    mapping = read(LEAST + '[places]\ndock = "0, -1.5"\ntable = "1,2,3"\n')
    assert mapping.places == {"dock": Place(0.0, -1.5), "table": Place(1.0, 2.0, 3.0)}


@pytest.mark.parametrize("text", ["", "1", "1,2,3,4", "a,b", "1,nan", "inf,1", "10001,0", "1,,2"])
def test_what_is_no_place_is_none(text: str) -> None:
    assert read_place(text) is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no part of the robot is named: write at least"),
        ("[robot]\n", "there is no table 'robot'; there are ros, base,"),
        ("ros = 1\n", "ros must be a table"),
        (LEAST + "[ros]\ndomain = 233\n", "ros.domain must be between -1 and 232, not 233"),
        (LEAST + "[ros]\ndomain = true\n", "ros.domain must be an integer, not True"),
        (LEAST + '[ros]\nbackend = "fastdds"\n', "ros.backend must be one of auto, rclpy, cyclonedds, not 'fastdds'"),
        (LEAST + '[ros]\ndistribution = "foxy"\n', "ros.distribution must be one of humble, jazzy, kilted, lyrical"),
        (LEAST + '[ros]\nnamespace = "a b"\n', "ros.namespace: 'a b' cannot be a name of ROS"),
        (LEAST + "[ros]\nspeed = 1\n", "ros.speed is not known; ros has domain, namespace"),
        (LEAST + "[base]\nmax_speed = 9\n", "base.max_speed must be between 0.01 and 5, not 9"),
        (LEAST + "[base]\nmax_turn = 0\n", "base.max_turn must be between 0.01 and 10, not 0"),
        ("[odometry]\n", "odometry.topic is missing: write the name that the robot has for it"),
        ('[odometry]\ntopic = "1"\n', "odometry.topic: '1' cannot be a name of ROS"),
        (LEAST + 'reliability = "good"\n', "odometry.reliability must be one of best_effort, reliable, not 'good'"),
        (LEAST + "silence = 0.01\n", "odometry.silence must be between 0.1 and 60, not 0.01"),
        (LEAST + '[pose]\ntopic = "p"\ntype = "x/msg/P"\n', "pose.type must be one of geometry_msgs/msg/PoseWith"),
        (LEAST + '[pose]\ntopic = "p"\ndurability = "long"\n', "pose.durability must be one of volatile"),
        ('[pose]\ntopic = "p"\n[speech]\ntopic = "say"\n', r"\[pose\] needs \[odometry\]: a robot that moves has to"),
        ('[velocity]\ntopic = "p"\n', r"\[velocity\] needs \[odometry\]"),
        (LEAST + '[battery]\ntopic = "b"\nfull = 0\n', "battery.full must be between 0.1 and 1000, not 0"),
        (LEAST + '[battery]\ntopic = "b"\nlow = 91\n', "battery.low must be between 0 and 90, not 91"),
        (LEAST + '[velocity]\ntopic = "v"\ntype = "x/msg/V"\n', "velocity.type must be one of geometry_msgs/msg/Twist"),
        (LEAST + "[navigation]\n", "navigation.action is missing"),
        (LEAST + '[navigation]\naction = "n"\ndock = "d"\n', r"navigation.dock is 'd', which \[places\] does not have"),
        (LEAST + '[places]\ndock = "here"\n', 'places.dock must be "x,y" or "x,y,th" in metres and radians'),
        (LEAST + '[places]\n"1,2" = "1,2"\n', "places.1,2 cannot be the name of a place: it is a place itself"),
        (LEAST + "[places]\ndock = 1\n", "places.dock must be a text, not 1"),
        (LEAST + "[places]\ndock = [1, 2]\n", r"places.dock must be a text, not \[1, 2\]"),
        ("places = 1\n" + LEAST, "places must be a table"),
        (LEAST + "[follow.targets]\nvisitor = true\n", "follow.targets.visitor must be a text, not True"),
        (
            LEAST + '[battery]\ntopic = "odom"\n',
            "battery.topic is /odom as sensor_msgs/msg/BatteryState, and odometry.topic is the same topic as"
            " nav_msgs/msg/Odometry: a topic has one type",
        ),
        (
            LEAST + '[speech]\ntopic = "say"\nhush = "say"\n',
            "speech.hush is /say as std_msgs/msg/Empty, and speech.topic is the same",
        ),
        (
            LEAST + '[camera.a]\ntopic = "c"\n[camera.b]\ntopic = "c"\ntype = "sensor_msgs/msg/Image"\n',
            "camera.b.topic is /c as sensor_msgs/msg/Image, and camera.a.topic is the same",
        ),
        (LEAST + "[follow]\n", r"follow.targets is missing: write under \[follow.targets\] lines as"),
        (LEAST + "[follow]\nspeed = 1\n", "follow.speed is not known; follow has targets and reliability"),
        (LEAST + "[follow]\nreliability = 1\n", "follow must be a table with a table follow.targets"),
        (LEAST + '[follow.targets]\nv = "a b"\n', "follow.targets.v: 'a b' cannot be a name of ROS"),
        (LEAST + '[follow.targets]\nv = "v"\n', r"\[follow\] needs \[navigation\]"),
        (LEAST + '[camera]\ntopic = "c"\n', r"camera must have a table for each camera: write \[camera.front\]"),
        (LEAST + '[camera."a/b"]\ntopic = "c"\n', "camera.a/b cannot name a component: it has a slash"),
        (LEAST + "[camera.front]\n", "camera.front.topic is missing"),
        (LEAST + '[camera.front]\ntopic = "c"\nwidth = 1\n', "camera.front.width must be between 16 and 8192, not 1"),
        (LEAST + '[camera.front]\ntopic = "c"\nfps = 1\n', "camera.front.fps is not known; camera.front has topic"),
        (LEAST + '[camera.front]\ntopic = "c"\nframe_rate = 999\n', "camera.front.frame_rate must be between 0.1"),
        (LEAST + '[camera.front]\ntopic = "c"\ntype = "x"\n', "camera.front.type must be one of sensor_msgs/msg/Comp"),
        ("[speech]\n", "speech must have a topic or a service that takes texts, and not both"),
        ('[speech]\ntopic = "a"\nservice = "b"\n', "and not both"),
        ('[speech]\nservice = "a"\n', "speech.type must be package/srv/Name, not 'std_msgs/msg/String'"),
        ('[speech]\ntopic = "a"\ntype = "x/srv/Y"\n', "speech.type must be package/msg/Name"),
        ('[speech]\ntopic = "a"\ntext = "A B"\n', "speech.text must be the name of a field, not 'A B'"),
        ('[speech]\ntopic = "a"\nlanguages = "English"\n', 'speech.languages must be codes as "en, ja"'),
        (
            '[speech]\nservice = "a"\ntype = "x/srv/Y"\nspeaking = "s"\n',
            "speech.speaking is for a topic: a service answers when the text has been spoken",
        ),
    ],
)
def test_a_mistake_is_said(text: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        read(text)


@pytest.mark.parametrize("name", ["camera", "places"])
def test_there_are_not_too_many(name: str) -> None:
    table = {f"n{number}": {"topic": "t"} if name == "camera" else "1,2" for number in range(1001)}
    with pytest.raises(ValueError, match=f"{name} must have at most"):
        read_mapping({"odometry": {"topic": "odom"}, name: table})


def test_one_topic_may_serve_two_parts() -> None:
    mapping = read(LEAST + '[pose]\ntopic = "odom"\ntype = "nav_msgs/msg/Odometry"\n[speech]\ntopic = "say"\n')
    assert mapping.pose is not None
    assert mapping.odometry is not None
    assert mapping.pose.topic == mapping.odometry.topic


@pytest.mark.parametrize("number", [nan, inf, -inf])
def test_numbers_that_are_none_are_refused(number: float) -> None:
    with pytest.raises(ValueError, match=r"base\.max_speed must be between"):
        read_mapping({"odometry": {"topic": "odom"}, "base": {"max_speed": number}})


def leaves() -> st.SearchStrategy[Any]:
    return st.one_of(st.text(max_size=8), st.integers(), st.floats(), st.booleans(), st.none(), st.just("odom"))


@st.composite
def bent(draw: st.DrawFn) -> dict[str, Any]:
    """Return a whole mapping in which something is replaced, removed or added."""
    document: dict[str, Any] = deepcopy(dict(MAPPING))
    for _ in range(draw(st.integers(1, 4))):
        table: Any = document
        while isinstance(table, dict) and table:
            key = draw(st.sampled_from(sorted(table)))
            inner = table[key]
            if not isinstance(inner, dict) or draw(st.booleans()):
                break
            table = inner
        if not isinstance(table, dict):
            continue
        what = draw(st.sampled_from(["replace", "remove", "add"]))
        value = draw(st.recursive(leaves(), lambda inner: st.dictionaries(st.text(max_size=4), inner, max_size=3)))
        if what == "remove" and table:
            table.pop(draw(st.sampled_from(sorted(table))))
        elif what == "replace" and table:
            table[draw(st.sampled_from(sorted(table)))] = value
        else:
            table[draw(st.one_of(st.text(max_size=6), st.sampled_from(["topic", "type", "targets"])))] = value
    return document


@given(bent())
def test_any_file_is_read_or_refused_in_a_sentence(document: dict[str, Any]) -> None:
    try:
        mapping = read_mapping(document)
    except ValueError as error:
        said = str(error)
        assert said
        assert len(said) < 10_000
        return
    assert mapping.odometry is None or mapping.odometry.topic.startswith("/")


@given(st.text(max_size=200))
def test_any_toml_is_read_or_refused(text: str) -> None:
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return
    with pytest.raises(ValueError, match=r"^\w.+"):
        read_mapping(document)


def test_the_whole_mapping_of_the_tests_is_right() -> None:
    assert read_mapping(MAPPING).navigation is not None
