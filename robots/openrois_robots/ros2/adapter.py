"""The adapter of a robot that speaks ROS 2: its components and its streams, as its mapping file has them."""

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Final

from openrois_body.metrics import body_figures
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_media import NetworkSettings, VideoSource
from openrois_media.channel_sinks import NoSpeech
from openrois_media.metrics.figures import FigureGroup
from openrois_media.streams import AdapterStreams
from openrois_streaming.clock import MediaClock

from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois.errors import BadParameter
from openrois.types.references import reference
from openrois_robots.adapter.hosting import RunningRobot, hosted_with_streams
from openrois_robots.adapter.link import RobotLink, report_losses
from openrois_robots.adapter.metrics import link_figures
from openrois_robots.components.system_information import SystemInformation
from openrois_robots.ros2.components.follow import Follow
from openrois_robots.ros2.components.move import Move
from openrois_robots.ros2.components.navigation import Navigation
from openrois_robots.ros2.components.speech_synthesis import SpeechSynthesis
from openrois_robots.ros2.components.teleoperation import RobotControls, Teleoperation
from openrois_robots.ros2.graph.backend import Matched, Publisher, RosBackend, ServiceClient
from openrois_robots.ros2.graph.matching import Qos
from openrois_robots.ros2.interfaces.definitions import DefinitionError
from openrois_robots.ros2.mapping.settings import HUSH, SPEAKING, RobotMapping
from openrois_robots.ros2.parts import Parts
from openrois_robots.ros2.robot.pictures import camera_source

__all__ = ["Robot", "hosted_robot", "ros_robot"]

_NO_SOUND: Final = (
    "a robot that speaks ROS 2 takes texts and no sound, for which its nodes agree on no topic: "
    "use its speech_synthesizer where it has that"
)


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot behind its mapping.

    Attributes:
        components: all but those of its streams.
        cameras: the sources of its streams, by the names of their components.
        operator_control: which application operates it by hand.
        link: to the robot.
    """

    components: tuple[Component, ...]
    cameras: Mapping[str, VideoSource]
    operator_control: OperatorControl
    link: RobotLink


@asynccontextmanager
async def ros_robot(
    engine_id: str, mapping: RobotMapping, backend: RosBackend, clock: MediaClock, robot: str
) -> AsyncIterator[Robot]:
    """Connect a robot for as long as the block runs.

    Args:
        engine_id: leads every ref.
        mapping: of the robot.
        backend: its graph, which has been entered.
        clock: the media clock.
        robot: what is linked, for sentences: `the robot in ROS domain 0`.

    Raises:
        BadParameter: a type of the mapping is not known.
    """
    try:
        parts = Parts(engine_id, mapping, backend, clock, robot)
        operator_control = OperatorControl(reference(engine_id, Teleoperation.component_type.name), clock)
        moving = _moving(parts, operator_control)
        speech = _speech(parts)
        cameras = {name: camera_source(backend, name, camera, clock) for name, camera in mapping.cameras.items()}
    except DefinitionError as error:
        raise BadParameter(str(error)) from None
    link = parts.link
    state = parts.pose or (None if parts.odometry is None else parts.odometry.pose)
    pose = (lambda: None) if state is None else state.pose
    information = SystemInformation(
        engine_id, lambda: link.status, lambda: link.problem, pose, parts.battery, clock.wall
    )
    report_losses(link, moving)
    async with TaskScope() as tasks:
        tasks.start(link.run())
        for part in (parts.wheels, parts.goals):
            if part is not None:
                tasks.start(part.run())
        yield Robot((information, *moving, *speech), cameras, operator_control, link)


@asynccontextmanager
async def hosted_robot(
    engine_id: str,
    robot: Robot,
    clock: MediaClock,
    network: NetworkSettings | None = None,
    added: Sequence[type[Component]] = (),
) -> AsyncIterator[RunningRobot]:
    """Make an engine of a robot: its components, and the streams of its cameras.

    Args:
        engine_id: leads every ref.
        robot: that was made with this engine_id and clock.
        clock: the media clock.
        network: how the streams use the network.
        added: the classes of components that the user adds.

    Raises:
        BadParameter: `engine_id` or the name of a camera cannot be part of a reference, or is that of a component.
        UnsupportedLibrary: the installed version of aiortc is not supported.
    """
    streams = AdapterStreams(
        engine_id,
        dict(robot.cameras),
        clock=clock,
        network=network,
        operator=robot.operator_control,
        speech=NoSpeech(_NO_SOUND),
    )
    requirements = {"the robot: it is not linked": lambda: robot.link.is_up}

    def figures() -> tuple[FigureGroup, ...]:
        return (*body_figures({}, robot.operator_control.figures), link_figures(robot.link))

    async with hosted_with_streams(
        engine_id, robot.components, streams, figures, requirements, clock, added
    ) as running:
        yield running


def _moving(parts: Parts, operator_control: OperatorControl) -> tuple[Component, ...]:
    """Return the components that move the robot."""
    mapping, made = parts.mapping, list[Component]()
    if parts.goals is not None:
        made.append(Navigation(parts.figure, parts.goals, parts.goal_ends(), parts.battery))
        if mapping.follow is not None:
            targets = parts.pose_states(mapping.follow.targets, mapping.follow.reliability)
            made.append(Follow(parts.figure, parts.goals, targets, parts.goal_ends(), parts.battery))
    velocity = mapping.velocity
    if velocity is not None and parts.wheels is not None:
        if velocity.move:
            made.append(Move(parts.figure, parts.wheels, parts.velocity_ends(), parts.battery))
        if velocity.teleoperation and mapping.cameras:
            controls = RobotControls(parts.legs)
            made.append(Teleoperation(operator_control, controls, parts.velocity_ends(), parts.clock))
    return tuple(made)


def _speech(parts: Parts) -> tuple[Component, ...]:
    """Return the component that speaks, where the robot does."""
    settings, backend = parts.mapping.speech, parts.backend
    if settings is None:
        return ()
    mouth: Publisher | ServiceClient
    if settings.topic:
        mouth = backend.publisher(settings.topic, settings.type, Qos())
    else:
        mouth = backend.service(settings.service, settings.type)
    ends: list[Matched] = [mouth]
    speech: list[SpeechSynthesis] = []

    def take(message: object) -> None:
        speech[0].take_speaking(message)

    if settings.speaking:
        ends.append(backend.subscribe(settings.speaking, SPEAKING, Qos(), take))
    hush = backend.publisher(settings.hush, HUSH, Qos()) if settings.hush else None
    speech.append(SpeechSynthesis(settings, mouth, hush, parts.ends(*ends), parts.clock))
    return tuple(speech)
