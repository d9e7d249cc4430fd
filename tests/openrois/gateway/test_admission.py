"""Admission: tokens by header and by subprotocol, roles and paths, hosts and origins; and what a refusal shows."""

import asyncio
import json
import logging
import time
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from openrois.gateway import admission
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.forgeries import forgeries
from tests.support.guarded import Guarded, ask, fresh, guarded
from tests.support.tokens import SECRET, Keys

pytestmark = pytest.mark.extra(name="gateway")

V1 = "openrois.v1"
NOT_FOR_THIS = b"the token is not for this: adapters need the role adapter, applications another\n"


async def refused(coming: Guarded, *arguments: Any, **how: Any) -> tuple[int, bytes]:
    with pytest.raises(InvalidStatus) as answer:
        async with coming.dial(*arguments, **how):
            pass
    return answer.value.response.status_code, bytes(answer.value.response.body or b"")


def said_by_us(caplog: pytest.LogCaptureFixture) -> str:
    """Return what the gateway's side logs; the client of these tests logs what it sends."""
    return "".join(record.getMessage() for record in caplog.records if not record.name.startswith("websockets"))


async def test_a_token_in_the_header_or_beside_the_subprotocol(tmp_path: Path) -> None:
    async with guarded(tmp_path, allow_origins=("https://app.example.org",)) as coming:
        token = fresh()
        async with coming.dial(token) as connection:
            assert connection.subprotocol is None
            assert (await ask(connection, "rois.system.connect"))["result"] == {"return_code": "OK"}
        page = "https://app.example.org"
        async with coming.dial(offered=(V1, f"openrois.bearer.{token}"), origin=page) as connection:
            assert connection.subprotocol == V1
            assert (await ask(connection, "rois.system.connect"))["result"] == {"return_code": "OK"}
        async with coming.dial(token, headers={"authorization-x": "y"}, offered=(V1,)) as connection:
            assert connection.subprotocol == V1
        async with coming.dial(token, origin=coming.gateway.url.rstrip("/")) as connection:
            assert (await ask(connection, "rois.system.connect"))["result"] == {"return_code": "OK"}


async def test_a_page_learns_whether_its_token_is_taken(tmp_path: Path) -> None:
    tried = [(401, {}), (401, {"Authorization": "Bearer x.y.z"}), (200, {"Authorization": f"Bearer {fresh()}"})]
    tried.append((403, {"Authorization": f"Bearer {fresh(roles='adapter')}"}))
    async with guarded(tmp_path) as coming, aiohttp.ClientSession() as session:
        for status, headers in tried:
            async with session.get(f"{coming.gateway.url}admitted", headers=headers) as answer:
                assert answer.status == status
                if status == 200:
                    assert await answer.json() == {"status": "ok", "tokens": True}


@pytest.mark.parametrize("blank", ["\u00a0", "\u0085", "\u2003", "\u3000"])
async def test_a_token_with_a_blank_that_is_none_of_a_header(blank: str, tmp_path: Path) -> None:
    """Only spaces and tabs stand around the value of a header (RFC 9110 section 5.6.3)."""
    token = fresh()
    tried = [
        {"Authorization": f"Bearer {token}{blank}"},
        {"Authorization": f"Bearer {blank}{token}"},
        {"Sec-WebSocket-Protocol": f"{V1}, openrois.bearer.{token}{blank}"},
        {"Sec-WebSocket-Protocol": f"{V1}, {blank}openrois.bearer.{token}"},
    ]
    async with guarded(tmp_path) as coming, aiohttp.ClientSession() as session:
        origin = {"Origin": coming.gateway.url.rstrip("/")}
        for headers in tried:
            async with session.get(f"{coming.gateway.url}admitted", headers=headers | origin) as answer:
                assert answer.status in (400, 401), headers
        for headers in (
            {"Authorization": f"Bearer  {token} \t"},
            {"Sec-WebSocket-Protocol": f"{V1},\topenrois.bearer.{token} "},
        ):
            async with session.get(f"{coming.gateway.url}admitted", headers=headers | origin) as answer:
                assert answer.status == 200, headers


async def test_a_page_learns_that_no_token_counts() -> None:
    settings = GatewaySettings(port=0)
    async with run_gateway(settings) as gateway, aiohttp.ClientSession() as session:
        headers = {"Authorization": f"Bearer {fresh(roles='viewer')}"}
        async with session.get(f"{gateway.url}admitted", headers=headers) as answer:
            assert await answer.json() == {"status": "ok", "tokens": False}


