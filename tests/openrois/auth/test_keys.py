"""Keys: the use of each follows from the key alone, and what is too weak or not ours is refused."""

import datetime as dt
import json
from functools import cache
from typing import Any

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import dsa, ec, ed448, rsa
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
from hypothesis import given
from hypothesis import strategies as st

from openrois.auth.keys import MAX_KEYS, StoredKeys, parse_key, parse_key_set, parse_keys
from tests.support.tokens import SECRET, Keys, jwk, pem


@cache
def keys() -> Keys:
    return Keys()


def certificate(key: Any) -> str:
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "issuer")])
    now = dt.datetime(2026, 1, 1, tzinfo=dt.UTC)
    made = x509.CertificateBuilder().subject_name(name).issuer_name(name).public_key(key.public_key())
    made = made.serial_number(1).not_valid_before(now).not_valid_after(now + dt.timedelta(days=1))
    return made.sign(key, SHA256()).public_bytes(Encoding.PEM).decode()


def test_what_a_key_is_for() -> None:
    assert parse_key(f"\n{SECRET}\n").algorithm == "HS256"
    assert parse_key(SECRET).material == SECRET.encode()
    assert parse_key(pem(keys().rsa)).algorithm == "RS256"
    assert parse_key(pem(keys().p256)).algorithm == "ES256"
    assert parse_key(pem(keys().ed25519)).algorithm == "EdDSA"
    assert parse_key(certificate(keys().rsa)).algorithm == "RS256"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "at least 32 characters"),
        ("x" * 31, "at least 32 characters"),
        ("x" * 40 + "\n" + "y" * 40, "one line"),
        ("x" * 40 + " y", "one line"),
        ("-----BEGIN PUBLIC KEY-----\nxxxx\n-----END PUBLIC KEY-----", "is damaged"),
        ("-----BEGIN CERTIFICATE-----\nxxxx\n-----END CERTIFICATE-----", "is damaged"),
        ("-----BEGIN RSA PRIVATE KEY-----", "give a gateway the public key"),
        ("-----BEGIN OPENSSH PRIVATE KEY-----", "give a gateway the public key"),
    ],
)
def test_what_is_no_key(text: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        parse_key(text)


def test_several_keys_in_one_file() -> None:
    old, new = pem(keys().p256), pem(keys().ed25519)
    assert [key.algorithm for key in parse_keys(old)] == ["ES256"]
    assert [key.algorithm for key in parse_keys(f"# the former one\n{old}{new}")] == ["ES256", "EdDSA"]
    assert [key.algorithm for key in parse_keys(SECRET)] == ["HS256"]
    # The signer of a certificate signs no tokens.
    chain = certificate(keys().rsa) + certificate(keys().p256)
    assert [key.algorithm for key in parse_keys(chain)] == ["RS256"]
    with pytest.raises(ValueError, match="is damaged"):
        parse_keys(old + "-----BEGIN PUBLIC KEY-----\nxxxx\n-----END PUBLIC KEY-----")
    with pytest.raises(ValueError, match="give a gateway the public key"):
        parse_keys(old + new + "-----BEGIN PRIVATE KEY-----")
    with pytest.raises(ValueError, match="more than 64 keys"):
        parse_keys(old * (MAX_KEYS + 1))


def pkcs1(key: Any) -> str:
    return str(key.public_key().public_bytes(Encoding.PEM, PublicFormat.PKCS1).decode())


def test_no_key_of_a_file_is_passed_over() -> None:
    rsa_key, spki = pkcs1(keys().rsa), pem(keys().p256)
    assert [key.algorithm for key in parse_keys(rsa_key)] == ["RS256"]
    assert [key.algorithm for key in parse_keys(rsa_key * 2)] == ["RS256"] * 2
    assert [key.algorithm for key in parse_keys(spki + rsa_key)] == ["ES256", "RS256"]
    assert [key.algorithm for key in parse_keys(rsa_key + spki * 2)] == ["RS256", "ES256", "ES256"]
    for other in (certificate(keys().rsa), "-----BEGIN EC PARAMETERS-----\nAAAA\n-----END EC PARAMETERS-----\n"):
        for text in (spki + other, other + spki, spki * 2 + other):
            with pytest.raises(ValueError, match=r"(CERTIFICATE|EC PARAMETERS).*PUBLIC KEY"):
                parse_keys(text)
    with pytest.raises(ValueError, match="is damaged"):
        parse_keys(spki + rsa_key.replace("-----", "----", 2).replace("----BEGIN", "-----BEGIN"))


def test_weak_keys_and_other_kinds() -> None:
    with pytest.raises(ValueError, match="2048 bits"):
        parse_key(pem(rsa.generate_private_key(65537, 1024)))
    for key in (
        ec.generate_private_key(ec.SECP384R1()),
        ed448.Ed448PrivateKey.generate(),
        dsa.generate_private_key(1024),
    ):
        with pytest.raises(ValueError, match=r"RSA .RS256., P-256"):
            parse_key(pem(key))


def entry(kind: str, **more: object) -> dict[str, object]:
    return jwk(getattr(keys(), kind), **{"kid": kind, **more})


def test_a_key_set() -> None:
    found = parse_key_set(json.dumps({"keys": [entry("rsa", use="sig"), entry("p256", alg="ES256"), entry("ed25519")]}))
    assert {kid: key.algorithm for kid, key in found.items()} == {"rsa": "RS256", "p256": "ES256", "ed25519": "EdDSA"}


@pytest.mark.parametrize(
    "other",
    [
        "no object",
        {"kty": "oct", "k": "c2VjcmV0c2VjcmV0c2VjcmV0c2VjcmV0c2VjcmV0", "kid": "x"},
        {"kty": "RSA", "kid": "x"},
        {"kty": "RSA", "kid": "x", "n": 1, "e": 2},
        {"kty": "EC", "kid": "x", "crv": "P-256", "x": "AA", "y": "AA"},
        {"kty": "OKP", "kid": "x", "crv": "X25519", "x": "AA"},
        {"kty": ["RSA"], "kid": "x"},
        {"kty": "new", "kid": "x"},
        {},
    ],
    ids=str,
)
def test_what_a_key_set_may_also_have(other: object) -> None:
    assert set(parse_key_set(json.dumps({"keys": [other, entry("rsa")]}))) == {"rsa"}


def test_entries_that_are_left_out() -> None:
    left_out = [
        entry("rsa", kid="enc", use="enc"),
        entry("rsa", kid="other", alg="PS256"),
        entry("rsa", kid="confused", alg="HS256"),
        entry("rsa", kid=""),
        entry("rsa", kid=7),
        entry("rsa", kid="k" * 300),
        entry("ed25519", kid="private", d="AA"),
        jwk(ec.generate_private_key(ec.SECP384R1()), kid="p384"),
        jwk(keys().rsa),
    ]
    with pytest.raises(ValueError, match="no key that tokens can be verified with"):
        parse_key_set(json.dumps({"keys": left_out}))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no JSON"),
        ("[" * 100_000, "no JSON"),
        ("[]", 'no list "keys"'),
        ('{"keys": {}}', 'no list "keys"'),
        (json.dumps({"keys": [{}] * (MAX_KEYS + 1)}), "more than 64"),
    ],
    ids=["nothing", "deep", "a list", "an object", "too many"],
)
def test_what_is_no_key_set(text: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        parse_key_set(text)


def test_a_name_has_one_key() -> None:
    with pytest.raises(ValueError, match="the same id"):
        parse_key_set(json.dumps({"keys": [entry("rsa", kid="k"), entry("p256", kid="k")]}))


@given(st.binary(max_size=100) | st.text(max_size=100).map(str.encode))
def test_any_text_is_a_key_set_or_none(text: bytes) -> None:
    with pytest.raises(ValueError, match=r".+"):
        parse_key_set(text)


async def test_keys_without_names() -> None:
    key = parse_key(SECRET)
    assert await StoredKeys((key,)).find("whatever") == (key,)
    assert StoredKeys((key,)).is_usable()
    assert not StoredKeys(()).is_usable()
    assert SECRET not in repr(key)
