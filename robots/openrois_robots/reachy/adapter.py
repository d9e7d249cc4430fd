"""The adapter of a Reachy Mini: one engine with its components."""

from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass

from openrois_body.components.dialogue import Dialogue
from openrois_media import NetworkSettings
from openrois_media.streams import AdapterStreams
from openrois_streaming.clock import MediaClock

from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois_robots.adapter.hosting import RunningRobot, hosted_with_streams
from openrois_robots.adapter.link import report_losses
from openrois_robots.reachy.components.gaze import Gaze
from openrois_robots.reachy.components.move import Move
from openrois_robots.reachy.components.reaction import Reaction
from openrois_robots.reachy.components.sound_localization import SoundLocalization
from openrois_robots.reachy.components.speech_synthesis import SpeechSynthesis
from openrois_robots.reachy.components.system_information import SystemInformation
from openrois_robots.reachy.daemon.rest import Daemon
from openrois_robots.reachy.directions import Directions
from openrois_robots.reachy.metrics import reachy_figures
from openrois_robots.reachy.motion import Motion
from openrois_robots.reachy.options import ReachySettings
from openrois_robots.reachy.robot import Reachy
from openrois_robots.reachy.voice import RobotVoice

__all__ = ["Robot", "hosted_reachy", "linked_reachy"]


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot that is linked, or waited for.

    Attributes:
        components: all that it has.
        state: what is known of it, and the link to it.
        motion: moves it.
        voice: speaks on it.
    """

    components: tuple[Component, ...]
    state: Reachy
    motion: Motion
    voice: RobotVoice


@asynccontextmanager
async def linked_reachy(engine_id: str, settings: ReachySettings, clock: MediaClock) -> AsyncIterator[Robot]:
    """Link a robot for as long as the block runs; it need not be there.

    Args:
        engine_id: leads every ref.
        settings: of the adapter.
        clock: the media clock.
    """
    async with AsyncExitStack() as stack:
        daemon = await stack.enter_async_context(Daemon(settings.address))
        state = Reachy(daemon, clock)
        motion = Motion(state, settings.motion, clock)
        voice = RobotVoice(await stack.enter_async_context(settings.voice.make(clock)), state, clock)
        directions = Directions(state, clock)
        acting: tuple[Component, ...] = (
            Reaction(state, motion),
            Move(state, motion, settings.motion),
            SpeechSynthesis(voice, state),
            Dialogue(),
        )
        report_losses(state.link, acting)
        components = (
            SystemInformation(engine_id, state, clock),
            *acting,
            Gaze(state, motion),
            SoundLocalization(engine_id, state, directions, clock),
        )
        tasks = await stack.enter_async_context(TaskScope())
        for part in (state.socket, state.link, motion, directions):
            tasks.start(part.run())
        yield Robot(components, state, motion, voice)


@asynccontextmanager
async def hosted_reachy(
    engine_id: str,
    robot: Robot,
    clock: MediaClock,
    network: NetworkSettings | None = None,
    added: Sequence[type[Component]] = (),
) -> AsyncIterator[RunningRobot]:
    """Make an engine of a robot.

    Args:
        engine_id: leads every ref.
        robot: that was linked with this engine_id and clock.
        clock: the media clock.
        network: how streams would use the network; the robot has none yet.
        added: the classes of components that the user adds.

    Raises:
        BadParameter: `engine_id` cannot be part of a reference.
    """
    link = robot.state.link
    streams = AdapterStreams(engine_id, {}, clock=clock, network=network)
    requirements = {"the robot: it does not answer": lambda: link.is_up}
    async with hosted_with_streams(
        engine_id,
        robot.components,
        streams,
        lambda: reachy_figures(link, robot.motion.figures),
        requirements,
        clock,
        added,
        robot.voice,
    ) as running:
        yield running
