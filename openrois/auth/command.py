"""`openrois token`: keys for tokens, and tokens signed with them, for development and small deployments."""

import argparse
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from openrois.auth.claims import MAX_LIFETIME
from openrois.auth.issuing import issue_token
from openrois.auth.key_files import make_key_files
from openrois.auth.keys import ALGORITHMS
from openrois.auth.principal import Role
from openrois.auth.ranks import DEFAULT_RANKS
from openrois.cli.command_line import CommandLine

__all__ = ["main"]

_DURATION = re.compile(r"(\d{1,6})([smhd]?)")
_UNITS = {"": 1, "s": 1, "m": 60, "h": 3600, "d": 86400}
_LONGEST = _UNITS["d"]
"""Seconds: the highest `auth_max_lifetime` that a gateway accepts."""


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 for success, 1 for failure, 2 for wrong usage."""
    parser = CommandLine("openrois token", description="Keys and tokens for a gateway.")
    parts = parser.add_subparsers(dest="part", required=True, metavar="COMMAND")
    new_key = parts.add_parser("new-key", help="make a key")
    new_key.add_argument("file", type=Path, metavar="FILE", help="the new file; the public half goes into FILE.pub")
    new_key.add_argument(
        "--algorithm",
        choices=ALGORITHMS,
        default="HS256",
        help="HS256 is one secret for both ends; the others have a public half (%(default)s)",
    )
    issue = parts.add_parser("issue", help="print a token")
    issue.add_argument("--key", type=Path, required=True, metavar="FILE", help="what `new-key` has made")
    issue.add_argument("--sub", required=True, metavar="NAME", help="who it is for")
    issue.add_argument(
        "--role", action="append", required=True, choices=[role.value for role in Role], help="what that one is"
    )
    issue.add_argument(
        "--rank",
        default="",
        metavar="NAME",
        help=f"one of the gateway's --ranks, which are {', '.join(DEFAULT_RANKS)} unless set (the lowest)",
    )
    issue.add_argument("--scope", action="append", default=[], metavar="PATTERN", help="components, such as 'avatar/*'")
    issue.add_argument("--ttl", type=_seconds, default=900, metavar="TIME", help="how long: 90s, 15m, 1h (15m)")
    issue.add_argument("--issuer", default="", metavar="TEXT", help="the claim iss")
    issue.add_argument("--audience", default="", metavar="TEXT", help="the claim aud")
    chosen = parser.parse_args(arguments)
    try:
        return _make(chosen) if chosen.part == "new-key" else _issue(chosen)
    except FileExistsError as error:
        _tell(f"{error.filename} exists already, and a key is never written over: name another file")
    except OSError as error:
        _tell(f"{error.filename}: {error.strerror}")
    except ValueError as error:
        _tell(str(error))
    return 1


def _tell(sentence: str) -> None:
    print(f"openrois token: {sentence}", file=sys.stderr)


def _seconds(text: str) -> int:
    found = _DURATION.fullmatch(text)
    if found is None or int(found[1]) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is no duration: write it as 90s, 15m or 1h")
    seconds = int(found[1]) * _UNITS[found[2]]
    if seconds > _LONGEST:
        raise argparse.ArgumentTypeError(f"a token may last for a day at most, not {text}")
    return seconds


def _make(chosen: argparse.Namespace) -> int:
    for path in make_key_files(chosen.file, chosen.algorithm):
        print(path)
    return 0


def _issue(chosen: argparse.Namespace) -> int:
    token = issue_token(
        chosen.key,
        chosen.sub,
        [Role(role) for role in chosen.role],
        chosen.scope,
        now=int(time.time()),
        ttl=chosen.ttl,
        issuer=chosen.issuer,
        audience=chosen.audience,
        rank=chosen.rank,
    )
    if not chosen.scope and Role.ADMINISTRATOR.value not in chosen.role:
        _tell("without --scope this token is good for no component")
    if chosen.ttl > MAX_LIFETIME:
        _tell(f"a gateway takes this token only with --auth-max-lifetime {chosen.ttl} or more")
    if chosen.rank and chosen.rank not in DEFAULT_RANKS:
        _tell(f"a gateway takes this token only where its --ranks name {chosen.rank}")
    print(token)
    return 0
