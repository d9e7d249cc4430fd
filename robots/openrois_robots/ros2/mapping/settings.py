"""What a mapping file says, table by table. Pure.

Names of topics, services and actions are as the file has them until `read_mapping` resolves them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from openrois_robots.adapter.battery import BatteryLimit
from openrois_robots.ros2.interfaces.store import DEFAULT_DISTRIBUTION

__all__ = [
    "BATTERY",
    "HUSH",
    "IMAGES",
    "NAVIGATE",
    "ODOMETRY",
    "POSES",
    "SPEAKING",
    "SPEED_LIMIT",
    "TARGET",
    "TWISTS",
    "Battery",
    "Camera",
    "DrivingLimits",
    "Follow",
    "Navigation",
    "Odometry",
    "Place",
    "Pose",
    "RobotMapping",
    "Ros",
    "Speech",
    "Velocity",
]

ODOMETRY: Final = "nav_msgs/msg/Odometry"
POSES: Final = ("geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/msg/PoseStamped", ODOMETRY)
TWISTS: Final = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
IMAGES: Final = ("sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Image")
BATTERY: Final = "sensor_msgs/msg/BatteryState"
NAVIGATE: Final = "nav2_msgs/action/NavigateToPose"
SPEED_LIMIT: Final = "nav2_msgs/msg/SpeedLimit"
TARGET: Final = POSES[1]
SPEAKING: Final = "std_msgs/msg/Bool"
HUSH: Final = "std_msgs/msg/Empty"
"""The types of topics and of the action; of several the first is the default."""


@dataclass(frozen=True, slots=True)
class Ros:
    """The graph of the robot.

    Attributes:
        domain: ROS_DOMAIN_ID of the robot; -1: that of this process.
        namespace: of all names that do not begin with /.
        backend: `rclpy`, `cyclonedds`, or `auto`: rclpy where it is installed.
        distribution: of ROS; its definitions are used without rclpy.
        interfaces: a folder with further definitions, `package/msg/Name.msg`; empty: none.
    """

    domain: int = -1
    namespace: str = "/"
    backend: str = "auto"
    distribution: str = DEFAULT_DISTRIBUTION
    interfaces: str = ""


@dataclass(frozen=True, slots=True)
class DrivingLimits:
    """The limits of what the adapter itself drives.

    Attributes:
        max_speed: m/s.
        max_turn: rad/s.
    """

    max_speed: float = 0.5
    max_turn: float = 1.0


@dataclass(frozen=True, slots=True)
class Odometry:
    """The odometry of the robot, which is its sign of life.

    Attributes:
        topic: of `nav_msgs/msg/Odometry`.
        reliability: `best_effort` or `reliable`.
        silence: seconds without a message after which the robot counts as lost.
    """

    topic: str = ""
    reliability: str = "best_effort"
    silence: float = 1.0


@dataclass(frozen=True, slots=True)
class Pose:
    """The pose of the robot in its map, such as a localisation publishes it.

    Attributes:
        topic: of the pose.
        type: one of `POSES`.
        reliability: `best_effort` or `reliable`.
        durability: `volatile` or `transient_local`, which gets the last pose of a robot that stands.
    """

    topic: str = ""
    type: str = POSES[0]
    reliability: str = "reliable"
    durability: str = "transient_local"


@dataclass(frozen=True, slots=True)
class Battery:
    """The battery.

    Attributes:
        topic: of `sensor_msgs/msg/BatteryState`.
        reliability: `best_effort` or `reliable`.
        full: `percentage` of a full battery: 1, as ROS has it, or 100, as some drivers do.
        low: per cent below which goals other than the dock are refused; 0: never.
    """

    topic: str = ""
    reliability: str = "best_effort"
    full: float = 1.0
    low: float = BatteryLimit().low


@dataclass(frozen=True, slots=True)
class Velocity:
    """The topic with the velocity that the robot obeys.

    Attributes:
        topic: of the velocity.
        type: one of `TWISTS`.
        frame: of a `TwistStamped`.
        reliability: `reliable` or `best_effort`.
        sideways: whether the robot can step sideways.
        move: whether there is a component Move.
        teleoperation: whether there is a component Teleoperation, where there is a camera.
    """

    topic: str = ""
    type: str = TWISTS[0]
    frame: str = "base_link"
    reliability: str = "reliable"
    sideways: bool = False
    move: bool = True
    teleoperation: bool = True


@dataclass(frozen=True, slots=True)
class Navigation:
    """The action that takes the robot to a pose.

    Attributes:
        action: of `nav2_msgs/action/NavigateToPose`.
        frame: in which targets are.
        behavior_tree: of Nav2; empty for its default.
        speed_limit: topic of `nav2_msgs/msg/SpeedLimit`, on which `max_speed` of the base is published; empty: none.
        dock: the place that stays a goal while the battery is low; empty: none.
    """

    action: str = ""
    frame: str = "map"
    behavior_tree: str = ""
    speed_limit: str = ""
    dock: str = ""


@dataclass(frozen=True, slots=True)
class Follow:
    """What can be followed.

    Attributes:
        targets: by their names, topics of `geometry_msgs/msg/PoseStamped`.
        reliability: `best_effort` or `reliable`.
    """

    targets: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    reliability: str = "best_effort"


@dataclass(frozen=True, slots=True)
class Camera:
    """A camera.

    Attributes:
        topic: of its pictures.
        type: one of `IMAGES`.
        reliability: `best_effort` or `reliable`.
        width: pixels that are expected.
        height: pixels that are expected.
        frame_rate: pictures a second that are expected.
    """

    topic: str = ""
    type: str = IMAGES[0]
    reliability: str = "best_effort"
    width: int = 640
    height: int = 480
    frame_rate: float = 30.0


@dataclass(frozen=True, slots=True)
class Speech:
    """A node that speaks: by a topic or by a service.

    Attributes:
        topic: that takes texts; empty: a service does.
        service: that takes texts.
        type: of the topic or service.
        text: the field of the message, or of the request, with the text.
        speaking: topic of `std_msgs/msg/Bool` that is true while the robot speaks; empty: it does not tell.
        hush: topic of `std_msgs/msg/Empty` that makes it fall silent; empty: it cannot be stopped.
        languages: that it speaks, ISO 639-1 codes with commas between them.
    """

    topic: str = ""
    service: str = ""
    type: str = "std_msgs/msg/String"
    text: str = "data"
    speaking: str = ""
    hush: str = ""
    languages: str = "en"


@dataclass(frozen=True, slots=True)
class Place:
    """A place with a name, in the frame of the navigation: metres, and radians; None for any direction."""

    x: float
    y: float
    th: float | None = None


@dataclass(frozen=True, slots=True)
class RobotMapping:
    """All of a mapping file; a part that it does not have is None."""

    ros: Ros = Ros()
    base: DrivingLimits = DrivingLimits()
    odometry: Odometry | None = None
    pose: Pose | None = None
    battery: Battery | None = None
    velocity: Velocity | None = None
    navigation: Navigation | None = None
    places: Mapping[str, Place] = field(default_factory=lambda: MappingProxyType({}))
    follow: Follow | None = None
    cameras: Mapping[str, Camera] = field(default_factory=lambda: MappingProxyType({}))
    speech: Speech | None = None
