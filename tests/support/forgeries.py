"""All known kinds of bad tokens."""

import json

from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

from openrois.auth.refusal import Refusal
from openrois.types.access import MAX_TOKEN
from tests.support.tokens import SECRET, Keys, b64, claims_of, forge, issue, jwk, part, pem

_HS: dict[str, object] = {"alg": "HS256", "typ": "JWT"}


def forgeries(own: Keys, now: float) -> dict[str, tuple[str, Refusal]]:
    """Return every forgery with the reason that the audit gives, where the gateway knows all the keys of `own`."""
    other = Keys()
    claims = claims_of(now)
    public = pem(own.rsa)
    der = own.rsa.public_key().public_bytes(Encoding.DER, PublicFormat.SubjectPublicKeyInfo)
    good = issue(now)
    head, body, mark = good.split(".")
    p384 = ec.generate_private_key(ec.SECP384R1())
    table: dict[str, tuple[str, Refusal]] = {
        "empty": ("", Refusal.MALFORMED),
        "no parts": ("token", Refusal.MALFORMED),
        "two parts": (f"{head}.{body}", Refusal.MALFORMED),
        "four parts": (f"{good}.x", Refusal.MALFORMED),
        "five parts, as if encrypted": (f"{good}.x.y", Refusal.MALFORMED),
        "no signature": (f"{head}.{body}.", Refusal.MALFORMED),
        "spaces": (f" {good}", Refusal.MALFORMED),
        "a line break behind it": (f"{good}\n", Refusal.MALFORMED),
        "padding": (f"{head}.{body}.{mark}=", Refusal.MALFORMED),
        "base64 of the other alphabet": (f"{head}.{body}.+/{mark}", Refusal.MALFORMED),
        "junk that decoders skip": (f"{head}.{body[:4]}*{body[4:]}.{mark}", Refusal.MALFORMED),
        "too long": (forge(_HS, {**claims, "x": "y" * MAX_TOKEN}), Refusal.MALFORMED),
        "a header that is no JSON": (forge(b"{", claims), Refusal.MALFORMED),
        "a header that is no object": (forge(["HS256"], claims), Refusal.MALFORMED),
        "a header that is no text": (forge(b"\xff\xfe\x00", claims), Refusal.MALFORMED),
        "a header with a name twice": (forge(b'{"alg":"none","alg":"HS256"}', claims), Refusal.MALFORMED),
        "a header nested deeply": (forge(b"[" * 3000, claims), Refusal.MALFORMED),
        "alg none": (forge({"alg": "none"}, claims, b"x"), Refusal.ALGORITHM),
        "alg None": (forge({"alg": "None"}, claims), Refusal.ALGORITHM),
        "alg nOnE": (forge({"alg": "nOnE"}, claims), Refusal.ALGORITHM),
        "alg null": (forge({"alg": None}, claims), Refusal.ALGORITHM),
        "no alg": (forge({"typ": "JWT"}, claims), Refusal.ALGORITHM),
        "alg a list": (forge({"alg": ["HS256"]}, claims), Refusal.ALGORITHM),
        "alg hs256": (forge({"alg": "hs256"}, claims), Refusal.ALGORITHM),
        "alg HS256 with a space": (forge({"alg": "HS256 "}, claims), Refusal.ALGORITHM),
        "alg HS384": (forge({"alg": "HS384"}, claims), Refusal.ALGORITHM),
        "alg PS256": (forge({"alg": "PS256"}, claims, own.rsa), Refusal.ALGORITHM),
        "alg ES384": (forge({"alg": "ES384"}, claims, p384), Refusal.ALGORITHM),
        "HS256 with the public key as the secret": (forge(_HS, claims, public), Refusal.SIGNATURE),
        "HS256 with the public key without its line end": (forge(_HS, claims, public.strip()), Refusal.SIGNATURE),
        "HS256 with the public key in DER": (forge(_HS, claims, der), Refusal.SIGNATURE),
        "HS256 with an empty secret": (forge(_HS, claims, b""), Refusal.SIGNATURE),
        "HS256 with another secret": (forge(_HS, claims, "y" * 40), Refusal.SIGNATURE),
        "HS256 with the secret and its line end": (forge(_HS, claims, SECRET + "\n"), Refusal.SIGNATURE),
        "RS256 of another key": (forge({"alg": "RS256"}, claims, other.rsa), Refusal.SIGNATURE),
        "ES256 of another key": (forge({"alg": "ES256"}, claims, other.p256), Refusal.SIGNATURE),
        "ES256 of another curve": (forge({"alg": "ES256"}, claims, p384), Refusal.SIGNATURE),
        "ES256 signed with zeros": (f"{part({'alg': 'ES256'})}.{body}.{b64(bytes(64))}", Refusal.SIGNATURE),
        "ES256 with an RSA signature": (forge({"alg": "ES256"}, claims, own.rsa), Refusal.SIGNATURE),
        "EdDSA of another key": (forge({"alg": "EdDSA"}, claims, other.ed25519), Refusal.SIGNATURE),
        "EdDSA cut short": (issue(now, own.ed25519)[:-20], Refusal.SIGNATURE),
        "RS256 said, HS256 done": (forge({"alg": "RS256"}, claims), Refusal.SIGNATURE),
        "the signature of other claims": (
            f"{head}.{part({**claims, 'roles': ['administrator']})}.{mark}",
            Refusal.SIGNATURE,
        ),
        "the signature of another header": (f"{part({'alg': 'HS256'})}.{body}.{mark}", Refusal.SIGNATURE),
        "one bit of the signature": (f"{head}.{body}.{'A' if mark[0] != 'A' else 'B'}{mark[1:]}", Refusal.SIGNATURE),
        "crit of something unknown": (forge({**_HS, "crit": ["x"], "x": 1}, claims), Refusal.HEADER),
        "crit of nothing": (forge({**_HS, "crit": []}, claims), Refusal.HEADER),
        "crit b64": (forge({**_HS, "crit": ["b64"], "b64": False}, claims), Refusal.HEADER),
        "b64": (forge({**_HS, "b64": False}, claims), Refusal.HEADER),
        "a key in the header": (forge({"alg": "RS256", "jwk": jwk(other.rsa)}, claims, other.rsa), Refusal.HEADER),
        "the address of a key": (
            forge({"alg": "RS256", "jku": "https://e.example/k"}, claims, other.rsa),
            Refusal.HEADER,
        ),
        "the address of a certificate": (forge({**_HS, "x5u": "https://e.example/c"}, claims), Refusal.HEADER),
        "a certificate": (forge({**_HS, "x5c": ["MIIB"]}, claims), Refusal.HEADER),
        "encrypted": (forge({**_HS, "enc": "A128GCM"}, claims), Refusal.HEADER),
        "packed": (forge({**_HS, "zip": "DEF"}, claims), Refusal.HEADER),
        "something else than a token": (forge({**_HS, "typ": "dpop+jwt"}, claims), Refusal.HEADER),
        "typ a number": (forge({**_HS, "typ": 1}, claims), Refusal.HEADER),
        "kid a number": (forge({**_HS, "kid": 1}, claims), Refusal.HEADER),
        "kid an object": (forge({**_HS, "kid": {"a": 1}}, claims), Refusal.HEADER),
        "kid too long": (forge({**_HS, "kid": "k" * 300}, claims), Refusal.HEADER),
        "claims that are no JSON": (forge(_HS, b"{"), Refusal.MALFORMED),
        "claims that are a list": (forge(_HS, [claims]), Refusal.MALFORMED),
        "claims that are no text": (forge(_HS, b"\xff\xfe"), Refusal.MALFORMED),
        "claims with NaN": (forge(_HS, json.dumps({**claims, "exp": float("nan")}).encode()), Refusal.MALFORMED),
        "claims with Infinity": (forge(_HS, json.dumps({**claims, "exp": float("inf")}).encode()), Refusal.MALFORMED),
        "claims nested deeply": (forge(_HS, b"[" * 3000), Refusal.MALFORMED),
        "a claim twice": (forge(_HS, json.dumps(claims).encode()[:-1] + b',"sub":"root"}'), Refusal.MALFORMED),
        "a number with 4400 digits": (forge(_HS, b'{"exp":1' + b"0" * 4400 + b"}"), Refusal.MALFORMED),
    }
    for kid in ("../../etc/passwd", "' OR 1=1 --", "https://e.example/jwks", "/dev/null", "\x00", "$(id)"):
        table[f"kid {kid!r}"] = forge({**_HS, "kid": kid}, claims, b""), Refusal.SIGNATURE
    return table
