"""The options of the engine link and of facades: address and secret of a user's own game engine."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from openrois.auth.loopback import is_loopback
from openrois_avatar.link.address import parse_address
from openrois_avatar.link.messages import MAX_NAME, LinkError
from openrois_avatar.options.settings import DEFAULT_FACADE, DEFAULT_LINK

__all__ = ["add_facade_option", "add_link_options", "facade_address", "link_arguments", "link_secret"]


def add_link_options(parser: argparse.ArgumentParser, *, when: str = "", otherwise: str = "") -> None:
    """Add `--link` and `--link-secret-file`.

    Args:
        parser: to add them to.
        when: the condition under which they count, for the help.
        otherwise: the default, for the help, where that is None; empty: `DEFAULT_LINK`.
    """
    parser.add_argument(
        "--link",
        type=_address,
        default=None if otherwise else DEFAULT_LINK,
        metavar="ADDRESS",
        help=f"where the game engine is awaited{when}: tcp:HOST:PORT or unix:PATH, on this machine"
        f" ({otherwise or DEFAULT_LINK})",
    )
    parser.add_argument(
        "--link-secret-file",
        type=Path,
        metavar="FILE",
        help="holds the secret that the engine must send (to a facade as the path of its URL); without it any program"
        " of this machine that reaches the address can be the engine",
    )


def add_facade_option(parser: argparse.ArgumentParser) -> None:
    """Add `--facade`."""
    parser.add_argument(
        "--facade",
        type=_facade,
        default=DEFAULT_FACADE,
        metavar="HOST:PORT",
        help="where unreal or unity-render-streaming finds its signaling server, on this machine (%(default)s)",
    )


def link_secret(chosen: argparse.Namespace) -> str:
    """Return the secret, the first line of the file; empty without a file.

    Raises:
        ValueError: the file cannot be read, or does not hold a secret.
    """
    file: Path | None = chosen.link_secret_file
    if file is None:
        return ""
    try:
        secret = file.read_text(encoding="utf-8").partition("\n")[0].strip()
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is no UTF-8 text"
        raise ValueError(f"--link-secret-file: {file} cannot be read: {why}") from None
    if not 0 < len(secret) <= MAX_NAME:
        raise ValueError(
            f"--link-secret-file: the first line of {file} must have 1 to {MAX_NAME} characters, not {len(secret)}"
        )
    return secret


def link_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """Return the options, with `--facade`, for another command line."""
    file = chosen.link_secret_file
    return (
        "--link",
        chosen.link,
        "--facade",
        chosen.facade,
        *(() if file is None else ("--link-secret-file", str(file))),
    )


def _facade(text: str) -> str:
    try:
        facade_address(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def _address(text: str) -> str:
    try:
        return str(parse_address(text))
    except LinkError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def facade_address(text: str) -> tuple[str, int]:
    """Read `HOST:PORT` or `[HOST]:PORT`, where the host is `localhost` or a loopback address.

    Raises:
        ValueError: the text is no such address.
    """
    host, _, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not (port.isascii() and port.isdigit() and int(port) < 2**16):
        raise ValueError(f"{text!r} is no address of a signaling server; write HOST:PORT, as 127.0.0.1:8888")
    if not is_loopback(host):
        raise ValueError(
            f"a game engine is awaited on this machine only, and {host!r} is no loopback address; use 127.0.0.1"
        )
    return host, int(port)
