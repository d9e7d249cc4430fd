"""`openrois token`: keys for tokens, and tokens signed with them, for development and small deployments."""

import argparse
import re
import secrets
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import jwt

from openrois.access.claims import ClaimRules, read_claims
from openrois.access.key_files import make_key_files, read_signing_key
from openrois.access.keys import ALGORITHMS
from openrois.access.principal import Role
from openrois.access.refusal import TokenRefused

__all__ = ["main"]

_DURATION = re.compile(r"(\d{1,6})([smhd]?)")
_UNITS = {"": 1, "s": 1, "m": 60, "h": 3600, "d": 86400}


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when done, 1 when it could not be done, 2 for wrong usage."""
    parser = argparse.ArgumentParser(prog="openrois token", description="Keys and tokens for a gateway.")
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
    issue.add_argument("--scope", action="append", default=[], metavar="PATTERN", help="components, such as 'avatar/*'")
    issue.add_argument("--ttl", type=_seconds, default=900, metavar="TIME", help="how long: 90s, 15m, 1h (15m)")
    issue.add_argument("--issuer", default="", metavar="TEXT", help="the claim iss")
    issue.add_argument("--audience", default="", metavar="TEXT", help="the claim aud")
    chosen = parser.parse_args(arguments)
    try:
        return _make(chosen) if chosen.part == "new-key" else _issue(chosen)
    except (ValueError, OSError) as error:
        shown = f"{error.filename}: {error.strerror}" if isinstance(error, OSError) else str(error)
        print(f"openrois token: {shown}", file=sys.stderr)
        return 1


def _seconds(text: str) -> int:
    found = _DURATION.fullmatch(text)
    if found is None or int(found[1]) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is no time, such as 90s, 15m or 1h")
    return int(found[1]) * _UNITS[found[2]]


def _make(chosen: argparse.Namespace) -> int:
    for path in make_key_files(chosen.file, chosen.algorithm):
        print(path)
    return 0


def _issue(chosen: argparse.Namespace) -> int:
    algorithm, key = read_signing_key(chosen.key)
    now = int(time.time())
    claims = {
        "sub": chosen.sub,
        "iat": now,
        "exp": now + chosen.ttl,
        "jti": secrets.token_hex(16),
        "roles": chosen.role,
    }
    # Without a scope an administrator sees everything, and everybody else nothing.
    claims |= {"scope": chosen.scope} if chosen.scope else {}
    claims |= {"iss": chosen.issuer} if chosen.issuer else {}
    claims |= {"aud": chosen.audience} if chosen.audience else {}
    try:
        read_claims(claims, ClaimRules(chosen.issuer, chosen.audience, chosen.ttl), now)
    except TokenRefused as refused:
        raise ValueError(f"no gateway would take such a token: {refused.reason.value}") from None
    print(jwt.encode(claims, key, algorithm))
    return 0
