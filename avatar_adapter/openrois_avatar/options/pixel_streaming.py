"""Settings and options of the avatar as a streamer of Pixel Streaming. Pure."""

import argparse
from dataclasses import dataclass
from urllib.parse import urlsplit

from openrois.auth.loopback import is_loopback

__all__ = ["PixelStreaming", "add_pixel_streaming_options", "pixel_streaming"]


@dataclass(frozen=True, slots=True)
class PixelStreaming:
    """The avatar as a streamer of Pixel Streaming.

    Attributes:
        url: of the signaling server, `ws://host:port` or `wss://host:port`.
        name: the avatar's id there.
        input: whether players may operate the avatar.
    """

    url: str
    name: str
    input: bool = False


def add_pixel_streaming_options(parser: argparse.ArgumentParser) -> None:
    """Add `--pixel-streaming` and the options that belong to it."""
    group = parser.add_argument_group(
        "Pixel Streaming",
        "every client that reaches the signaling server sees and hears the avatar, without asking the gateway",
    )
    group.add_argument(
        "--pixel-streaming",
        metavar="URL",
        help="be a streamer at this signaling server, such as ws://127.0.0.1:8888, on this machine",
    )
    group.add_argument("--pixel-streaming-id", metavar="NAME", help="what the avatar is called there (the engine id)")
    group.add_argument(
        "--pixel-streaming-input",
        action="store_true",
        help="players may operate the avatar while no application has bound its teleoperation",
    )
    group.add_argument(
        "--pixel-streaming-anywhere", action="store_true", help="the signaling server may be on another machine"
    )


def pixel_streaming(chosen: argparse.Namespace) -> PixelStreaming | None:
    """Return the settings; None if the avatar is no streamer.

    Raises:
        ValueError: the address is malformed, or not on this machine; a sentence for a person.
    """
    url: str | None = chosen.pixel_streaming
    if url is None:
        return None
    try:
        parts = urlsplit(url)
        host, _ = parts.hostname, parts.port
    except ValueError:
        host = None
    if host is None or parts.scheme not in {"ws", "wss"} or parts.username is not None or parts.fragment:
        raise ValueError(
            f"--pixel-streaming: {url!r} is no address of a signaling server; write one like ws://127.0.0.1:8888"
        )
    if not chosen.pixel_streaming_anywhere and not is_loopback(host):
        raise ValueError(
            f"--pixel-streaming: {host} is not this machine, and every client that reaches it sees the avatar;"
            " --pixel-streaming-anywhere allows it"
        )
    return PixelStreaming(url, chosen.pixel_streaming_id or chosen.engine_id, chosen.pixel_streaming_input)
