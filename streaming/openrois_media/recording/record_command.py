"""`openrois record`: a body's pictures and sound into a file."""

import argparse
import asyncio
import contextlib
import signal
import sys
from collections.abc import Mapping, Sequence

from openrois_signaling.messages import MediaKind
from openrois_streaming.recording.media_file import MediaFile, UnknownEnding, has_pictures

from openrois.cli.command_line import CommandLine
from openrois.client import RoISError, RpcError
from openrois_media.client.media import Media
from openrois_media.recording.choice import (
    FAILURES,
    add_common_options,
    chosen_components,
    client_of,
    read_common_options,
    visitor_devices,
)
from openrois_media.recording.recorder import Recorded, record

__all__ = ["main"]

_EPILOG = """\
The ending of FILE chooses the container: .mp4 (H.264 and AAC), .webm (VP8 and Opus), or .wav for sound alone. Ctrl-C
ends the recording. FILE appears when it is complete. Pictures and sound stand at the times at which they were captured.
Recording a visitor needs the role listener and its consent to be recorded, and ends when it withdraws that, or leaves.
"""


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status.

    Returns:
        0 when something was recorded, 1 when it could not be, 2 for wrong usage.
    """
    parser = CommandLine(
        "openrois record",
        description="Records the pictures and the sound of a body.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_common_options(parser)
    parser.add_argument(
        "--seconds", type=_length, metavar="N", help="how long, from the first media on; until Ctrl-C unless given"
    )
    parser.add_argument("--visitor", default="", metavar="REF", help="record what this visitor sends (its visitor_ref)")
    chosen = parser.parse_args(arguments)
    if chosen.visitor and chosen.component:
        parser.error("--visitor is recorded from the body that it visits: leave out --component")
    try:
        has_pictures(chosen.file)
    except UnknownEnding as error:
        parser.error(str(error))
    read_common_options(parser, chosen)
    try:
        asyncio.run(_record(chosen))
    except (RoISError, RpcError, *FAILURES) as error:
        print(f"openrois record: {error}", file=sys.stderr)
        return 1
    return 0


async def _record(chosen: argparse.Namespace) -> None:
    stop, by_hand = asyncio.Event(), asyncio.Event()

    def end() -> None:
        by_hand.set()
        stop.set()

    # Before Python 3.12 `asyncio.run` alone would cancel the recording, and leave no file.
    with contextlib.suppress(NotImplementedError):
        for name in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(name, end)
    async with client_of(chosen) as client, Media(client) as media:
        kinds: tuple[MediaKind, ...] = ("video", "audio") if has_pictures(chosen.file) else ("audio",)
        components: Mapping[MediaKind, Recorded]
        if chosen.visitor:
            devices = await visitor_devices(client, media, kinds, chosen.body, chosen.visitor)
            names = [f"{each.name} of {chosen.visitor}" for each in devices.values()]
            components = devices
        else:
            components = refs = await chosen_components(client, kinds, chosen.body, chosen.component)
            names = list(refs.values())
        _say(f"{' and '.join(names)} into {chosen.file}; Ctrl-C ends it")
        with MediaFile(chosen.file, video="video" in components, audio="audio" in components) as file:
            await record(media, components, file, chosen.seconds, stop, lambda: _say("recording"))
        if stop.is_set() and not by_hand.is_set():
            _say("the visitor has left, or does not consent to be recorded any more")
        _say(f"{chosen.file} has {file.seconds:.1f} s")


def _length(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0 < seconds < float("inf"):
        raise argparse.ArgumentTypeError(f"must be more than 0 seconds, not {text[:40]}")
    return seconds


def _say(text: str) -> None:
    print(f"openrois record: {text}", file=sys.stderr, flush=True)
