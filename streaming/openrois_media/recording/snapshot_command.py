"""`openrois snapshot`: one picture of a body into a JPEG file."""

import argparse
import asyncio
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from openrois.cli.command_line import CommandLine
from openrois.client import RoISError, RpcError
from openrois_media.client.media import Media
from openrois_media.recording.choice import (
    FAILURES,
    add_common_options,
    chosen_components,
    client_of,
    read_common_options,
)

__all__ = ["main"]

_ENDINGS: Final = (".jpg", ".jpeg")


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status.

    Returns:
        0 when there is a picture, 1 when there could be none, 2 for wrong usage.
    """
    parser = CommandLine(
        "openrois snapshot",
        description="Writes one picture of a body into a JPEG file, captured a second ago at most.",
    )
    add_common_options(parser)
    chosen = parser.parse_args(arguments)
    if chosen.file.suffix.lower() not in _ENDINGS:
        parser.error(f"{chosen.file.name!r} has no ending of a snapshot: use one of {', '.join(_ENDINGS)}")
    read_common_options(parser, chosen)
    try:
        asyncio.run(_snapshot(chosen))
    except (RoISError, RpcError, *FAILURES) as error:
        print(f"openrois snapshot: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0


async def _snapshot(chosen: argparse.Namespace) -> None:
    async with client_of(chosen) as client, Media(client) as media:
        components = await chosen_components(client, ("video",), chosen.body, chosen.component)
        _write(chosen.file, await media.snapshot(components["video"]))
    print(f"openrois snapshot: {components['video']} into {chosen.file}", file=sys.stderr)


def _write(path: Path, data: bytes) -> None:
    """Write a file that appears when it is complete."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_bytes(data)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
