"""Credentials that a client shows to a gateway, and the authorities by which it checks the gateway."""

import os
import ssl
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

__all__ = ["CA_FILE_VARIABLE", "NO_CREDENTIALS", "TOKEN_FILE_VARIABLE", "Credentials", "Token", "read_token"]

TOKEN_FILE_VARIABLE: Final = "OPENROIS_TOKEN_FILE"  # noqa: S105
"""Environment variable with the file of the token."""

CA_FILE_VARIABLE: Final = "OPENROIS_CA_FILE"
"""Environment variable with the file of authorities that may have signed the gateway's certificate."""

MAX_TOKEN_FILE: Final = 64 << 10

Token = str | Callable[[], str]
"""A token, or a function that returns the newest one; it may raise `ValueError` with a sentence."""


@dataclass(frozen=True, slots=True)
class Credentials:
    """Shown to a gateway each time it is dialled.

    Attributes:
        token: the token; None for nothing.
        ca_file: the authorities (PEM) that may have signed a gateway's certificate; None for those of the system.
    """

    token: Token | None = field(default=None, repr=False)
    ca_file: Path | None = None

    @classmethod
    def of_files(cls, token_file: Path | str | None, ca_file: Path | str | None) -> "Credentials":
        """Return credentials from files, or those that the environment names; the token is read at each use."""
        named, authorities = os.environ.get(TOKEN_FILE_VARIABLE), os.environ.get(CA_FILE_VARIABLE)
        token, trusted = token_file or named, ca_file or authorities
        return cls(None if not token else lambda: read_token(Path(token)), Path(trusted) if trusted else None)

    def newest(self) -> str | None:
        """Return the token as it is now, without the line end that it had in a file.

        Raises:
            ValueError: it cannot be read, or is no token.
        """
        token = self.token() if callable(self.token) else self.token
        return None if token is None else _token(token, "what was given as one")

    def headers(self) -> Mapping[str, str]:
        """Return the headers of the opening request.

        Raises:
            ValueError: the token cannot be read.
        """
        token = self.newest()
        return {} if token is None else {"Authorization": f"Bearer {token}"}

    def context(self, url: str) -> ssl.SSLContext | None:
        """Return the TLS context for `url`; None where there is no TLS.

        Raises:
            ValueError: the file with the authorities cannot be used.
        """
        if not url.startswith("wss:"):
            return None
        try:
            context = ssl.create_default_context(cafile=None if self.ca_file is None else str(self.ca_file))
        except OSError as error:
            raise ValueError(f"{self.ca_file} cannot be used as authorities: {error.strerror or error}") from None
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        return context


NO_CREDENTIALS: Final = Credentials()


def read_token(path: Path) -> str:
    """Return the token in a file.

    Raises:
        ValueError: it cannot be read, or is none; the message does not say what is in it.
    """
    try:
        with path.open("rb") as file:
            text = file.read(MAX_TOKEN_FILE).decode("ascii", "replace")
    except OSError as error:
        raise ValueError(f"the token cannot be read from {path}: {error.strerror}") from None
    return _token(text, str(path))


def _token(text: str, place: str) -> str:
    """Return the token in a text; any other text must not get into a header, whose errors would repeat it."""
    token = text.strip(" \t\r\n")
    if not token or not token.isascii() or not token.isprintable() or " " in token:
        raise ValueError(f"there is no token in {place}: it is one line, as `openrois token issue` prints it")
    return token
