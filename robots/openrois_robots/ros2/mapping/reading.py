"""Reading a mapping file: every mistake is a sentence that names the table, the key, and what to write."""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from math import isfinite
from types import MappingProxyType
from typing import Any, Final, TypeVar

from openrois.types.references import flaw_of_name
from openrois_robots.adapter.options import read_table
from openrois_robots.ros2.graph.names import resolve_name
from openrois_robots.ros2.interfaces.store import DISTRIBUTIONS
from openrois_robots.ros2.mapping import settings
from openrois_robots.ros2.mapping.settings import Place, RobotMapping, Ros

__all__ = ["read_mapping", "read_place"]

MOST: Final = 16
"""Cameras, and targets to follow, that a robot may have."""
_PLACES: Final = 1000
_FAR: Final = 10_000.0
"""Metres that a place may be away."""
_RELIABILITIES: Final = ("best_effort", "reliable")
_DURABILITIES: Final = ("volatile", "transient_local")
_INTERFACE: Final = re.compile(r"[a-z][a-z0-9_]*/(msg|srv)/[A-Z][A-Za-z0-9]*")
_TABLES: Final = (
    *("ros", "base", "odometry", "pose", "battery", "velocity", "navigation"),
    *("places", "follow", "camera", "speech"),
)

_TYPES: Final = (
    ("odometry", "topic", settings.ODOMETRY),
    ("battery", "topic", settings.BATTERY),
    ("navigation", "speed_limit", settings.SPEED_LIMIT),
    ("speech", "speaking", settings.SPEAKING),
    ("speech", "hush", settings.HUSH),
)
"""Tables, their keys with a topic, and its type."""

_T = TypeVar("_T")


def read_mapping(document: Mapping[str, Any]) -> RobotMapping:
    """Return the mapping of a file's content, with all names from the root on.

    Args:
        document: the file, as TOML is read.

    Raises:
        ValueError: something in it is wrong; a sentence for a person.
    """
    unknown = document.keys() - set(_TABLES)
    if unknown:
        raise ValueError(f"there is no table {min(unknown)!r}; there are {', '.join(_TABLES)}")
    ros = _ros(read_table(Ros, "ros", document.get("ros", {})))

    def read(name: str, function: Callable[[str, Any, str], _T]) -> _T | None:
        return function(name, document[name], ros.namespace) if name in document else None

    mapping = RobotMapping(
        ros=ros,
        base=_base(read_table(settings.DrivingLimits, "base", document.get("base", {}))),
        odometry=read("odometry", _odometry),
        pose=read("pose", _pose),
        battery=read("battery", _battery),
        velocity=read("velocity", _velocity),
        navigation=read("navigation", _navigation),
        places=_places(document.get("places", {})),
        follow=read("follow", _follow),
        cameras=_cameras(document.get("camera", {}), ros.namespace),
        speech=read("speech", _speech),
    )
    _check_parts(mapping)
    _check_types(mapping)
    return mapping


def read_place(text: str) -> Place | None:
    """Return the place of `x,y` or `x,y,th` in metres and radians; None: it is none."""
    parts = text.split(",")
    if len(parts) not in (2, 3):
        return None
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        return None
    if not all(isfinite(each) for each in numbers) or max(abs(numbers[0]), abs(numbers[1])) > _FAR:
        return None
    return Place(numbers[0], numbers[1], numbers[2] if len(numbers) == 3 else None)


def _ros(ros: Ros) -> Ros:
    _check_between("ros.domain", ros.domain, -1, 232)
    _check_choice("ros.backend", ros.backend, ("auto", "rclpy", "cyclonedds"))
    _check_choice("ros.distribution", ros.distribution, DISTRIBUTIONS)
    if ros.namespace == "/":
        return ros
    return replace(ros, namespace=_resolved("ros.namespace", ros.namespace, "/"))


def _base(base: settings.DrivingLimits) -> settings.DrivingLimits:
    _check_between("base.max_speed", base.max_speed, 0.01, 5.0)
    _check_between("base.max_turn", base.max_turn, 0.01, 10.0)
    return base


def _odometry(name: str, table: Any, namespace: str) -> settings.Odometry:
    odometry = read_table(settings.Odometry, name, table)
    _check_between(f"{name}.silence", odometry.silence, 0.1, 60.0)
    _check_choice(f"{name}.reliability", odometry.reliability, _RELIABILITIES)
    return replace(odometry, topic=_required(f"{name}.topic", odometry.topic, namespace))


