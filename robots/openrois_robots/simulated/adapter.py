"""The adapter of the simulated robot: one engine with its components and its streams."""

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

from openrois_body.body import Body
from openrois_body.camera_senses import camera_senses
from openrois_body.components.dialogue import Dialogue
from openrois_body.components.follow import Follow
from openrois_body.components.gaze import Gaze
from openrois_body.components.move import Move
from openrois_body.components.moving import Figure
from openrois_body.components.persons import PersonDetection, PersonLocalization
from openrois_body.components.speech_stream import SpeechStream
from openrois_body.components.speech_synthesis import SpeechSynthesis
from openrois_body.components.surroundings import Surroundings
from openrois_body.components.teleoperation import Teleoperation
from openrois_body.messages import Event
from openrois_body.metrics import body_figures
from openrois_body.motion.legs import Legs
from openrois_body.motion.wayfinding import Ways
from openrois_body.motion.world import World
from openrois_body.sensing.changes import Place
from openrois_body.sensing.figures import SenseFigures
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.speech_control import SpeechControl
from openrois_body.speech.voice import Voice
from openrois_body.teleoperation.figure_controls import FigureControls
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_body.vision.box import place_on_floor
from openrois_media import AudioSource, NetworkSettings, VideoSource
from openrois_media.components import AudioStreaming, VideoStreaming
from openrois_media.devices import Camera
from openrois_media.metrics.figures import FigureGroup
from openrois_media.streams import AdapterStreams
from openrois_streaming.clock import MediaClock

from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois.types.codes import ComponentStatus, ErrorType
from openrois.types.references import reference
from openrois_robots.adapter.hosting import RunningRobot, hosted_with_streams
from openrois_robots.components.system_information import Pose, SystemInformation
from openrois_robots.simulated.battery import Battery
from openrois_robots.simulated.camera import FRAME_RATE, SIZE, RobotCamera
from openrois_robots.simulated.components.dock import Dock
from openrois_robots.simulated.components.navigation import Navigation
from openrois_robots.simulated.simulation import Simulation, SimulationSettings
from openrois_robots.simulated.world.plan import APARTMENT, Plan

__all__ = ["AUDIO", "VIDEO", "Robot", "hosted_robot", "simulated_robot"]

VIDEO: Final = VideoStreaming.component_type.name
AUDIO: Final = AudioStreaming.component_type.name
"""The names of the streaming components."""

_FRAME: Final = "map"
"""The frame of coordinates of its floor plan."""


@dataclass(frozen=True, slots=True)
class Robot:
    """A running simulated robot: its components, and the sources of its streams.

    Attributes:
        components: all but those of the streams.
        camera: its pictures.
        sound: its voice.
        operator_control: which application operates it by hand.
        speech_control: which application speaks by sound.
        simulation: of the robot and its rooms.
        voice: speaks.
        senses: figures of its senses, by their names.
    """

    components: tuple[Component, ...]
    camera: RobotCamera
    sound: BodySound
    operator_control: OperatorControl
    speech_control: SpeechControl
    simulation: Simulation
    voice: Voice
    senses: Mapping[str, SenseFigures]

    def can_drive(self) -> bool:
        """Return whether its battery is not empty."""
        return not self.simulation.battery.is_empty


