"""Tokens for tests, made with bare `hmac` and `cryptography`: including tokens that a library refuses to make."""

import base64
import hashlib
import hmac
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, ed25519, padding, rsa
from cryptography.hazmat.primitives.asymmetric.utils import decode_dss_signature
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

SECRET: Final = "canary-secret-0123456789-0123456789-0123456789"
"""A secret of tests for HS256; it must not stand in anything that is said or logged."""


def b64(content: bytes) -> str:
    return base64.urlsafe_b64encode(content).rstrip(b"=").decode()


def part(value: object) -> str:
    return b64(value if isinstance(value, bytes) else json.dumps(value).encode())


def forge(header: object, claims: object, key: Any = SECRET) -> str:
    """Return a token with this header and these claims, signed as the kind of key says; `None` signs nothing."""
    signed = f"{part(header)}.{part(claims)}"
    return f"{signed}.{b64(sign(signed.encode(), key))}"


def sign(content: bytes, key: Any) -> bytes:
    match key:
        case None:
            return b""
        case str():
            return hmac.new(key.encode(), content, hashlib.sha256).digest()
        case bytes():
            return hmac.new(key, content, hashlib.sha256).digest()
        case rsa.RSAPrivateKey():
            return key.sign(content, padding.PKCS1v15(), hashes.SHA256())
        case ec.EllipticCurvePrivateKey():
            r, s = decode_dss_signature(key.sign(content, ec.ECDSA(hashes.SHA256())))
            size = (key.curve.key_size + 7) // 8
            return r.to_bytes(size) + s.to_bytes(size)
        case ed25519.Ed25519PrivateKey():
            return key.sign(content)
    raise TypeError(key)


def pem(key: Any) -> str:
    """Return the public key of a private one."""
    text: str = key.public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo).decode()
    return text


def jwk(key: Any, **more: object) -> dict[str, object]:
    """Return the public key of a private one as an entry of a JSON Web Key Set."""
    public = key.public_key()
    match public:
        case rsa.RSAPublicKey():
            numbers = public.public_numbers()
            size = (public.key_size + 7) // 8
            return {"kty": "RSA", "n": b64(numbers.n.to_bytes(size)), "e": b64(numbers.e.to_bytes(3)), **more}
        case ec.EllipticCurvePublicKey():
            point = public.public_numbers()
            size = (public.curve.key_size + 7) // 8
            name = {"secp256r1": "P-256", "secp384r1": "P-384"}[public.curve.name]
            return {
                "kty": "EC",
                "crv": name,
                "x": b64(point.x.to_bytes(size)),
                "y": b64(point.y.to_bytes(size)),
                **more,
            }
    return {"kty": "OKP", "crv": "Ed25519", "x": b64(public.public_bytes_raw()), **more}


@dataclass
class Keys:
    """One private key of each kind."""

    rsa: Any = field(default_factory=lambda: rsa.generate_private_key(65537, 2048))
    p256: Any = field(default_factory=lambda: ec.generate_private_key(ec.SECP256R1()))
    ed25519: Any = field(default_factory=ed25519.Ed25519PrivateKey.generate)


def claims_of(now: float, **others: object) -> dict[str, object]:
    """Return good claims of an operator, changed by `others`; one that is `...` is left out."""
    good = {"sub": "alice", "iat": int(now), "exp": int(now) + 900, "roles": ["operator"], "scope": ["*"]}
    return {name: value for name, value in {**good, **others}.items() if value is not ...}


def issue(now: float, key: Any = SECRET, **others: object) -> str:
    """Return a good token, changed by `others`."""
    algorithm = {rsa.RSAPrivateKey: "RS256", ec.EllipticCurvePrivateKey: "ES256", ed25519.Ed25519PrivateKey: "EdDSA"}
    alg = next((name for kind, name in algorithm.items() if isinstance(key, kind)), "HS256")
    return forge({"alg": alg, "typ": "JWT"}, claims_of(now, **others), key)


def key_file(folder: Path, content: str = SECRET) -> Path:
    """Write a key into a file that only its owner reads."""
    path = folder / "key"
    path.write_text(content + "\n")
    path.chmod(0o600)
    return path
