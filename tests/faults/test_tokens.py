"""F18 to F20: tokens that end, keys that are exchanged, an issuer that does not answer."""

import asyncio
import random
import time
from pathlib import Path
from typing import Any

import pytest
from aiohttp import web
from cryptography.hazmat.primitives.asymmetric import ed25519
from websockets.exceptions import InvalidStatus

from openrois.gateway import token_expiry
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.ground import turns
from tests.support.invariants import Book, Witness, calm, check_audit
from tests.support.seeds import ALL, SOME
from tests.support.tokens import claims_of, forge, issue, jwk, key_file
from tests.support.wall import WallClock


def bearer(token: str) -> dict[str, Any]:
    return {"additional_headers": {"Authorization": f"Bearer {token}"}}


def signed(key: ed25519.Ed25519PrivateKey, key_id: str) -> str:
    return forge({"alg": "EdDSA", "typ": "JWT", "kid": key_id}, claims_of(time.time()), key)


async def alive(*witnesses: Witness) -> None:
    for each in witnesses:
        assert await each.code("rois.system.get_profile", condition="") == "OK"


async def refused(book: Book, url: str, token: str) -> int:
    """Try a token and return the status that it is refused with."""
    with pytest.raises(InvalidStatus) as refusal:
        async with book.witness(url, **bearer(token)):
            pass
    return refusal.value.response.status_code


@pytest.mark.parametrize("seed", SOME)
async def test_f18_a_token_that_ends(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(token_expiry, "CHECK_INTERVAL", 0.02)
    chance, book, wall = random.Random(seed), Book(), WallClock()
    settings = GatewaySettings(port=0, auth_keys=(key_file(tmp_path),), audit_file=tmp_path / "audit.jsonl")
    with wall.everywhere():
        async with calm(caplog), run_gateway(settings) as gateway:
            ends = time.time() + 60
            async with book.witness(gateway.url, extended=True, **bearer(issue(time.time(), exp=ends))) as renews:
                fresh = issue(time.time())
                assert (await renews.ask("openrois.auth.refresh", token=fresh))["return_code"] == "OK"
                token = issue(time.time(), exp=ends, sub="late")
                async with book.witness(gateway.url, extended=chance.random() < 0.5, **bearer(token)) as late:
                    await alive(late)
                    for _ in range(chance.randrange(20)):
                        await late.begin("rois.system.connect")
                        await turns(chance)
                    wall.ahead = 60 + chance.random()
                    async with asyncio.timeout(5):
                        while not late.gone.is_set():
                            await turns(chance)
                            asked = await late.begin("rois.system.connect")
                            await asyncio.wait((asked,))
                    assert late.close_code == 4401
                await alive(renews)
    book.check()
    check_audit(tmp_path / "audit.jsonl", commands=0)


@pytest.mark.parametrize("seed", ALL)
async def test_f19_keys_that_are_exchanged(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    chance, book = random.Random(seed), Book()
    old, new = (f"canary-{name}-{seed}-0123456789-0123456789-0123456789" for name in ("old", "new"))
    settings = GatewaySettings(port=0, auth_keys=(key_file(tmp_path, old),), audit_file=tmp_path / "audit.jsonl")
    async with calm(caplog), run_gateway(settings) as gateway:
        before, after = issue(time.time(), old), issue(time.time(), new)
        async with book.witness(gateway.url, **bearer(before)) as app:
            assert await refused(book, gateway.url, after) == 401
            await turns(chance)
            key_file(tmp_path, new)
            gateway.reload()
            assert await refused(book, gateway.url, before) == 401
            async with book.witness(gateway.url, **bearer(after)) as other:
                await turns(chance)
                await alive(app, other)
            # What cannot be read changes nothing.
            (tmp_path / "key").write_text("short")
            gateway.reload()
            async with book.witness(gateway.url, **bearer(after)) as other:
                await alive(app, other)
    book.check()
    check_audit(tmp_path / "audit.jsonl", commands=0)


@pytest.mark.parametrize("seed", SOME)
async def test_f20_an_issuer_that_does_not_answer(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    chance, book = random.Random(seed), Book()
    known, unknown = ed25519.Ed25519PrivateKey.generate(), ed25519.Ed25519PrivateKey.generate()
    fails = chance.choice([500, 404, 200])
    up = True

    async def keys(_request: web.Request) -> web.Response:
        if not up:
            return web.Response(status=fails, text="out of order")
        return web.json_response({"keys": [jwk(known, kid="known")]})

    issuer = web.Application()
    issuer.router.add_get("/keys", keys)
    runner = web.AppRunner(issuer, access_log=None)
    async with calm(caplog):
        await runner.setup()
        try:
            await web.TCPSite(runner, "127.0.0.1", 0).start()
            url = f"http://127.0.0.1:{runner.addresses[0][1]}/keys"
            settings = GatewaySettings(port=0, auth_jwks=url, audit_file=tmp_path / "audit.jsonl")
            async with run_gateway(settings) as gateway:
                token = signed(known, "known")
                async with book.witness(gateway.url, **bearer(token)) as app:
                    up = False
                    for _ in range(chance.randint(1, 3)):
                        strange = signed(unknown, f"unknown{chance.random()}")
                        assert await refused(book, gateway.url, strange) in (401, 503)
                    async with book.witness(gateway.url, **bearer(token)) as other:
                        await alive(app, other)
        finally:
            await runner.cleanup()
    book.check()
    check_audit(tmp_path / "audit.jsonl", commands=0)
