"""Options of the commands that record: the gateway, the components, the file."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from openrois_signaling.messages import MediaKind

from openrois.catalog.component_type import ComponentType
from openrois.cli.command_line import CommandLine
from openrois.client import BadParameter, Client, Unsupported
from openrois.client.components import AudioStreaming, VideoStreaming
from openrois.transport.address import gateway_url
from openrois.transport.credential_options import add_credential_options, credentials
from openrois.types.codes import ComponentFunction, Purpose
from openrois.types.references import engine_of
from openrois_media.client.media import Media
from openrois_media.client.visitors import VisitorDevice

__all__ = [
    "FAILURES",
    "add_common_options",
    "chosen_components",
    "client_of",
    "read_common_options",
    "visitor_devices",
]

FAILURES: Final = (ConnectionError, OSError, TimeoutError, ValueError, RuntimeError)
"""What a recording can fail with, beside errors of RoIS; the text says what is wrong."""

_KINDS: Final[dict[MediaKind, type[VideoStreaming] | type[AudioStreaming]]] = {
    "video": VideoStreaming,
    "audio": AudioStreaming,
}
_WORDS: Final[dict[MediaKind, str]] = {"video": "pictures", "audio": "sound"}

_VISITORS: Final = ComponentType(
    "Visitors", "visitors", "Who sends to a body.", "", ComponentFunction.SENSING, authority="OpenRoIS"
)
"""The type of components that tell who visits a body."""


def add_common_options(parser: CommandLine) -> None:
    """Add the file, `--gateway`, `--body`, `--component`, `--force` and the credentials."""
    parser.add_argument("file", type=Path, metavar="FILE", help="where to")
    parser.add_argument("--gateway", default="ws://127.0.0.1:8765/", metavar="URL", help="the gateway (%(default)s)")
    parser.add_argument("--body", metavar="ID", help="the engine whose streams these are, where there are several")
    parser.add_argument(
        "--component",
        action="append",
        default=[],
        metavar="REF",
        help="a component with a stream; may be given once for pictures and once for sound",
    )
    parser.add_argument("--force", action="store_true", help="overwrite FILE")
    add_credential_options(parser)


def read_common_options(parser: CommandLine, chosen: argparse.Namespace) -> None:
    """Check the common options; a mistake ends the program with a sentence."""
    path: Path = chosen.file
    try:
        chosen.gateway = gateway_url(chosen.gateway)
    except ValueError as error:
        parser.error(f"--gateway: {error}")
    if not path.parent.is_dir():
        parser.error(f"there is no folder {path.parent}: make it, or choose another")
    if path.is_dir():
        parser.error(f"{path} is a folder: name a file in it")
    if path.exists() and not chosen.force:
        parser.error(f"{path} is there already: choose another name, or overwrite it with --force")


def client_of(chosen: argparse.Namespace) -> Client:
    """Return a client of the gateway."""
    shown = credentials(chosen)
    return Client(chosen.gateway, token=shown.token, ca_file=shown.ca_file)


async def chosen_components(
    client: Client, kinds: Sequence[MediaKind], body: str | None, named: Sequence[str]
) -> dict[MediaKind, str]:
    """Return the component of each kind: those that are named, or the only ones of a body.

    Args:
        client: connected to the gateway.
        kinds: what is wanted; what a body lacks is left out.
        body: id of its engine; None for the only one that has any.
        named: references of components, which are then the only ones.

    Raises:
        Unsupported: there is none.
        BadParameter: there are several of a kind, or one that is named is of no kind that is wanted.
    """
    found: dict[MediaKind, str] = {}
    for kind in kinds:
        refs = [each.component_ref for each in await client.find_all(_KINDS[kind])]
        refs = [ref for ref in refs if (ref in named if named else body in (None, engine_of(ref)))]
        if len(refs) > 1:
            raise BadParameter(
                f"several components have {_WORDS[kind]}: choose one with --component, of {', '.join(refs)}"
            )
        if refs:
            found[kind] = refs[0]
    wanted = " or ".join(_WORDS[kind] for kind in kinds)
    unused = sorted(set(named) - set(found.values()))
    if unused:
        raise BadParameter(f"{unused[0]} is no component with {wanted}")
    if not named and len({engine_of(ref) for ref in found.values()}) > 1:
        raise BadParameter(f"several bodies have {wanted}: choose one with --body, of {_bodies(found)}")
    if not found:
        raise Unsupported(f"no component{f' of {body}' if body else ''} has {wanted}")
    return found


async def visitor_devices(
    client: Client, media: Media, kinds: Sequence[MediaKind], body: str | None, visitor_ref: str
) -> dict[MediaKind, VisitorDevice]:
    """Return microphone and camera of a visitor, for recording: those that it sends now.

    Args:
        client: connected to the gateway.
        media: open media of it.
        kinds: what is wanted; what the visitor does not send is left out.
        body: id of the engine that it visits; None for any.
        visitor_ref: its name.

    Raises:
        Unsupported: there is no such visitor, or it sends nothing of that.
    """
    bodies = {engine_of(each.component_ref) for each in await client.find_all(_VISITORS)}
    present = [
        visitor
        for engine_id in sorted(bodies if body is None else bodies & {body})
        for visitor in await media.visitors(engine_id, purposes=[Purpose.RECORDING])
    ]
    found = next((each for each in present if each.visitor_ref == visitor_ref), None)
    where = f" of {body}" if body else ""
    if found is None:
        known = ", ".join(f"{each.visitor_ref} ({' and '.join(sorted(each.devices))})" for each in present)
        raise Unsupported(f"there is no visitor {visitor_ref[:200]!r}{where}; there are: {known or 'none'}")
    own: dict[MediaKind, VisitorDevice] = {"video": found.camera, "audio": found.microphone}
    devices = {kind: own[kind] for kind in kinds if own[kind].name in found.devices}
    if not devices:
        wanted = " or ".join(_WORDS[kind] for kind in kinds)
        raise Unsupported(f"{visitor_ref} sends no {wanted}")
    return devices


def _bodies(found: dict[MediaKind, str]) -> str:
    return ", ".join(sorted({engine_of(ref) for ref in found.values()}))
