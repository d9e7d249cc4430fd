"""The engine of a robot: its components and its streams, with what is measured of them."""

from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from openrois_body.host_body import HostBody
from openrois_body.speech.speaker import Speaker
from openrois_media.metrics.figures import FigureGroup, Snapshot
from openrois_media.streams import AdapterStreams
from openrois_streaming.clock import MediaClock

from openrois.adapter.loading import make_components
from openrois.adapter.running import hosted
from openrois.component.component import Component
from openrois.session.session import EngineHost

__all__ = ["RunningRobot", "hosted_with_streams"]


@dataclass(frozen=True, slots=True)
class RunningRobot:
    """A robot whose adapter runs.

    Attributes:
        host: the engine that is served to the gateway.
        collect_figures: takes a snapshot of all metrics.
        requirements: what `/readyz` requires beside the gateway: `the robot: it does not answer`, and whether it holds.
    """

    host: EngineHost
    collect_figures: Callable[[], Awaitable[Snapshot]]
    requirements: Mapping[str, Callable[[], bool]] = field(default_factory=dict)


@asynccontextmanager
async def hosted_with_streams(
    engine_id: str,
    components: Iterable[Component],
    streams: AdapterStreams,
    figures: Callable[[], tuple[FigureGroup, ...]],
    requirements: Mapping[str, Callable[[], bool]],
    clock: MediaClock,
    added: Sequence[type[Component]] = (),
    voice: Speaker | None = None,
) -> AsyncIterator[RunningRobot]:
    """Make an engine of components and streams, for as long as the block runs.

    Args:
        engine_id: leads every ref.
        components: all but those of the streams.
        streams: which have not been entered.
        figures: returns what is measured of the robot beside its streams.
        requirements: what `/readyz` requires beside the gateway.
        clock: the media clock.
        added: the classes of components that the user adds.
        voice: speaks, where that is a voice of ours; for added components.

    Raises:
        BadParameter: `engine_id` cannot be part of a reference, two components have one name, or one of the user's
            cannot be made.
        UnsupportedLibrary: the installed version of aiortc is not supported.
    """
    own = (*components, *streams.components.values())
    parts = (*own, *make_components(added, HostBody(engine_id, clock, own, voice), own))
    async with streams as interface, hosted(engine_id, *parts, extension=interface) as host:
        yield RunningRobot(host, streams.collector(figures).snapshot, requirements)