def _pose(name: str, table: Any, namespace: str) -> settings.Pose:
    pose = read_table(settings.Pose, name, table)
    _check_choice(f"{name}.type", pose.type, settings.POSES)
    _check_choice(f"{name}.reliability", pose.reliability, _RELIABILITIES)
    _check_choice(f"{name}.durability", pose.durability, _DURABILITIES)
    return replace(pose, topic=_required(f"{name}.topic", pose.topic, namespace))


def _battery(name: str, table: Any, namespace: str) -> settings.Battery:
    battery = read_table(settings.Battery, name, table)
    _check_choice(f"{name}.reliability", battery.reliability, _RELIABILITIES)
    _check_between(f"{name}.full", battery.full, 0.1, 1000.0)
    _check_between(f"{name}.low", battery.low, 0.0, 90.0)
    return replace(battery, topic=_required(f"{name}.topic", battery.topic, namespace))


def _velocity(name: str, table: Any, namespace: str) -> settings.Velocity:
    velocity = read_table(settings.Velocity, name, table)
    _check_choice(f"{name}.type", velocity.type, settings.TWISTS)
    _check_choice(f"{name}.reliability", velocity.reliability, _RELIABILITIES)
    return replace(velocity, topic=_required(f"{name}.topic", velocity.topic, namespace))


def _navigation(name: str, table: Any, namespace: str) -> settings.Navigation:
    navigation = read_table(settings.Navigation, name, table)
    limit = navigation.speed_limit
    return replace(
        navigation,
        action=_required(f"{name}.action", navigation.action, namespace),
        speed_limit=_resolved(f"{name}.speed_limit", limit, namespace) if limit else "",
    )


def _follow(name: str, table: Any, namespace: str) -> settings.Follow:
    rest = {key: value for key, value in table.items() if key != "targets"} if isinstance(table, dict) else table
    known = {each.name for each in fields(settings.Follow)}
    if isinstance(rest, dict) and rest.keys() - known:
        raise ValueError(f"{name}.{min(rest.keys() - known)} is not known; {name} has targets and reliability")
    reliability = rest.get("reliability", "best_effort") if isinstance(rest, dict) else None
    if not isinstance(reliability, str):
        raise ValueError(f"{name} must be a table with a table {name}.targets")
    _check_choice(f"{name}.reliability", reliability, _RELIABILITIES)
    targets = _named(f"{name}.targets", table.get("targets", {}), MOST)
    if not targets:
        raise ValueError(f'{name}.targets is missing: write under [{name}.targets] lines as visitor = "visitor_pose"')
    resolved = {key: _resolved(f"{name}.targets.{key}", topic, namespace) for key, topic in targets.items()}
    return settings.Follow(MappingProxyType(resolved), reliability)


def _places(table: Any) -> Mapping[str, Place]:
    places = {}
    for name, text in _named("places", table, _PLACES).items():
        place = read_place(text)
        if place is None:
            raise ValueError(
                f'places.{name} must be "x,y" or "x,y,th" in metres and radians, at most {_FAR:g} m away, not {text!r}'
            )
        if read_place(name) is not None:
            raise ValueError(f"places.{name} cannot be the name of a place: it is a place itself")
        places[name] = place
    return MappingProxyType(places)


def _cameras(table: Any, namespace: str) -> Mapping[str, settings.Camera]:
    if not isinstance(table, dict) or not all(isinstance(each, dict) for each in table.values()):
        raise ValueError("camera must have a table for each camera: write [camera.front]")
    if len(table) > MOST:
        raise ValueError(f"camera must have at most {MOST} tables, not {len(table)}")
    cameras = {}
    for key, each in table.items():
        name = f"camera.{key}"
        if flaw := flaw_of_name(key):
            raise ValueError(f"{name} cannot name a component: {flaw}")
        camera = read_table(settings.Camera, name, each)
        _check_choice(f"{name}.type", camera.type, settings.IMAGES)
        _check_choice(f"{name}.reliability", camera.reliability, _RELIABILITIES)
        _check_between(f"{name}.width", camera.width, 16, 8192)
        _check_between(f"{name}.height", camera.height, 16, 8192)
        _check_between(f"{name}.frame_rate", camera.frame_rate, 0.1, 120.0)
        cameras[key] = replace(camera, topic=_required(f"{name}.topic", camera.topic, namespace))
    return MappingProxyType(cameras)


