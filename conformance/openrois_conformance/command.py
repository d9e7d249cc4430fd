"""`openrois conformance`: what RoIS 2.0 and the wire require, and whether a gateway does it."""

import argparse
import asyncio
import json
import os
import shutil
import sys
from collections.abc import Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from openrois.transport.address import gateway_url
from openrois.transport.credential_options import add_credential_options, credentials
from openrois.transport.credentials import Credentials
from openrois_conformance import report, table
from openrois_conformance.checks import ALL_CHECKS
from openrois_conformance.deviation import Deviation
from openrois_conformance.manifest import Area, Requirement, read_manifest
from openrois_conformance.suite import Verdict, Visit, run_checks, visit

__all__ = ["main"]

_EPILOG = """\
Without --url the manifest is printed: every requirement with its clause, its source (shall and should: the
standard; wire: the base wire; extension: an extension of it), and how it is checked.

With --url the gateway there is tried from both sides: connections of applications are opened and closed, and adapters
of the suite's own dial /adapter, so that other components stay untouched. Every application of the gateway is notified
when these adapters come and go. Where the gateway asks for tokens, one of an administrator does, for the adapters too;
one of an operator does for applications, and tries less. The scope of both has to hold 'conformance-*'.

The exit status is 0 when nothing failed, 1 when something did, 2 for wrong usage.
"""


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when nothing failed, 1 when something did, 2 for wrong usage."""
    chosen = _read(arguments)
    areas = _chosen(read_manifest(), chosen.only)
    if not areas:
        print(f"openrois conformance: nothing is called like {chosen.only!r}", file=sys.stderr)
        return 2
    try:
        if chosen.url is not None:
            return asyncio.run(_try(chosen, areas))
        return _print(chosen, areas)
    except BrokenPipeError:
        # The reader of a pipe has closed it. What is left to be flushed when Python ends has to go somewhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        print(f"openrois conformance: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


def _read(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="openrois conformance",
        description="What RoIS 2.0 and the wire require, and whether a gateway does it.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--url", help="the gateway to try, where applications connect, e.g. ws://127.0.0.1:8765/")
    parser.add_argument(
        "--only", default="*", metavar="PATTERN", help="requirements or checks of these names, e.g. 'event.*'"
    )
    add_credential_options(parser)
    parser.add_argument(
        "--adapter-token-file",
        type=Path,
        metavar="FILE",
        help="holds the token of the suite's adapters, where it is another one",
    )
    parser.add_argument("--no-adapter", action="store_true", help="do not dial in as an adapter: far less is tried")
    parser.add_argument(
        "--component",
        action=_Once,
        metavar="REF",
        help="try this component of another maker, too: bind and release it, ask its queries, subscribe to its events",
    )
    parser.add_argument(
        "--timeout", type=float, default=5.0, metavar="SECONDS", help="how long to wait for anything (%(default)s)"
    )
    parser.add_argument("--verbose", action="store_true", help="show every frame")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the manifest, or the run, as JSON, too")
    parser.add_argument("--markdown", action="store_true", help="print the manifest in Markdown")
    chosen = parser.parse_args(arguments)
    try:
        if chosen.url is not None:
            _read_gateway(chosen)
    except ValueError as error:
        parser.error(str(error))
    if not 0 < chosen.timeout <= 60:
        parser.error(f"--timeout must be more than 0 and at most 60 seconds, not {chosen.timeout:g}")
    if chosen.url is not None and chosen.markdown:
        parser.error("--markdown prints the manifest: leave out --url")
    return chosen


class _Once(argparse.Action):
    """An option that may be given once: of two the first would be dropped without a message."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        if getattr(namespace, self.dest) is not None:
            parser.error(f"{option} is given twice: try one component after the other")
        setattr(namespace, self.dest, values)


def _read_gateway(chosen: argparse.Namespace) -> None:
    """Read the description of the gateway. Raises ValueError."""
    chosen.url = gateway_url(chosen.url)
    chosen.credentials = chosen.adapter_credentials = credentials(chosen)
    if chosen.adapter_token_file is not None:
        chosen.adapter_credentials = Credentials.of_files(chosen.adapter_token_file, chosen.ca_file)
    for each in (chosen.credentials, chosen.adapter_credentials):
        each.headers()
        each.context(chosen.url)


def _chosen(areas: Sequence[Area], pattern: str) -> list[Area]:
    found = []
    for area in areas:
        kept = tuple(each for each in area.requirements if any(fnmatch(name, pattern) for name in _names(each)))
        if kept:
            found.append(Area(area.name, area.title, kept))
    return found


def _names(requirement: Requirement) -> tuple[str, ...]:
    return (requirement.id, *requirement.checks)


def _width() -> int:
    return min(shutil.get_terminal_size((120, 40)).columns, 120)


def _print(chosen: argparse.Namespace, areas: Sequence[Area]) -> int:
    lines = table.as_markdown(areas) if chosen.markdown else table.as_text(areas, _width())
    print("\n".join(lines))
    _write(chosen.json, table.as_json(areas))
    return 0


def _write(path: Path | None, value: Any) -> None:
    if path is not None:
        path.write_text(json.dumps(value, ensure_ascii=False, indent=2) + "\n", encoding="utf-8")


async def _try(chosen: argparse.Namespace, areas: Sequence[Area]) -> int:
    try:
        opened = visit(
            chosen.url,
            chosen.timeout,
            adapter=not chosen.no_adapter,
            component=chosen.component,
            credentials=chosen.credentials,
            adapter_credentials=chosen.adapter_credentials,
        )
        async with opened as place:
            return await _try_all(chosen, areas, place)
    except Deviation as deviation:
        print(f"openrois conformance: {chosen.url}: {deviation}", file=sys.stderr)
        return 1


async def _try_all(chosen: argparse.Namespace, areas: Sequence[Area], place: Visit) -> int:
    extensions = ", ".join(place.setting.extensions)
    print(f"{chosen.url} is {', '.join(place.engines)}; it speaks {extensions or 'the base wire alone'}")
    written = report.Report(_width(), verbose=chosen.verbose)
    checks = {check.id: check for check in ALL_CHECKS}
    verdicts: dict[str, Verdict] = {}
    tried: list[Requirement] = []
    for area in areas:
        visible = [requirement for requirement in area.requirements if requirement.checks]
        if visible:
            print(f"\n{area.title}")
        column = max((len(requirement.id) for requirement in visible), default=0)
        for requirement in visible:
            missing = [checks[check] for check in requirement.checks if check not in verdicts]
            verdicts.update({verdict.check.id: verdict for verdict in await run_checks(place, missing)})
            for line in written.lines(requirement, [verdicts[check] for check in requirement.checks], column):
                print(line, flush=True)
            tried.append(requirement)
    elsewhere = sum(len(area.requirements) for area in areas) - len(tried)
    print("", *written.summary(elsewhere), sep="\n")
    _write(chosen.json, {"url": chosen.url, "requirements": report.as_json(tried, verdicts)})
    return 1 if written.counts[report.Standing.FAILED] else 0
