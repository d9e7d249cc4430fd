"""`openrois profile`: profiles as the XML of the standard or the JSON of the wire, written and read."""

import argparse
import asyncio
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.cli.command_line import CommandLine
from openrois.profiles.files import documents_in, json_text, plain, profile_files, write_set
from openrois.profiles.query import NoProfile, ask_profiles
from openrois.profiles.xml.documents import assemble, doubts, write_documents
from openrois.profiles.xml.read import ComponentDocument, EngineDocument
from openrois.profiles.xml.write import component_xml, engine_xml
from openrois.transport.credential_options import add_credential_options, credentials
from openrois.types.messages import ProfileResult
from openrois.types.profiles import HRIComponentProfile

__all__ = ["main"]

_URL: Final = "ws://127.0.0.1:8765/"
_TYPES: Final = {kind.code: kind for kind in (*BASIC_COMPONENTS, ROIS_COMMON)}


class _Failed(Exception):
    """The command ends with exit status 1 and this sentence."""


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status.

    That is 0 when done, 1 when something is wrong, 2 for wrong usage, and 130 where Ctrl-C ended it.
    """
    chosen = _parser().parse_args(arguments)
    try:
        if chosen.action == "export":
            _export(chosen)
        else:
            _import(chosen)
    except (_Failed, NoProfile, ValueError) as error:
        _say(str(error))
        return 1
    except BrokenPipeError:
        # The reader of a pipe has closed it. What is left to be flushed when Python ends has to go somewhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        _say(f"{error.filename}: {error.strerror}" if error.filename else error.strerror or str(error))
        return 1
    except KeyboardInterrupt:
        return 130
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = CommandLine(
        "openrois profile",
        description="Profiles of RoIS engines and components, as the standard's XML or as the JSON of the wire.",
    )
    actions = parser.add_subparsers(dest="action", required=True, metavar="export|import")
    export = actions.add_parser(
        "export",
        help="write profiles of a running gateway, or of a type of the standard",
        description="Writes the profiles of all that a running gateway knows, of one component, or of a type. As XML "
        "that is one document for the engine and one for each component; without --output the engine's is printed.",
    )
    export.add_argument("--url", default=_URL, help="the gateway (%(default)s)")
    add_credential_options(export)
    which = export.add_mutually_exclusive_group()
    which.add_argument("--component", metavar="REF", help="one component, such as robot/navigation")
    which.add_argument(
        "--type", choices=_TYPES, metavar="TYPE", help=f"a type of the standard: {', '.join(_TYPES)}; asks no gateway"
    )
    export.add_argument("--format", choices=("xml", "json"), default="xml", help="what is written (%(default)s)")
    export.add_argument(
        "--output", type=Path, metavar="PATH", help="a file, or for all profiles as XML an empty or new directory"
    )
    imported = actions.add_parser(
        "import",
        help="check profiles in XML or JSON and print the JSON of the wire",
        description="Reads profiles, says what is wrong with them, and prints them as the JSON of the wire: one "
        "component alone as its profile, an engine with its components as the answer of get_profile.",
    )
    imported.add_argument("paths", nargs="+", type=Path, metavar="PATH", help="an XML or JSON file, or a directory")
    imported.add_argument("--output", type=Path, metavar="FILE", help="where to write the JSON, instead of printing it")
    return parser


def _export(chosen: argparse.Namespace) -> None:
    if chosen.type is not None:
        _put(_component_text(_TYPES[chosen.type].definition(), "", chosen.format), chosen.output)
        return
    result = asyncio.run(ask_profiles(chosen.url, chosen.component or "", credentials=credentials(chosen)))
    if chosen.component:
        profile = result.component_profiles[chosen.component]
        _put(_component_text(profile, chosen.component, chosen.format), chosen.output)
    elif chosen.format == "json":
        _put(json_text(result.model_dump(mode="json", exclude={"return_code"})), chosen.output)
    else:
        _export_all(result, chosen.output)


def _component_text(profile: HRIComponentProfile, component_ref: str, chosen_format: str) -> str:
    return component_xml(profile, component_ref) if chosen_format == "xml" else json_text(profile)


def _export_all(result: ProfileResult, output: Path | None) -> None:
    if result.profile is None:
        raise _Failed("the gateway has no profile of its own")
    if output is not None:
        write_set(output, write_documents(result.profile, result.component_profiles))
        return
    _put(engine_xml(result.profile), None)
    if result.component_profiles:
        count = len(result.component_profiles)
        _say(f"this is the engine's profile; --output DIRECTORY writes those of its {count} components too")


def _import(chosen: argparse.Namespace) -> None:
    profiles = assemble(_read_all(chosen.paths))
    text = json_text(plain(profiles))
    for doubt in doubts(profiles):
        _say(doubt)
    _put(text, chosen.output)


def _read_all(paths: Sequence[Path]) -> list[EngineDocument | ComponentDocument]:
    """Read all files, so that every error is reported at once."""
    documents: list[EngineDocument | ComponentDocument] = []
    files, wrong = 0, 0
    for path in paths:
        for file in profile_files(path):
            files += 1
            try:
                found = documents_in(file)
            except (OSError, ValueError) as error:
                wrong += 1
                _say(f"{file}: {error.strerror if isinstance(error, OSError) else error}")
                continue
            for remark in (remark for document in found for remark in document.remarks):
                _say(f"{file}: {remark}")
            documents += found
    if wrong:
        raise _Failed("nothing is imported" + (f": {wrong} of {files} files cannot be used" if files > 1 else ""))
    return documents


def _put(text: str, output: Path | None) -> None:
    if output is None:
        # UTF-8 wherever it goes: that is what the XML declaration says, and what JSON is.
        sys.stdout.buffer.write(text.encode())
        sys.stdout.buffer.flush()
    else:
        output.write_text(text, encoding="utf-8")


def _say(sentence: str) -> None:
    print(f"openrois profile: {sentence}", file=sys.stderr)
