"""Adapters and applications that bring tokens: over TLS, and a newer one before the present one ends."""

import asyncio
import json
import time
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from openrois.adapter import serve
from openrois.client import Client
from openrois.client.errors import ConnectionFailed
from openrois.errors import OutOfResources
from tests.support.certificates import Authority
from tests.support.components import Lamp
from tests.support.guarded import Guarded, ask, fresh, guarded
from tests.support.tokens import SECRET


async def until_acted(coming: Guarded, count: int) -> list[str]:
    """Wait until so many tokens were renewed, and return their ids."""
    async with asyncio.timeout(10):
        while True:
            renewed = [line["token_id"] for line in coming.audited() if line["method"] == "openrois.auth.refresh"]
            if len(renewed) >= count:
                return renewed
            await asyncio.sleep(0.05)


async def test_an_adapter_over_tls_shows_its_newest_token(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    cert, key = authority.issue()
    token = tmp_path / "token"
    mine: dict[str, object] = {"sub": "robot", "roles": "adapter", "scope": "robot/*"}
    token.write_text(fresh(**mine, jti="first", exp=time.time() + 30))
    async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
        attached = asyncio.Event()
        coming.gateway.engine.on_change(attached.set)
        async with serve(
            Lamp(), engine_id="robot", gateway=coming.gateway.url, token_file=token, ca_file=authority.file
        ):
            await asyncio.wait_for(attached.wait(), 10)
            token.write_text(fresh(**mine, jti="second"))
            assert await until_acted(coming, 1) == ["second"]
            assert coming.gateway.engine.directory.profile.engine_ids() == ("gateway", "robot")


async def test_an_application_shows_its_newest_token(tmp_path: Path) -> None:
    tokens = iter(
        [fresh(jti="t1", exp=time.time() + 30), fresh(jti="t2"), fresh(jti="t3")],
    )
    async with guarded(tmp_path) as coming, Client(coming.gateway.url, token=lambda: next(tokens)) as client:
        assert await until_acted(coming, 1) == ["t2"]
        assert (await client.get_profile()).profile is not None


async def test_what_an_application_is_told_without_a_good_token(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    def nothing() -> str:
        raise ValueError("the token cannot be read from here")

    async with guarded(tmp_path) as coming:
        for token, words in (
            (None, "401: a valid token is needed"),
            ("canary.canary.canary", "401: a valid token is needed"),
            (fresh(roles="adapter"), "403: the token is not for this"),
            (nothing, "cannot be read from here"),
        ):
            with pytest.raises(ConnectionFailed, match=words) as failed:
                async with Client(coming.gateway.url, token=token):
                    pass
            assert "canary" not in str(failed.value)
    assert SECRET not in caplog.text


async def test_a_certificate_without_a_known_authority(tmp_path: Path) -> None:
    cert, key = Authority(tmp_path).issue()
    (tmp_path / "other").mkdir()
    stranger = Authority(tmp_path / "other")
    async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
        for ca_file in (None, stranger.file):
            with pytest.raises(ConnectionFailed, match="its certificate is not trusted"):
                async with Client(coming.gateway.url, token=fresh(), ca_file=ca_file):
                    pass


async def test_what_an_operator_has_bound_is_free_when_its_token_ends(tmp_path: Path) -> None:
    async with guarded(tmp_path) as coming:
        (tmp_path / "token").write_text(fresh(sub="robot", roles="adapter", scope="robot/*"))
        attached = asyncio.Event()
        coming.gateway.engine.on_change(attached.set)
        async with (
            serve(Lamp(), engine_id="robot", gateway=coming.gateway.url, token_file=tmp_path / "token"),
            Client(coming.gateway.url, token=fresh(sub="bob")) as bob,
        ):
            await asyncio.wait_for(attached.wait(), 10)
            async with coming.dial(fresh(exp=time.time() + 2)) as alice:
                for method in ("rois.system.connect", "openrois.hello"):
                    await ask(alice, method, **({"version": "1"} if method == "openrois.hello" else {}))
                assert (await ask(alice, "rois.command.bind", component_ref="robot/lamp"))["result"] == OK
                # A session that can be resumed keeps what it has for a while when its connection is lost.
                assert (await ask(alice, "openrois.lease.token"))["result"]["return_code"] == "OK"
                with pytest.raises(OutOfResources):
                    await bob.bind("robot/lamp")
                told: list[dict[str, Any]] = []
                with pytest.raises(ConnectionClosed) as closed:
                    await asyncio.wait_for(hear(alice, told), 10)
                assert closed.value.rcvd is not None
                assert closed.value.rcvd.code == 4401
                (expiring,) = (message for message in told if message["method"] == "openrois.auth.expiring")
                assert 0 <= expiring["params"]["seconds"] <= 2
            await bob.bind("robot/lamp")


OK = {"return_code": "OK"}


async def hear(connection: ClientConnection, told: list[dict[str, Any]]) -> None:
    while True:
        told.append(json.loads(await connection.recv()))
