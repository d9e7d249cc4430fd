"""Keys in files: read by a gateway, made and used by an issuer of tokens."""

import logging
import os
import secrets
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives.asymmetric.ec import SECP256R1, generate_private_key
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.asymmetric.rsa import generate_private_key as generate_rsa
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    PublicFormat,
    load_pem_private_key,
)

from openrois.auth.keys import MAX_KEY_FILE, VerificationKey, parse_key, parse_keys, public_key

__all__ = [
    "is_exposed",
    "make_key_files",
    "read_key_file",
    "read_keys",
    "read_signing_key",
]

_log = logging.getLogger(__name__)

_RSA_BITS: Final = 3072
_PRIVATE: Final = "PRIVATE KEY-----"


def read_key_file(path: Path) -> str:
    """Return the text of a file with a key.

    Raises:
        ValueError: it cannot be read, or is too long; the message names the file and never what is in it.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_KEY_FILE + 1)
        text = content.decode("ascii")
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path} is no key: it is not plain text") from None
    if len(content) > MAX_KEY_FILE:
        raise ValueError(f"{path} is no key: it has more than {MAX_KEY_FILE} bytes")
    return text


def read_keys(paths: Iterable[Path]) -> tuple[VerificationKey, ...]:
    """Return the keys that tokens are verified with, of all files.

    Raises:
        ValueError: one of them is no such key; the message names the file.
    """
    keys: list[VerificationKey] = []
    for path in paths:
        text = read_key_file(path)
        try:
            found = parse_keys(text)
        except ValueError as flaw:
            raise ValueError(f"{path}: {flaw}") from None
        if found[0].algorithm == "HS256":
            _warn_of_readers(path)
        keys += found
    return tuple(keys)


def read_signing_key(path: Path) -> tuple[str, Any]:
    """Return the algorithm and the key that tokens are signed with: a private key in PEM, or the secret for HS256.

    Raises:
        ValueError: it is no such key.
    """
    text = read_key_file(path)
    try:
        if _PRIVATE not in text:
            key = parse_key(text)
            if key.algorithm != "HS256":
                raise ValueError("a public key cannot sign: give the private key")
            _warn_of_readers(path)
            return key.algorithm, key.material
        _warn_of_readers(path)
        private: Any = load_pem_private_key(text.encode(), None)
        return public_key(private.public_key()).algorithm, private
    except (ValueError, TypeError, AttributeError, UnsupportedAlgorithm) as flaw:
        raise ValueError(f"{path}: {flaw}") from None


def make_key_files(path: Path, algorithm: str) -> tuple[Path, ...]:
    """Make a new key: `path` is for the issuer, and beside it `.pub` for gateways, where they need not share it.

    Args:
        path: the new file; only its owner can read it.
        algorithm: one of `ALGORITHMS`.

    Returns:
        The files that were written.

    Raises:
        OSError: one of them is there already, or cannot be written.
    """
    if algorithm == "HS256":
        _write(path, secrets.token_urlsafe(48) + "\n", 0o600)
        return (path,)
    private: Any = {
        "RS256": lambda: generate_rsa(65537, _RSA_BITS),
        "ES256": lambda: generate_private_key(SECP256R1()),
        "EdDSA": Ed25519PrivateKey.generate,
    }[algorithm]()
    public = path.with_name(f"{path.name}.pub")
    pem = private.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    _write(path, pem.decode(), 0o600)
    _write(public, private.public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo).decode(), 0o644)
    return path, public


def _write(path: Path, text: str, mode: int) -> None:
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "w", encoding="ascii") as file:
        file.write(text)


def _warn_of_readers(path: Path) -> None:
    if is_exposed(path):
        _log.warning("%s can be read by others on this machine; chmod 600 keeps the key a secret", path)


def is_exposed(path: Path) -> bool:
    """Tell whether a secret file is readable by more than its owner; root's files may also be readable by a group.

    Raises:
        OSError: there is no such file.
    """
    found = path.stat()
    return bool(found.st_mode & (0o007 if found.st_uid == 0 else 0o077))
