"""The adapter of a Kachaka: one engine with its components, and the streams of its cameras."""

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from typing import Final

from openrois_body.camera_senses import CameraSenses, camera_senses
from openrois_body.components.persons import PersonDetection, PersonLocalization
from openrois_body.components.sight import Sight
from openrois_body.metrics import body_figures
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_media import NetworkSettings, VideoSource
from openrois_media.channel_sinks import NoSpeech
from openrois_media.components import VideoStreaming
from openrois_media.devices import Camera
from openrois_media.metrics.figures import FigureGroup
from openrois_media.streams import AdapterStreams, Stream
from openrois_streaming.clock import MediaClock

from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois.types.references import reference
from openrois_robots.adapter.hosting import RunningRobot, hosted_with_streams
from openrois_robots.adapter.link import report_losses
from openrois_robots.components.system_information import SystemInformation
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.commands import Commands
from openrois_robots.kachaka.camera import BACK, FRAME_RATE, FRONT, SIZE, RobotCamera
from openrois_robots.kachaka.components.dock import Dock
from openrois_robots.kachaka.components.emergency_stop import EmergencyStop
from openrois_robots.kachaka.components.located_persons import PersonLocalization as LocatedPersons
from openrois_robots.kachaka.components.map import Map
from openrois_robots.kachaka.components.move import Move
from openrois_robots.kachaka.components.navigation import Navigation
from openrois_robots.kachaka.components.operated import Surroundings, Teleoperation
from openrois_robots.kachaka.components.reaction import Reaction
from openrois_robots.kachaka.components.shelves import Shelves
from openrois_robots.kachaka.components.speech_synthesis import SpeechSynthesis
from openrois_robots.kachaka.detection import Detection
from openrois_robots.kachaka.driver import Driver
from openrois_robots.kachaka.ground import Ground
from openrois_robots.kachaka.metrics import kachaka_figures
from openrois_robots.kachaka.options import KachakaSettings
from openrois_robots.kachaka.persons import DetectedRefs
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["BACK_VIDEO", "VIDEO", "Robot", "hosted_kachaka", "linked_kachaka"]

VIDEO: Final = VideoStreaming.component_type.name
BACK_VIDEO: Final = f"{VIDEO}_back"
"""The names of the streaming components of the front and the back camera."""
_NO_SOUND: Final = "a Kachaka plays no sound that is sent to it, its interface takes texts: use its speech_synthesizer"


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot that is linked, or waited for: its components, and the sources of its streams.

    Attributes:
        components: all but those of the streams.
        state: what is known of it, and the link to it.
        commands: at it.
        driver: drives it by hand.
        cameras: by the names of their components.
        operator_control: which application operates it by hand.
        senses: of its front camera.
    """

    components: tuple[Component, ...]
    state: Kachaka
    commands: Commands
    driver: Driver
    cameras: Mapping[str, RobotCamera]
    operator_control: OperatorControl
    senses: CameraSenses


@asynccontextmanager
async def linked_kachaka(engine_id: str, settings: KachakaSettings, clock: MediaClock) -> AsyncIterator[Robot]:
    """Link a robot for as long as the block runs; it need not be there.

    Args:
        engine_id: leads every ref.
        settings: of the adapter.
        clock: the media clock.
    """
    async with AsyncExitStack() as stack:
        api = await stack.enter_async_context(KachakaApi(settings.address))
        state = Kachaka(api, engine_id, settings.battery, clock)
        driver = Driver(api, state.link, state.texts, settings.driving, clock)
        commands = Commands(api, state.link, state.texts, clock, driver.release)
        driver.end_motion = commands.end_motion
        front = await stack.enter_async_context(RobotCamera(api, FRONT, "front camera", clock))
        back = await stack.enter_async_context(RobotCamera(api, BACK, "back camera", clock))
        eye = Camera()
        eye.inlet.plug("own camera", front)
        senses = camera_senses(engine_id, eye, clock, camera_problem=lambda: state.link.problem)
        detection = Detection(api, state.link, clock)
        operator_control = OperatorControl(reference(engine_id, Teleoperation.component_type.name), clock)
        acting: tuple[Component, ...] = (
            Navigation(state, commands),
            Move(state, commands, settings.driving),
            Teleoperation(operator_control, driver, state, clock),
            SpeechSynthesis(state, commands, api, settings.speech),
            Reaction(state, commands, api, clock),
            Dock(state, commands),
            Shelves(state, commands, api),
        )
        report_losses(state.link, acting)
        components = (
            SystemInformation(engine_id, state.status, state.problem, lambda: state.pose, state.battery),
            *acting,
            EmergencyStop(state, api),
            Map(state, api),
            Surroundings(state, clock),
            PersonDetection(detection),
            LocatedPersons(detection, DetectedRefs(engine_id)),
            *_of_own_vision(senses),
        )
        tasks = await stack.enter_async_context(TaskScope())
        ground = Ground(state, api, clock)
        for part in (state.link, commands, driver, senses, detection, ground):
            tasks.start(part.run())
        cameras = {VIDEO: front, BACK_VIDEO: back}
        yield Robot(components, state, commands, driver, cameras, operator_control, senses)


def _of_own_vision(senses: CameraSenses) -> tuple[Component, ...]:
    """Return the senses that the robot does not have itself: of faces, gestures and enrolled persons."""
    robots = PersonDetection | PersonLocalization | Sight
    return tuple(each for each in senses.components if not isinstance(each, robots))


@asynccontextmanager
async def hosted_kachaka(
    engine_id: str,
    robot: Robot,
    clock: MediaClock,
    network: NetworkSettings | None = None,
    added: Sequence[type[Component]] = (),
) -> AsyncIterator[RunningRobot]:
    """Make an engine of a robot: its components, and the streams of its cameras.

    Args:
        engine_id: leads every ref.
        robot: that was linked with this engine_id and clock.
        clock: the media clock.
        network: how the streams use the network.
        added: the classes of components that the user adds.

    Raises:
        BadParameter: `engine_id` cannot be part of a reference.
        UnsupportedLibrary: the installed version of aiortc is not supported.
    """
    link = robot.state.link
    streams = AdapterStreams(
        engine_id,
        {
            name: Stream(VideoSource(camera, size=SIZE, frame_rate=FRAME_RATE, clock=clock), status=lambda: link.status)
            for name, camera in robot.cameras.items()
        },
        clock=clock,
        network=network,
        operator=robot.operator_control,
        speech=NoSpeech(_NO_SOUND),
    )
    cameras = {name: camera.figures for name, camera in robot.cameras.items()}
    requirements = {"the robot: it does not answer": lambda: link.is_up}

    def figures() -> tuple[FigureGroup, ...]:
        of_body = body_figures({"vision": robot.senses.watch.figures}, robot.operator_control.figures)
        return (*of_body, *kachaka_figures(link, robot.commands.figures, robot.driver.figures, cameras))

    async with hosted_with_streams(
        engine_id, robot.components, streams, figures, requirements, clock, added
    ) as running:
        yield running
