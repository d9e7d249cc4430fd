"""The avatar at a signaling server of Pixel Streaming, with its players."""

import asyncio
from collections.abc import Callable, Sequence

from openrois_body.components.teleoperation import Teleoperation
from openrois_media.streaming_interface import StreamingInterface
from openrois_streaming.clock import MediaClock

from openrois_avatar.facades.messages.reading import Said
from openrois_avatar.options.pixel_streaming import PixelStreaming
from openrois_avatar.pixel_streaming.guests import Guests
from openrois_avatar.pixel_streaming.player import Player, Step
from openrois_avatar.pixel_streaming.streamer import Streamer
from openrois_avatar.scene import Scene

__all__ = ["serve_pixel_streaming"]


async def serve_pixel_streaming(
    settings: PixelStreaming, streams: StreamingInterface, components: Sequence[str], scene: Scene, clock: MediaClock
) -> None:
    """Serve players until cancelled.

    Args:
        settings: the signaling server, and whether players may operate.
        streams: of the avatar.
        components: the streaming components that players are sent: of the picture, and of the sound.
        scene: the avatar's scene.
        clock: the media clock.
    """
    operating = next((each for each in scene.components if isinstance(each, Teleoperation)), None)
    guests = (
        Guests(operating.operator_control, operating.pilot, clock) if operating is not None and settings.input else None
    )

    def make_player(player_id: str, say: Callable[[Said], None], later: Callable[[Step], None]) -> Player:
        return Player(player_id, streams, components, guests, say, later, clock)

    async with asyncio.TaskGroup() as group:
        if guests is not None:
            group.create_task(guests.run())
        group.create_task(Streamer(settings.url, settings.name, make_player).run())
