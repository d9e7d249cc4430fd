"""Which ends of a topic match, and what is said of those that do not."""

import pytest
from openrois_robots.ros2.graph.matching import BEST_EFFORT, Direction, Peer, Qos, is_match, topic_problem

ODOMETRY = "nav_msgs/msg/Odometry"
RELIABLE, KEPT = Qos(), Qos("reliable", "transient_local", 1)


@pytest.mark.parametrize(
    ("direction", "ours", "theirs", "matches"),
    [
        ("subscribe", RELIABLE, RELIABLE, True),
        ("subscribe", BEST_EFFORT, RELIABLE, True),
        ("subscribe", RELIABLE, BEST_EFFORT, False),
        ("subscribe", RELIABLE, KEPT, True),
        ("subscribe", KEPT, RELIABLE, False),
        ("publish", RELIABLE, BEST_EFFORT, True),
        ("publish", BEST_EFFORT, RELIABLE, False),
        ("publish", RELIABLE, KEPT, False),
        ("publish", KEPT, RELIABLE, True),
    ],
)
def test_what_is_asked_for_has_to_be_offered(direction: Direction, ours: Qos, theirs: Qos, matches: bool) -> None:
    assert is_match(direction, ODOMETRY, ours, Peer(ODOMETRY, theirs)) is matches


def test_types_have_to_be_the_same() -> None:
    assert not is_match("subscribe", ODOMETRY, RELIABLE, Peer("nav_msgs/msg/Path", RELIABLE))


@pytest.mark.parametrize(
    ("direction", "ours", "peers", "said"),
    [
        ("subscribe", RELIABLE, [], "no node publishes /odom"),
        ("publish", RELIABLE, [], "no node subscribes to /odom"),
        (
            "subscribe",
            RELIABLE,
            [Peer("nav_msgs/msg/Path", RELIABLE)],
            "/odom is published as nav_msgs/msg/Path, and the mapping file has nav_msgs/msg/Odometry:"
            " correct the type or the topic",
        ),
        (
            "subscribe",
            RELIABLE,
            [Peer("x/msg/X", RELIABLE), Peer(ODOMETRY, BEST_EFFORT)],
            '/odom is published best_effort, and the mapping file has reliable: set reliability = "best_effort" for it',
        ),
        (
            "subscribe",
            KEPT,
            [Peer(ODOMETRY, RELIABLE)],
            '/odom is published volatile, and the mapping file has transient_local: set durability = "volatile" for it',
        ),
        (
            "publish",
            BEST_EFFORT,
            [Peer(ODOMETRY, RELIABLE)],
            '/odom is subscribed to reliable, and the mapping file has best_effort: set reliability = "reliable"'
            " for it",
        ),
        (
            "subscribe",
            RELIABLE,
            [Peer(ODOMETRY, RELIABLE)],
            "/odom is published as nav_msgs/msg/Odometry, and does not match: the robot has another definition of it;"
            " name its distribution, or the folder with its interfaces, in [ros]",
        ),
    ],
)
def test_why_there_is_no_match_is_said(direction: Direction, ours: Qos, peers: list[Peer], said: str) -> None:
    assert topic_problem(direction, "/odom", ODOMETRY, ours, peers) == said