async def test_strangers_all_get_the_same_answer(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    keys = Keys()
    table = forgeries(keys, time.time())
    usable = {name: pair for name, pair in table.items() if pair[0].isprintable() and pair[0] == pair[0].strip()}
    with caplog.at_level(logging.DEBUG):
        async with guarded(tmp_path) as coming:
            answers = {await refused(coming)}
            for token, _ in usable.values():
                if len(token) < 7000:
                    answers.add(await refused(coming, token))
            answers.add(await refused(coming, fresh(exp=True)))
            answers.add(await refused(coming, headers={"Authorization": "Basic dTpw"}))
            answers.add(await refused(coming, fresh(), offered=(V1, f"openrois.bearer.{fresh()}")))
            assert answers == {(401, b"a valid token is needed\n")}
    reasons = {line.get("reason") for line in coming.audited()}
    assert {"missing", "malformed", "algorithm", "signature", "header", "claim"} <= reasons
    said = said_by_us(caplog) + json.dumps(coming.audited())
    for token, _ in usable.values():
        assert len(token) < 20 or token not in said
    assert SECRET not in said


@pytest.mark.parametrize("path", ["", "adapter", "anything"])
async def test_a_token_in_the_address(path: str, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    token = fresh()
    queries = (f"token={token}", f"access_token={token}", "TOKEN=x", f"x={token}", f"{token}", f"x=1&bearer={token}")
    with caplog.at_level(logging.DEBUG):
        async with guarded(tmp_path) as coming:
            for query in queries:
                status, body = await refused(coming, token, path=f"{path}?{query}")
                assert status == 400
                assert token.encode() not in body
            async with aiohttp.ClientSession() as session:
                for page in ("", "healthz", "openrpc.json", "adapter"):
                    async with session.get(f"{coming.gateway.url}{page}", params={"token": token}) as response:
                        assert response.status == 400
                        assert token not in await response.text()
    assert token not in said_by_us(caplog)
    assert token not in (tmp_path / "audit.jsonl").read_text()


@pytest.mark.parametrize(
    ("roles", "application", "adapter"),
    [
        (["viewer"], True, False),
        (["maintenance"], True, False),
        (["operator"], True, False),
        (["administrator"], True, True),
        (["adapter"], False, True),
        (["adapter", "viewer"], True, True),
    ],
)
async def test_roles_and_paths(roles: list[str], application: bool, adapter: bool, tmp_path: Path) -> None:
    async with guarded(tmp_path) as coming:
        for path, fits in (("", application), ("elsewhere", application), ("adapter", adapter), ("adapter?x", adapter)):
            if fits:
                async with coming.dial(fresh(roles=roles), path=path):
                    pass
            else:
                assert await refused(coming, fresh(roles=roles), path=path) == (403, NOT_FOR_THIS)


async def test_origins_and_hosts(tmp_path: Path) -> None:
    async with guarded(tmp_path, allow_origins=("https://app.example.org",), allow_hosts=("gw.example.org",)) as coming:
        token = fresh()
        bearer = (V1, f"openrois.bearer.{token}")
        for origin in ("null", "https://evil.example", "https://evil-app.example.org", "http://app.example.org"):
            assert (await refused(coming, token, origin=origin))[0] == 403
            assert (await refused(coming, offered=bearer, origin=origin))[0] == 403
        # A client that offers a token as browsers do, without an origin, is no browser.
        assert (await refused(coming, offered=bearer))[0] == 403
        for alone in (bearer[1], bearer[1].upper(), f"x{bearer[1]}", token):
            assert (await refused(coming, offered=(alone,), origin="https://app.example.org"))[0] == 400
        async with aiohttp.ClientSession() as session:
            for host, status in (("gw.example.org", 200), ("GW.example.org:1", 200), ("evil.example", 403), ("", 403)):
                async with session.get(f"{coming.gateway.url}openrpc.json", headers={"Host": host}) as response:
                    assert response.status == status, host
                # A supervisor has names of its own for the gateway.
                async with session.get(f"{coming.gateway.url}healthz", headers={"Host": host}) as response:
                    assert response.status == 200
            for twice in ("https://app.example.org", "https://evil.example"):
                headers = [("Origin", "https://app.example.org"), ("Origin", twice)]
                async with session.get(f"{coming.gateway.url}healthz", headers=headers) as response:
                    assert response.status == 403


async def test_without_authentication_this_machine_alone_is_answered(tmp_path: Path) -> None:
    async with guarded(tmp_path, auth_keys=()) as coming:
        async with coming.dial(origin="http://localhost:5173") as connection:
            assert (await ask(connection, "rois.system.connect"))["result"] == {"return_code": "OK"}
            answer = await ask(connection, "openrois.auth.refresh", token=fresh())
            assert answer["result"]["return_code"] == "UNSUPPORTED"
        async with coming.dial(offered=(V1, "openrois.bearer.whatever")) as connection:
            assert connection.subprotocol == V1
        assert (await refused(coming, origin="https://app.example.org"))[0] == 403


async def test_scope_is_enforced_from_the_first_message(tmp_path: Path) -> None:
    async with guarded(tmp_path) as coming, coming.dial(fresh(roles="viewer")) as connection:
        answer = await ask(connection, "rois.command.bind", component_ref="lamp_1/lamp")
        assert answer["result"]["return_code"] == "UNSUPPORTED"


async def offer(coming: Guarded, token: str, engine_id: str, *names: str) -> ConnectionClosed | None:
    """Come as an adapter; return how it was refused."""
    async with coming.dial(token, path="adapter") as connection:
        refs = [f"{engine_id}/{name}" for name in names]
        profile = {"identifier": {"code": engine_id}, "component_ids": refs}
        described = {ref: {"name": "a lamp", "identifier": {"code": "urn:x:lamp"}} for ref in refs}
        try:
            while True:
                asked = json.loads(await connection.recv())
                if asked["method"] == "rois.system.get_profile":
                    result: dict[str, Any] = {"return_code": "OK", "profile": profile, "component_profiles": described}
                    await connection.send(json.dumps({"jsonrpc": "2.0", "id": asked["id"], "result": result}))
                elif asked["method"] == "openrois.hello":
                    error = {"code": -32601, "message": "Method not found"}
                    await connection.send(json.dumps({"jsonrpc": "2.0", "id": asked["id"], "error": error}))
        except ConnectionClosed as closed:
            return closed


@pytest.mark.parametrize(
    ("roles", "scope", "names", "accepted"),
    [
        ("adapter", ["lamp_1/*"], ("lamp", "bell"), True),
        ("adapter", ["lamp_1/lamp"], ("lamp",), True),
        ("adapter", ["lamp_1/lamp"], ("lamp", "bell"), False),
        ("adapter", ["lamp_2/*"], ("lamp",), False),
        ("adapter", [], ("lamp",), False),
        ("adapter", ["lamp_1/lamp"], (), False),
        ("adapter", ["lamp_1/*"], (), True),
        ("administrator", ..., ("lamp",), True),
        ("administrator", ["lamp_2/*"], ("lamp",), False),
    ],
)
async def test_an_adapter_offers_what_its_token_is_for(
    roles: str, scope: object, names: tuple[str, ...], accepted: bool, tmp_path: Path
) -> None:
    async with guarded(tmp_path) as coming:
        attached = asyncio.Event()
        coming.gateway.engine.on_change(attached.set)
        coming_in = asyncio.ensure_future(offer(coming, fresh(sub="lamp", roles=roles, scope=scope), "lamp_1", *names))
        waiting = asyncio.ensure_future(attached.wait())
        await asyncio.wait({coming_in, waiting}, timeout=10, return_when=asyncio.FIRST_COMPLETED)
        if accepted:
            assert attached.is_set()
            coming_in.cancel()
        else:
            closed = await coming_in
            assert closed is not None
            assert closed.rcvd is not None
            assert closed.rcvd.code == 1008
            assert "out of the scope" in closed.rcvd.reason
            assert not attached.is_set()
        waiting.cancel()


async def test_a_flood_of_strangers_does_not_fill_the_trail(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(admission, "REFUSED_AT_ONCE", 3)
    monkeypatch.setattr(admission, "REFUSED_PER_SECOND", 0.0001)
    async with guarded(tmp_path) as coming:
        for _ in range(10):
            await refused(coming)
        # Refusals with a genuine token are not hidden by them.
        await refused(coming, fresh(iat=1, exp=2))
    assert [(line["reason"], line.get("who")) for line in coming.audited()] == [("missing", None)] * 3 + [
        ("expired", "alice")
    ]