def _speech(name: str, table: Any, namespace: str) -> settings.Speech:
    speech = read_table(settings.Speech, name, table)
    if bool(speech.topic) is bool(speech.service):
        raise ValueError(f"{name} must have a topic or a service that takes texts, and not both")
    found = _INTERFACE.fullmatch(speech.type)
    kind = "msg" if speech.topic else "srv"
    if found is None or found[1] != kind:
        raise ValueError(f"{name}.type must be package/{kind}/Name, not {speech.type!r}")
    if speech.service and speech.speaking:
        raise ValueError(f"{name}.speaking is for a topic: a service answers when the text has been spoken")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", speech.text):
        raise ValueError(f"{name}.text must be the name of a field, not {speech.text!r}")
    if not re.fullmatch(r"[a-z]{2,3}( *, *[a-z]{2,3})*", speech.languages):
        raise ValueError(f'{name}.languages must be codes as "en, ja", not {speech.languages!r}')
    names = {key: getattr(speech, key) for key in ("topic", "service", "speaking", "hush")}
    return replace(
        speech, **{key: _resolved(f"{name}.{key}", value, namespace) for key, value in names.items() if value}
    )


def _check_parts(mapping: RobotMapping) -> None:
    """Check what one part needs of another."""
    if not any((mapping.odometry, mapping.velocity, mapping.navigation, mapping.cameras, mapping.speech)):
        raise ValueError("no part of the robot is named: write at least [odometry], or [camera.front]")
    for name in ("velocity", "navigation", "pose", "follow", "battery"):
        if getattr(mapping, name) is not None and mapping.odometry is None:
            raise ValueError(f"[{name}] needs [odometry]: a robot that moves has to show that it is there")
    if mapping.follow is not None and mapping.navigation is None:
        raise ValueError("[follow] needs [navigation], which takes the robot after its target")
    dock = "" if mapping.navigation is None else mapping.navigation.dock
    if dock and dock not in mapping.places:
        raise ValueError(f"navigation.dock is {dock!r}, which [places] does not have")


def _check_types(mapping: RobotMapping) -> None:
    """Check that each topic has one type, as ROS has it."""
    known: dict[str, tuple[str, str]] = {}
    for key, topic, type_name in _topics(mapping):
        first, first_type = known.setdefault(topic, (key, type_name))
        if first_type != type_name:
            raise ValueError(
                f"{key} is {topic} as {type_name}, and {first} is the same topic as {first_type}: a topic has one type"
            )


def _topics(mapping: RobotMapping) -> Iterator[tuple[str, str, str]]:
    """Yield each topic with its key before it and its type after it."""
    for name in ("pose", "velocity", "speech"):
        part = getattr(mapping, name)
        if part is not None and part.topic:
            yield f"{name}.topic", part.topic, part.type
    for name, camera in mapping.cameras.items():
        yield f"camera.{name}.topic", camera.topic, camera.type
    for name, key, type_name in _TYPES:
        if topic := getattr(getattr(mapping, name), key, ""):
            yield f"{name}.{key}", topic, type_name
    for name, topic in (mapping.follow or settings.Follow()).targets.items():
        yield f"follow.targets.{name}", topic, settings.TARGET


def _named(name: str, table: Any, most: int) -> Mapping[str, str]:
    if not isinstance(table, dict):
        raise ValueError(f"{name} must be a table")
    if len(table) > most:
        raise ValueError(f"{name} must have at most {most} keys, not {len(table)}")
    for key, value in table.items():
        if not isinstance(value, str):
            raise ValueError(f"{name}.{key} must be a text, not {value!r}")
    return table


def _required(key: str, name: str, namespace: str) -> str:
    if not name:
        raise ValueError(f"{key} is missing: write the name that the robot has for it, as `ros2` lists it")
    return _resolved(key, name, namespace)


def _resolved(key: str, name: str, namespace: str) -> str:
    try:
        return resolve_name(name, namespace)
    except ValueError as error:
        raise ValueError(f"{key}: {error}") from None


def _check_choice(key: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise ValueError(f"{key} must be one of {', '.join(choices)}, not {value!r}")


def _check_between(key: str, value: float, least: float, most: float) -> None:
    if not least <= value <= most:
        raise ValueError(f"{key} must be between {least:g} and {most:g}, not {value:g}")
