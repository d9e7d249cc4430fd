"""The issuer's keys: one fetch for many, seldom, bounded, and good for a while without the issuer."""

import asyncio
import json
import random
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from aiohttp import web

from openrois.aio.tasks import TaskScope
from openrois.auth.claims import ClaimRules
from openrois.auth.jwks import KeySetCache, fetch_from_file, fetch_from_url
from openrois.auth.keys import MAX_KEY_FILE, KeysUnavailable
from openrois.auth.refusal import Refusal, TokenRefused
from openrois.auth.tokens import TokenVerifier
from tests.support.clock import Clock
from tests.support.tokens import Keys, claims_of, forge, jwk

pytestmark = pytest.mark.extra(name="gateway")

KEYS = Keys()
NOW = 1_700_000_000.0


def key_set(*kids: str) -> str:
    return json.dumps({"keys": [jwk(KEYS.p256, kid=kid) for kid in kids]})


class Issuer:
    """Answers with the keys that it has now; down when it has none."""

    def __init__(self, *kids: str) -> None:
        self.kids = kids
        self.asked = 0

    async def __call__(self) -> str:
        self.asked += 1
        await asyncio.sleep(0)
        if not self.kids:
            raise ValueError("the issuer is down")
        return key_set(*self.kids)


@asynccontextmanager
async def cached(issuer: Issuer) -> AsyncIterator[tuple[KeySetCache, Clock]]:
    clock = Clock(1000.0)
    async with TaskScope() as tasks:
        yield KeySetCache(issuer, clock, tasks), clock


async def test_a_key_is_looked_up() -> None:
    issuer = Issuer("a", "b")
    async with cached(issuer) as (cache, _):
        assert [key.algorithm for key in await cache.find("a")] == ["ES256"]
        assert await cache.find("b")
        assert await cache.find("c") == ()
        assert issuer.asked == 1


async def test_ten_thousand_names_cause_one_fetch() -> None:
    issuer, chance = Issuer("a"), random.Random(6)
    async with cached(issuer) as (cache, clock):
        verifier = TokenVerifier(cache, ClaimRules(), lambda: NOW)
        claims = claims_of(NOW)

        async def storm(count: int) -> None:
            for _ in range(count):
                token = forge({"alg": "ES256", "kid": f"../{chance.getrandbits(64):x}"}, claims, b"x")
                with pytest.raises(TokenRefused) as refused:
                    await verifier.verify(token)
                assert refused.value.reason is Refusal.UNKNOWN_KEY

        await asyncio.gather(*(storm(100) for _ in range(100)))
        assert (issuer.asked, cache.fetches) == (1, 1)
        clock.now += 29.9
        await storm(10)
        assert issuer.asked == 1
        clock.now += 0.2
        await asyncio.gather(*(storm(10) for _ in range(10)))
        assert issuer.asked == 2
        good = forge({"alg": "ES256", "kid": "a"}, claims, KEYS.p256)
        assert (await verifier.verify(good)).subject == "alice"


async def test_a_new_key_is_found_within_the_pause() -> None:
    issuer = Issuer("a")
    async with cached(issuer) as (cache, clock):
        assert await cache.find("a")
        issuer.kids = ("b",)
        assert await cache.find("b") == ()
        clock.now += 30
        assert await cache.find("b")
        assert await cache.find("a") == ()


async def test_while_the_issuer_is_down_its_keys_hold_for_an_hour() -> None:
    issuer = Issuer("a")
    async with cached(issuer) as (cache, clock):
        assert await cache.find("a")
        issuer.kids = ()
        for _ in range(59):
            clock.now += 60
            assert await cache.find("a")
            await asyncio.sleep(0)
        assert cache.failures > 20
        clock.now += 60
        with pytest.raises(KeysUnavailable):
            await cache.find("a")
        issuer.kids = ("a",)
        clock.now += 30
        assert await cache.find("a")


async def test_a_known_key_does_not_wait_for_the_issuer() -> None:
    issuer = Issuer("a")
    async with cached(issuer) as (cache, clock):
        await cache.find("a")
        clock.now += 301
        hanging = asyncio.Event()

        async def hang() -> str:
            await hanging.wait()
            return key_set("a")

        cache._fetch = hang
        assert await cache.find("a")
        waiting = asyncio.ensure_future(cache.find("new"))
        await asyncio.sleep(0)
        assert not waiting.done()
        hanging.set()
        assert await waiting == ()


async def test_a_cancelled_caller_does_not_end_the_fetch_of_others() -> None:
    issuer = Issuer("a")
    async with cached(issuer) as (cache, _):
        first, second = asyncio.ensure_future(cache.find("a")), asyncio.ensure_future(cache.find("a"))
        await asyncio.sleep(0)
        first.cancel()
        assert await second


@asynccontextmanager
async def serving(answer: Callable[[web.Request], web.StreamResponse]) -> AsyncIterator[str]:
    async def handle(request: web.Request) -> web.StreamResponse:
        return answer(request)

    app = web.Application()
    app.router.add_get("/{path:.*}", handle)
    runner = web.AppRunner(app)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    try:
        yield f"http://127.0.0.1:{runner.addresses[0][1]}/jwks"
    finally:
        await runner.cleanup()


async def test_over_http() -> None:
    async with serving(lambda _request: web.Response(text=key_set("a"))) as url:
        assert await fetch_from_url(url)() == key_set("a")


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (lambda _: web.Response(status=500), "answered 500"),
        (lambda _: web.Response(status=302, headers={"Location": "http://169.254.169.254/"}), "answered 302"),
        (lambda _: web.Response(body=b"x" * (MAX_KEY_FILE + 1)), "more than"),
        (lambda _: web.Response(body=b"\xff"), "cannot be fetched"),
    ],
)
async def test_what_an_issuer_may_not_answer(answer: Callable[[web.Request], web.Response], words: str) -> None:
    async with serving(answer) as url:
        with pytest.raises(ValueError, match=words):
            await fetch_from_url(url)()


async def test_an_issuer_that_is_not_there() -> None:
    async with serving(lambda _: web.Response()) as url:
        pass
    with pytest.raises(ValueError, match="cannot be fetched"):
        await fetch_from_url(url)()


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("http://issuer.example/jwks", "give an https address"),
        ("http://127.0.0.1.issuer.example/jwks", "give an https address"),
        ("file:///etc/passwd", "no https"),
        ("https://", "no https"),
        ("issuer.example", "no https"),
        ("https://user:pass@issuer.example/", "password"),
        ("https://[::1", "no address"),
    ],
)
def test_where_keys_may_not_come_from(url: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        fetch_from_url(url)


async def test_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "jwks.json"
    with pytest.raises(ValueError, match="cannot be read"):
        await fetch_from_file(path)()
    path.write_text(key_set("a"))
    assert await fetch_from_file(path)() == key_set("a")
