"""Tokens of applications whose bodies are at another gateway: what changes here holds there."""

import asyncio
import json
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

from openrois.auth.principal import LOCAL, Principal, Role
from openrois.errors import EngineUnreachable
from openrois.federation.assertion import Assertion
from openrois.federation.sub_sessions import PRINCIPAL
from openrois.gateway.token_expiry import TokenExpiries
from openrois.jsonrpc.session import RpcSession
from openrois.transport.credentials import Credentials
from openrois.transport.stream import StreamClosed
from tests.support.cluster import seen_by
from tests.support.deployment import Application, application, patience
from tests.support.guarded import fresh
from tests.support.nats import NatsServer
from tests.support.place import Place, owned_by, place_of, unit
from tests.support.postgres import Server
from tests.support.tokens import key_file

pytestmark = pytest.mark.extra(name="cluster")


def headers(token: str) -> dict[str, Any]:
    return {"additional_headers": {"Authorization": f"Bearer {token}"}}


class Guarded:
    """Two gateways that ask for tokens, and the file of what is revoked."""

    def __init__(self, place: Place, revoked: Path) -> None:
        self.place = place
        self.revoked = revoked

    async def app(self, gateway_id: str, **claims: object) -> Application:
        """Connect an application with a token of its own, and wait until it sees the robot."""
        app = await self.place.stack.enter_async_context(
            application(self.place.gateway(gateway_id), **headers(fresh(**claims)))
        )
        await app.ask("openrois.hello", version="1", extensions=["openrois.lease"])
        await seen_by(app, "robot")
        return app


@pytest.fixture
async def guarded(shared_nats: NatsServer, postgres_server: Server, tmp_path: Path) -> AsyncIterator[Guarded]:
    revoked = tmp_path / "revoked"
    revoked.write_text("")
    settings = {"auth_keys": (key_file(tmp_path),), "auth_revocations": revoked}
    async with place_of(shared_nats, postgres_server, "a", "b", **settings) as place:
        token = tmp_path / "token"
        token.write_text(fresh(sub="robot", roles=["adapter"], scope=["robot/*"]))
        token.chmod(0o600)
        await place.wander("a", credentials=Credentials.of_files(token, None))
        await owned_by(place, "a")
        yield Guarded(place, revoked)


OPERATOR = {"roles": ["operator"], "scope": ["robot/*"]}


async def test_a_scope_holds_at_another_gateway(guarded: Guarded) -> None:
    app = await guarded.app("b", sub="ann", roles=["operator"], scope=["robot/lamp"])
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    why = await app.why("rois.command.get_parameter", component_ref="robot/door")
    assert why == ("UNSUPPORTED", "there is no component 'robot/door'")
    viewer = await guarded.app("b", sub="eve", roles=["viewer"], scope=["robot/*"])
    assert (await viewer.why("rois.command.bind", component_ref="robot/lamp"))[0] == "UNSUPPORTED"


async def test_a_new_token_with_less_in_it_takes_away_what_is_held_elsewhere(guarded: Guarded) -> None:
    app, other = await guarded.app("b", sub="ann", **OPERATOR), await guarded.app("a", sub="bob", **OPERATOR)
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    assert await other.code("rois.command.bind", component_ref="robot/lamp") == "OUT_OF_RESOURCES"
    token = fresh(sub="ann", roles=["operator"], scope=["robot/bell"])
    assert await app.code("openrois.auth.refresh", token=token) == "OK"
    await other.eventually("OK", "rois.command.bind", component_ref="robot/lamp")
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "UNSUPPORTED"


async def test_a_revoked_subject_holds_nothing_anywhere(guarded: Guarded) -> None:
    app, other = await guarded.app("b", sub="ann", **OPERATOR), await guarded.app("a", sub="bob", **OPERATOR)
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "start")]) == "OK"
    guarded.revoked.write_text("sub ann\n")
    for gateway_id in ("a", "b"):
        guarded.place.gateway(gateway_id).reload()
    async with patience():
        await app.socket.wait_closed()
    assert app.socket.close_code == 4401
    await other.eventually("OK", "rois.command.bind", component_ref="robot/lamp")


async def test_the_end_of_a_token_is_judged_by_the_gateway_that_took_it(
    guarded: Guarded, monkeypatch: pytest.MonkeyPatch
) -> None:
    check, checking, both = TokenExpiries.check_tokens, set[TokenExpiries](), asyncio.Event()

    def note(expiries: TokenExpiries) -> None:
        check(expiries)
        checking.add(expiries)
        if len(checking) == 2:
            both.set()

    # By the clock of that gateway it is good; that of the owner is ahead.
    ann = Principal("ann", frozenset({Role.OPERATOR}), ("robot/*",), expires=time.time() - 3000)
    federation = guarded.place.gateway("b").federation
    assert federation is not None
    session = RpcSession(await federation.dial("a", Assertion.of(ann)))
    async with asyncio.TaskGroup() as tasks:
        tasks.create_task(session.run())
        assert (await session.call("rois.command.bind", {"component_ref": "robot/lamp"}))["return_code"] == "OK"
        monkeypatch.setattr(TokenExpiries, "check_tokens", note)
        async with patience():
            await both.wait()
        assert (await session.call("rois.command.bind", {"component_ref": "robot/lamp"}))["return_code"] == "OK"
        await session.close()


async def test_a_gateway_without_tokens_opens_nothing_at_one_with_them(
    guarded: Guarded, caplog: pytest.LogCaptureFixture
) -> None:
    federation = guarded.place.gateway("b").federation
    assert federation is not None
    with pytest.raises(EngineUnreachable, match="asks for tokens and that one does not: give both the same keys"):
        await federation.dial("a", Assertion.of(LOCAL))
    assert "another gateway asks for a session in vain" in caplog.text


async def test_a_principal_that_is_not_understood_ends_what_was_asserted_before(guarded: Guarded) -> None:
    federation = guarded.place.gateway("b").federation
    assert federation is not None
    ann = Assertion.of(Principal("ann", frozenset({Role.OPERATOR}), ("robot/*",)))
    stream = await federation.dial("a", ann)
    said = {"jsonrpc": "2.0", "method": PRINCIPAL, "params": {**ann.hello(), "roles": ["viewer of tomorrow"]}}
    await stream.send(json.dumps(said))
    async with patience():
        with pytest.raises(StreamClosed):
            await stream.receive()
