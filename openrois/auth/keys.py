"""Keys that tokens are signed with; the algorithm follows from the key, never from the token. Pure."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Protocol

import jwt
from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives.asymmetric.ec import SECP256R1, EllipticCurvePublicKey
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
from cryptography.hazmat.primitives.asymmetric.rsa import RSAPublicKey
from cryptography.hazmat.primitives.serialization import load_pem_public_key
from cryptography.x509 import load_pem_x509_certificate

__all__ = [
    "ALGORITHMS",
    "MAX_KEY_FILE",
    "KeySource",
    "KeysUnavailable",
    "StoredKeys",
    "VerificationKey",
    "parse_key",
    "parse_key_set",
    "parse_keys",
    "public_key",
]

ALGORITHMS: Final = ("HS256", "RS256", "ES256", "EdDSA")
"""Algorithms that tokens may be signed with."""

MIN_SECRET: Final = 32
"""Characters of a secret for HS256 at least: as many bytes as its hash has."""

MIN_RSA: Final = 2048
"""Bits of an RSA key at least."""

MAX_KEY_FILE: Final = 256 << 10
"""Bytes of a file or an answer with keys."""

MAX_KEYS: Final = 64
"""Keys of one issuer, or in one file."""

_MAX_KEY_ID: Final = 256
_PEM: Final = "-----BEGIN "
_BLOCK: Final = re.compile(r"-----BEGIN ([A-Z0-9 ]{0,40})")


class KeysUnavailable(Exception):
    """The keys of the issuer could not be fetched, and none are cached."""


@dataclass(frozen=True, slots=True)
class VerificationKey:
    """A key and the one algorithm that it is for.

    Attributes:
        algorithm: one of `ALGORITHMS`.
        material: the secret, or the public key.
    """

    algorithm: str
    material: Any

    def __repr__(self) -> str:
        return f"VerificationKey({self.algorithm!r})"


class KeySource(Protocol):
    """A source of keys."""

    async def find(self, key_id: str) -> tuple[VerificationKey, ...]:
        """Return the keys that a token may have been signed with; none where its key is unknown.

        Args:
            key_id: what the token calls its key; empty where it does not say.

        Raises:
            KeysUnavailable: the issuer's keys could not be fetched.
        """
        ...

    def is_usable(self) -> bool:
        """Tell whether there are keys now; where there are none they are fetched meanwhile."""
        ...


class StoredKeys:
    """Keys that were read from files. They have no ids: a token is tried with each that is for its algorithm.

    Attributes:
        keys: what they are now.
    """

    def __init__(self, keys: tuple[VerificationKey, ...]) -> None:
        self.keys = keys

    async def find(self, key_id: str) -> tuple[VerificationKey, ...]:
        """Return all of them, whatever id the token names."""
        return self.keys

    def is_usable(self) -> bool:
        """Tell whether there are any."""
        return bool(self.keys)


def parse_key(text: str) -> VerificationKey:
    """Return the key that a text holds: a public key or certificate in PEM, else a secret for HS256.

    Raises:
        ValueError: it is no key that tokens can be verified with.
    """
    _refuse_private(text)
    if _PEM in text:
        return public_key(_load_pem(text.encode()))
    secret = text.strip()
    if len(secret) < MIN_SECRET:
        raise ValueError(
            f"a secret for HS256 must have at least {MIN_SECRET} characters; `openrois token new-key` makes one"
        )
    if not secret.isprintable() or " " in secret:
        raise ValueError("a secret for HS256 is one line without spaces, and a public key begins with -----BEGIN")
    return VerificationKey("HS256", secret.encode())


def parse_keys(text: str) -> tuple[VerificationKey, ...]:
    """Return the keys that a text holds: public keys in PEM, one after the other, or what `parse_key` reads.

    Of a certificate with its chain the first one counts: its signer signs no tokens. Nothing else in PEM is
    passed over.

    Raises:
        ValueError: one of them is no key that tokens can be verified with, they do not belong in one file, or there
            are too many.
    """
    _refuse_private(text)
    kinds = _BLOCK.findall(text)
    if len(kinds) < 2 or set(kinds) == {"CERTIFICATE"}:
        return (parse_key(text),)
    if not all(kind.endswith("PUBLIC KEY") for kind in kinds):
        found = ", ".join(sorted(set(kinds)))
        raise ValueError(f"one file has public keys, or a certificate with its chain, and nothing else; found: {found}")
    if len(kinds) > MAX_KEYS:
        raise ValueError(f"it has more than {MAX_KEYS} keys")
    return tuple(parse_key(_PEM + block) for block in text.split(_PEM)[1:])


def _refuse_private(text: str) -> None:
    if "PRIVATE KEY-----" in text:
        raise ValueError("this is a private key, which belongs to the issuer alone: give a gateway the public key")


def _load_pem(pem: bytes) -> object:
    try:
        if b"-----BEGIN CERTIFICATE" in pem:
            return load_pem_x509_certificate(pem).public_key()
        return load_pem_public_key(pem)
    except (ValueError, UnsupportedAlgorithm):
        raise ValueError("it begins like a public key in PEM and is damaged") from None


def public_key(key: object) -> VerificationKey:
    """Return a public key with the algorithm that it is for.

    Raises:
        ValueError: it is for none of ours, or too short.
    """
    match key:
        case RSAPublicKey() if key.key_size >= MIN_RSA:
            return VerificationKey("RS256", key)
        case RSAPublicKey():
            raise ValueError(f"an RSA key must have at least {MIN_RSA} bits, not {key.key_size}")
        case EllipticCurvePublicKey() if isinstance(key.curve, SECP256R1):
            return VerificationKey("ES256", key)
        case Ed25519PublicKey():
            return VerificationKey("EdDSA", key)
    raise ValueError("keys are RSA (RS256), P-256 (ES256) or Ed25519 (EdDSA)")


def parse_key_set(text: str | bytes) -> Mapping[str, VerificationKey]:
    """Return the keys of a JSON Web Key Set by their ids; what is not for signatures, or not for us, is left out.

    Raises:
        ValueError: it is no key set, or has no key that can be used.
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        raise ValueError("it is no JSON Web Key Set: it is not JSON") from None
    entries = document.get("keys") if isinstance(document, dict) else None
    if not isinstance(entries, list):
        raise ValueError('it is no JSON Web Key Set: it has no list "keys"')
    if len(entries) > MAX_KEYS:
        raise ValueError(f"it has more than {MAX_KEYS} keys")
    found: dict[str, VerificationKey] = {}
    for entry in entries:
        key = _from_entry(entry)
        if key is not None:
            if entry["kid"] in found:
                raise ValueError("two of its keys have the same id")
            found[entry["kid"]] = key
    if not found:
        raise ValueError("it has no key that tokens can be verified with: each needs a `kid`")
    return found


def _from_entry(entry: object) -> VerificationKey | None:
    """Return the key of one entry; None for one that is not for us. A secret has no place in what is public."""
    if not isinstance(entry, dict) or entry.get("use", "sig") != "sig" or entry.get("kty") == "oct":
        return None
    key_id = entry.get("kid")
    if not isinstance(key_id, str) or not 0 < len(key_id) <= _MAX_KEY_ID:
        return None
    public = {name: value for name, value in entry.items() if name not in ("alg", "key_ops", "use")}
    algorithm = {"RSA": "RS256", "EC": "ES256", "OKP": "EdDSA"}.get(str(entry.get("kty")))
    if algorithm is None or "d" in entry:
        return None
    try:
        key = public_key(jwt.PyJWK(public, algorithm).key)
    except (jwt.PyJWTError, ValueError, TypeError, KeyError, UnsupportedAlgorithm):
        return None
    return key if entry.get("alg", key.algorithm) == key.algorithm else None