@asynccontextmanager
async def simulated_robot(
    engine_id: str, settings: SimulationSettings, clock: MediaClock, plan: Plan = APARTMENT
) -> AsyncIterator[Robot]:
    """Simulate a robot for as long as the block runs.

    Args:
        engine_id: leads every ref.
        settings: what is simulated.
        clock: the media clock.
        plan: of its rooms.
    """
    async with AsyncExitStack() as stack:
        world = World(engine_id)

        # Simulation and body need each other: events go to parts that are made after it.
        def told(event: Event) -> None:
            for handle in (world.handle_event, legs.handle_event, body.handle_event):
                handle(event)

        simulation = Simulation(plan, settings, clock, told)
        body = Body(simulation.send)
        legs = Legs(simulation.send, lambda: True, lambda: world.place, clock, settings.base.speed)
        simulation.begin()

        def status() -> ComponentStatus:
            return ComponentStatus.ERROR if simulation.battery.is_empty else ComponentStatus.READY

        def problem() -> str:
            return simulation.battery.refusal if simulation.battery.is_empty else ""

        def pose() -> Pose:
            at = simulation.place
            return Pose(at.x, at.y, at.th, _FRAME, datetime.fromtimestamp(clock.wall(), UTC))

        sound = BodySound(clock)
        voice = Voice(await stack.enter_async_context(settings.voice.make(clock)), sound, body)
        camera = await stack.enter_async_context(RobotCamera(plan, simulation.view, clock))
        eye = Camera()
        eye.inlet.plug("own camera", camera)

        def locate(seen: Place, moment: float) -> Place | None:
            view = camera.view_at(moment)
            if view is None:
                return None
            at = view.camera
            return place_on_floor(seen, Place(at.x, at.y, at.th), view.tilt)

        senses = camera_senses(engine_id, eye, clock, locate=locate)
        # What else can be sensed with a camera is for the face of an operator before it.
        sensing = tuple(each for each in senses.components if isinstance(each, PersonDetection | PersonLocalization))
        tasks = await stack.enter_async_context(TaskScope())
        speech_control = SpeechControl(reference(engine_id, SpeechStream.component_type.name), voice, clock, tasks)
        operator_control = OperatorControl(
            reference(engine_id, Teleoperation.component_type.name),
            clock,
            reference(engine_id, Gaze.component_type.name),
        )
        figure = Figure(legs, world, Ways(world), status)
        controls = FigureControls(legs, body, simulation.send, lambda: False)
        moving = (
            Navigation(figure, simulation.battery, plan.mat),
            Move(figure),
            Follow(figure),
            Teleoperation(operator_control, controls, status, clock),
        )
        _report_empty(simulation, moving)
        components = (
            SystemInformation(engine_id, status, problem, pose, simulation.battery),
            *moving,
            Gaze(body, status),
            SpeechSynthesis(voice),
            Dialogue(),
            SpeechStream(speech_control),
            Surroundings(world, clock, status),
            Dock(simulation),
            *sensing,
        )
        tasks.start(simulation.run())
        tasks.start(senses.run())
        figures = {"vision": senses.watch.figures}
        yield Robot(components, camera, sound, operator_control, speech_control, simulation, voice, figures)


def _report_empty(simulation: Simulation, moving: Sequence[Component]) -> None:
    """Report to the applications that have bound what moves when the battery is used up."""
    was_empty = simulation.battery.is_empty

    def note(battery: Battery) -> None:
        nonlocal was_empty
        if battery.is_empty and not was_empty:
            for component in moving:
                component.report(ErrorType.COMPONENT_INTERNAL_ERROR, battery.refusal)
        was_empty = battery.is_empty

    simulation.battery_changed.add(note)


@asynccontextmanager
async def hosted_robot(
    engine_id: str,
    robot: Robot,
    clock: MediaClock,
    network: NetworkSettings | None = None,
    added: Sequence[type[Component]] = (),
) -> AsyncIterator[RunningRobot]:
    """Make an engine of a robot: its components, and the streams of its camera and its voice.

    Args:
        engine_id: leads every ref.
        robot: that was made with this engine_id and clock.
        clock: the media clock.
        network: how the streams use the network.
        added: the classes of components that the user adds.

    Raises:
        BadParameter: `engine_id` cannot be part of a reference.
        UnsupportedLibrary: the installed version of aiortc is not supported.
    """
    streams = AdapterStreams(
        engine_id,
        {
            VIDEO: VideoSource(robot.camera, size=SIZE, frame_rate=FRAME_RATE, clock=clock),
            AUDIO: AudioSource(robot.sound, clock=clock),
        },
        clock=clock,
        network=network,
        operator=robot.operator_control,
        speech=robot.speech_control,
    )
    robot.voice.playout_delay.observe_sessions(streams.interface.sessions, reference(engine_id, AUDIO))
    requirements = {"the robot: its battery is empty": robot.can_drive}

    def figures() -> tuple[FigureGroup, ...]:
        speech = robot.speech_control
        return body_figures(robot.senses, robot.operator_control.figures, speech.figures, speech.outcomes)

    async with hosted_with_streams(
        engine_id, robot.components, streams, figures, requirements, clock, added, robot.voice
    ) as running:
        yield running
