"""STOP by a person, and the hand-back, from any gateway of a cluster; the latch goes with the body."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from openrois.cluster import presence, pulse
from openrois.transport.credentials import Credentials
from tests.openrois.federation.test_losses import lacking
from tests.openrois.federation.test_tokens import OPERATOR, Guarded
from tests.support.cluster import seen_by
from tests.support.deployment import Application, patience
from tests.support.guarded import fresh
from tests.support.nats import NatsServer, nats_server
from tests.support.place import owned_by, place_of, unit
from tests.support.postgres import Server
from tests.support.tokens import key_file

pytestmark = pytest.mark.extra(name="cluster")

LAMP = {"component_ref": "robot/lamp"}
ROBOT = {"engine_id": "robot"}
WAITS = "robot was stopped by ann: programs wait until a person hands it back"
SILENCE = presence.SILENCE
REFUSED = ("OUT_OF_RESOURCES", WAITS)


@asynccontextmanager
async def guarded_by(nats: NatsServer, postgres: Server, tmp_path: Path) -> AsyncIterator[Guarded]:
    """Run two gateways that ask for tokens, and a robot that dials the first, or else the second."""
    async with place_of(nats, postgres, "a", "b", auth_keys=(key_file(tmp_path),)) as place:
        token = tmp_path / "token"
        token.write_text(fresh(sub="robot", roles=["adapter"], scope=["robot/*"]))
        token.chmod(0o600)
        await place.wander("a", "b", credentials=Credentials.of_files(token, None))
        await owned_by(place, "a")
        yield Guarded(place, tmp_path)


@pytest.fixture
async def guarded(shared_nats: NatsServer, postgres_server: Server, tmp_path: Path) -> AsyncIterator[Guarded]:
    async with guarded_by(shared_nats, postgres_server, tmp_path) as here:
        yield here


@pytest.fixture
def own_nats(nats: None, tmp_path: Path) -> Iterator[NatsServer]:
    with nats_server(tmp_path) as server:
        yield server


async def person(guarded: Guarded, gateway_id: str, subject: str = "ann") -> Application:
    return await guarded.app(gateway_id, sub=subject, rank="person", **OPERATOR)


async def program(guarded: Guarded, gateway_id: str) -> Application:
    """Connect a program that holds the lamp."""
    app = await guarded.app(gateway_id, sub="agent", rank="agent", **OPERATOR)
    assert await app.code("rois.command.bind", **LAMP) == "OK"
    return app


async def switch(app: Application, command_id: str) -> tuple[str, str]:
    """Ask for a command of the lamp; return the return_code and the reason."""
    return await app.why("rois.command.execute", command_unit_list=[unit("robot/lamp", "switch", command_id)])


@pytest.mark.parametrize(("by", "where"), [("b", "b"), ("a", "b"), ("b", "a")])
async def test_a_person_stops_and_hands_back_at_any_gateway(guarded: Guarded, by: str, where: str) -> None:
    ann, bob, agent = await person(guarded, by), await person(guarded, where, "bob"), await program(guarded, where)
    assert await ann.code("openrois.stop_all", **ROBOT) == "OK"
    told = await agent.next("openrois.lease.stopped")
    assert told == {"engine_id": "robot", "by": "ann", "reason": WAITS, "stop_id": told["stop_id"]}
    for number in range(100):
        assert await switch(agent, f"try {number}") == REFUSED
    assert (await bob.ask("openrois.lease.query", **LAMP))["lease"]["stopped_by"] == "ann"
    refused = "only a person hands back to programs what a person has stopped"
    assert await agent.why("openrois.lease.release_stop", **ROBOT) == ("UNSUPPORTED", refused)
    assert await bob.code("openrois.lease.release_stop", **LAMP) == "OK"
    assert (await agent.next("openrois.lease.stopped"))["by"] == ""
    assert await switch(agent, "after") == ("OK", "")
    assert await agent.completed("after") == {"after": "OK"}
    assert guarded.place.robot.lamp.total == 1


async def test_what_names_no_engine_in_scope_is_refused_as_ever(guarded: Guarded) -> None:
    ann = await person(guarded, "b")
    for params in ({"engine_id": "rover"}, {"component_ref": "robot/none"}, {"component_ref": "rover/arm"}):
        assert await ann.code("openrois.lease.release_stop", **params) == "UNSUPPORTED"
    assert await ann.code("openrois.lease.release_stop") == "BAD_PARAMETER"
    assert await ann.code("openrois.lease.release_stop", **LAMP, **ROBOT) == "BAD_PARAMETER"


async def test_the_next_owner_of_a_body_latches_at_once(guarded: Guarded) -> None:
    ann = await person(guarded, "b")
    assert await ann.code("openrois.stop_all", **ROBOT) == "OK"
    await guarded.place.cluster.stop("a")
    await owned_by(guarded.place, "b")
    await seen_by(ann, "robot")
    agent = await program(guarded, "b")
    assert await switch(agent, "1") == REFUSED
    assert await ann.code("openrois.lease.release_stop", **ROBOT) == "OK"
    assert await switch(agent, "2") == ("OK", "")


async def test_stop_by_the_store_latches_too(own_nats: NatsServer, postgres_server: Server, tmp_path: Path) -> None:
    async with guarded_by(own_nats, postgres_server, tmp_path) as guarded:
        ann, agent = await person(guarded, "b"), await program(guarded, "a")
        own_nats.kill()
        async with patience():
            while not await lacking(guarded.place, "b"):
                pass
        assert await ann.why("openrois.stop_all", **ROBOT) == ("OK", "")
        assert await switch(agent, "1") == REFUSED
        code, why = await ann.why("openrois.lease.release_stop", **ROBOT)
        assert code == "ERROR"
        assert why.startswith(
            "robot may still be stopped for programs: robot belongs to gateway a, which is not reached"
        )
        own_nats.start()
        await seen_by(ann, "robot")
        assert await ann.code("openrois.lease.release_stop", **ROBOT) == "OK"
        assert await switch(agent, "2") == ("OK", "")


async def test_a_hand_back_that_the_link_does_not_carry_says_so(
    own_nats: NatsServer, postgres_server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with guarded_by(own_nats, postgres_server, tmp_path) as guarded:
        ann, agent = await person(guarded, "b"), await program(guarded, "a")
        assert await ann.code("openrois.stop_all", **ROBOT) == "OK"
        for module in (presence, pulse):
            monkeypatch.setattr(module, "SILENCE", SILENCE)
        own_nats.freeze()
        try:
            # Neither gateway has noticed it yet.
            code, why = await ann.why("openrois.lease.release_stop", **ROBOT)
        finally:
            own_nats.thaw()
        assert code == "ERROR"
        assert why.startswith("robot may still be stopped for programs: gateway a, which has the engine, was lost")
        monkeypatch.undo()
        await seen_by(ann, "robot")
        assert await ann.code("openrois.lease.release_stop", **ROBOT) == "OK"
        assert await switch(agent, "1") == ("OK", "")


async def test_a_hand_back_that_the_link_delays_ends_no_later_stop(
    own_nats: NatsServer, postgres_server: Server, tmp_path: Path
) -> None:
    async with guarded_by(own_nats, postgres_server, tmp_path) as guarded:
        ann, bob, agent = await person(guarded, "b"), await person(guarded, "a", "bob"), await program(guarded, "a")
        assert await ann.code("openrois.stop_all", **ROBOT) == "OK"
        stop_id = (await agent.next("openrois.lease.stopped"))["stop_id"]
        own_nats.freeze()
        try:
            late = asyncio.ensure_future(ann.why("openrois.lease.release_stop", **ROBOT, stop_id=stop_id))
            assert await bob.code("openrois.stop_all", **ROBOT) == "OK"
        finally:
            own_nats.thaw()
        code, why = await late
        # Where the machine took so long that the link was given up, it is not there at all.
        assert code == "ERROR" or why == "robot was stopped again meanwhile, by bob: hand it back anew"
        assert await switch(agent, "1") == ("OUT_OF_RESOURCES", REFUSED[1].replace("ann", "bob"))
