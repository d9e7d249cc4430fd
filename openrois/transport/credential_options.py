"""Credentials for a gateway, as options of a command."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from openrois.transport.credentials import CA_FILE_VARIABLE, TOKEN_FILE_VARIABLE, Credentials

__all__ = ["add_credential_options", "credential_arguments", "credentials"]


def add_credential_options(parser: argparse.ArgumentParser) -> None:
    """Add `--token-file` and `--ca-file`."""
    parser.add_argument(
        "--token-file",
        type=Path,
        metavar="FILE",
        help=f"holds the token that the gateway wants, and is read whenever it is needed ({TOKEN_FILE_VARIABLE})",
    )
    parser.add_argument(
        "--ca-file",
        type=Path,
        metavar="FILE",
        help=f"authorities that may have signed the gateway's certificate ({CA_FILE_VARIABLE}, or the system's)",
    )


def credentials(chosen: argparse.Namespace) -> Credentials:
    """Return the credentials of the options, or else of the environment; the files are read when they are needed."""
    return Credentials.of_files(chosen.token_file, chosen.ca_file)


def credential_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """Return the options as they were given, for another command."""
    given = (("--token-file", chosen.token_file), ("--ca-file", chosen.ca_file))
    return [part for option, path in given if path is not None for part in (option, str(path))]
