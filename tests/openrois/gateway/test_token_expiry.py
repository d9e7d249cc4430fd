"""The end of a connection with its token: announced before, on time, put off by a new token of the same subject."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal, Role
from openrois.gateway import reloading, token_expiry
from openrois.gateway.renewal import REFRESH, Renewal
from openrois.gateway.token_expiry import TOKEN_ENDED, TokenExpiries, TokenExpiry
from openrois.observability.audit import Audit
from openrois.types.access import MAX_TOKEN
from tests.support.clock import Clock
from tests.support.forgeries import forgeries
from tests.support.guarded import ask, fresh, guarded
from tests.support.tokens import Keys

VIEWER = frozenset({Role.VIEWER})


class Connection:
    def __init__(self) -> None:
        self.closed: list[tuple[int, str]] = []

    async def close(self, code: int = 1000, reason: str = "") -> None:
        self.closed.append((code, reason))


class Watched:
    """Connections under a clock that is turned by hand."""

    def __init__(self, tasks: TaskScope) -> None:
        self.clock = Clock(1000.0)
        self.revoked: set[str] = set()
        self.audit = Audit()
        self.expiries = TokenExpiries(self.clock, lambda p: p.subject in self.revoked, self.audit, tasks)

    def at(self, now: float) -> None:
        self.clock.now = now
        self.expiries.check_tokens()


@asynccontextmanager
async def watched() -> AsyncIterator[Watched]:
    async with TaskScope() as tasks:
        yield Watched(tasks)


async def test_whatever_goes_wrong_in_one_session_all_end_in_their_time(caplog: pytest.LogCaptureFixture) -> None:
    def fail(_principal: Principal) -> None:
        raise ZeroDivisionError("a bug")

    async with watched() as here:
        expiries = [TokenExpiry(principal(1100), fail), TokenExpiry(principal(1100))]
        connections = [Connection(), Connection()]
        with here.expiries.holding(expiries[0], connections[0]), here.expiries.holding(expiries[1], connections[1]):
            here.at(1100)
            await asyncio.sleep(0)
            assert [len(connection.closed) for connection in connections] == [1, 1]
            assert [expiry.is_over for expiry in expiries] == [True, True]
            assert expiries[0].principal.roles == frozenset()
    assert "a bug" in caplog.text


def principal(expires: float | None, subject: str = "alice") -> Principal:
    return Principal(subject, VIEWER, ("*",), expires, "t1")


def noting(told: list[float]) -> Callable[[float], bool]:
    def note(seconds: float) -> bool:
        told.append(seconds)
        return True

    return note


async def test_a_connection_ends_with_its_token() -> None:
    async with watched() as here:
        seen: list[Principal] = []
        warnings: list[float] = []
        expiry = TokenExpiry(principal(1100), seen.append, noting(warnings))
        connection = Connection()
        with here.expiries.holding(expiry, connection):
            here.at(1039)
            assert not warnings
            here.at(1040)
            here.at(1041)
            assert warnings == [60]
            here.at(1099.9)
            assert not seen
            here.at(1100)
            # Before the connection is even closed it may nothing any more.
            assert [(p.subject, p.roles, p.scope) for p in seen] == [("alice", frozenset(), ())]
            assert expiry.is_over
            await asyncio.sleep(0)
            assert connection.closed == [(TOKEN_ENDED, "the token has expired")]
            here.at(1200)
            assert here.expiries.ended == here.audit.refusals == 1
    assert connection.closed == [(TOKEN_ENDED, "the token has expired")]


async def test_a_client_without_extensions_is_warned_after_its_hello() -> None:
    async with watched() as here:
        understood = False
        told: list[float] = []

        def tell(seconds: float) -> bool:
            told.append(seconds)
            return understood

        with here.expiries.holding(TokenExpiry(principal(1010), on_expiring=tell), Connection()):
            here.at(1001)
            here.at(1002)
            understood = True
            here.at(1003)
            here.at(1004)
        assert told == [9, 8, 7]


async def test_a_connection_ends_when_its_subject_is_revoked() -> None:
    async with watched() as here:
        alice, bob = Connection(), Connection()
        with (
            here.expiries.holding(TokenExpiry(principal(9999)), alice),
            here.expiries.holding(TokenExpiry(principal(None, "bob")), bob),
        ):
            here.at(1001)
            here.revoked.add("alice")
            here.at(1002)
            await asyncio.sleep(0)
            assert alice.closed == [(TOKEN_ENDED, "the token was revoked")]
            here.at(10**12)
        assert not bob.closed


async def test_a_new_token_makes_it_longer_and_warns_again() -> None:
    async with watched() as here:
        told: list[float] = []
        expiry = TokenExpiry(principal(1030), on_expiring=noting(told))
        connection = Connection()
        with here.expiries.holding(expiry, connection):
            here.at(1000)
            expiry.replace(principal(1200))
            here.at(1050)
            here.at(1150)
            here.at(1200)
            await asyncio.sleep(0)
        assert told == [30, 50]
        assert len(connection.closed) == 1


async def test_it_looks_every_second() -> None:
    async with TaskScope() as tasks:
        slept: list[float] = []
        enough = asyncio.Event()

        async def sleep(seconds: float) -> None:
            slept.append(seconds)
            if len(slept) == 3:
                enough.set()
                await asyncio.Event().wait()

        expiries = TokenExpiries(Clock(0), lambda _p: False, Audit(), tasks, sleep)
        tasks.start(expiries.watch())
        await enough.wait()
        assert slept == [1.0, 1.0, 1.0]


async def close_code(connection: ClientConnection) -> int:
    """Return the code with which a connection is closed."""

    async def listen() -> None:
        while True:
            await connection.recv()

    with pytest.raises(ConnectionClosed) as closed:
        await asyncio.wait_for(listen(), 10)
    assert closed.value.rcvd is not None
    return closed.value.rcvd.code


async def hello(connection: ClientConnection) -> None:
    assert (await ask(connection, "openrois.hello", version="1"))["result"]["return_code"] == "OK"


async def test_revoked_token_ends_session_and_is_refused_again(tmp_path: Path) -> None:
    revocations = tmp_path / "revoked"
    revocations.write_text("")
    async with guarded(tmp_path, auth_revocations=revocations) as coming:
        token = fresh(jti="t1")
        async with coming.dial(token) as connection, coming.dial(fresh(sub="bob", jti="t2")) as other:
            await hello(connection)
            revocations.write_text("# today\njti t1\n")
            assert await close_code(connection) == TOKEN_ENDED
            await hello(other)
        with pytest.raises(Exception, match="401"):
            await coming.dial(token)
        revocations.write_text("nonsense\n")
        coming.gateway.reload()
        with pytest.raises(Exception, match="401"):
            await coming.dial(token)


async def test_what_is_revoked_ends_as_soon_as_that_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module, name in ((token_expiry, "CHECK_INTERVAL"), (reloading, "LOOK_INTERVAL")):
        monkeypatch.setattr(module, name, 3600.0)
    revocations = tmp_path / "revoked"
    revocations.write_text("")
    async with guarded(tmp_path, auth_revocations=revocations) as coming, coming.dial(fresh(jti="t1")) as connection:
        await hello(connection)
        revocations.write_text("jti t1\n")
        coming.gateway.reload()
        assert await close_code(connection) == TOKEN_ENDED


async def refresh(connection: ClientConnection, token: str) -> dict[str, Any]:
    result: dict[str, Any] = (await ask(connection, "openrois.auth.refresh", token=token))["result"]
    return result


async def test_a_connection_that_has_ended_is_not_made_longer_by_a_token_that_was_on_its_way() -> None:
    """Keys may have to be fetched, which takes seconds; meanwhile the present token ends, or is revoked."""
    asked, known = asyncio.Event(), asyncio.Event()

    async def verify_slowly(_token: str) -> Principal:
        asked.set()
        await known.wait()
        return principal(9999)

    async with watched() as here:
        seen: list[Principal] = []
        expiry = TokenExpiry(principal(1100), seen.append)
        renewal = Renewal(verify_slowly, here.clock, here.audit)
        handler = renewal.method(expiry, lambda _principal: True, lambda _reason: None)[REFRESH]
        with here.expiries.holding(expiry, Connection()):
            renewing = asyncio.ensure_future(handler({"token": "x.y.z"}))
            await asked.wait()
            here.at(1100)
            known.set()
            assert (await renewing).result.return_code == "BAD_PARAMETER"
    assert [(p.subject, p.roles) for p in seen] == [("alice", frozenset())]
    assert expiry.principal.roles == frozenset()


async def test_a_new_token_on_the_same_connection(tmp_path: Path) -> None:
    async with guarded(tmp_path) as coming, coming.dial(fresh(exp=time.time() + 60, jti="old")) as connection:
        await hello(connection)
        refused, asked = {"return_code": "BAD_PARAMETER", "seconds": 0}, 0
        for bad in ("x", fresh(sub="bob"), fresh(exp=1), fresh(roles="adapter"), fresh(roles="root")):
            assert await refresh(connection, bad) == refused
            asked += 1
        for forged, _ in forgeries(Keys(), time.time()).values():
            if 0 < len(forged) <= MAX_TOKEN:
                assert await refresh(connection, forged) == refused
                asked += 1
        assert (await ask(connection, "openrois.auth.refresh", token="x" * 7000))["error"]["code"] == -32602
        answer = await refresh(connection, fresh(jti="new", roles="viewer"))
        assert answer["return_code"] == "OK"
        assert 800 < answer["seconds"] <= 900
        # Its roles are those of the new token, at once.
        answer = await ask(connection, "rois.command.bind", component_ref="x/y")
        assert answer["result"]["return_code"] == "UNSUPPORTED"
    lines = coming.audited()
    assert [line["kind"] for line in lines if line["method"] == "openrois.auth.refresh"] == ["refused"] * asked + [
        "acted"
    ]
    assert {"algorithm", "header", "signature"} <= {line.get("reason") for line in lines}
    refreshed = [(line.get("detail"), line["token_id"]) for line in lines if line["kind"] == "acted"]
    assert refreshed == [("in place of old", "new")]
    assert {"malformed", "subject", "expired", "role", "claim"} <= {line.get("reason") for line in lines}
