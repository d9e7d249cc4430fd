"""A session whose gateway is gone keeps its rank at the next one, for the grace of its leases."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from tests.openrois.federation.test_resuming import bound, lease_of
from tests.openrois.federation.test_stop_latch import guarded_by
from tests.openrois.federation.test_tokens import OPERATOR, Guarded
from tests.support.nats import NatsServer
from tests.support.place import owned_by
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")

LAMP = {"component_ref": "robot/lamp"}


@pytest.fixture
async def guarded(shared_nats: NatsServer, postgres_server: Server, tmp_path: Path) -> AsyncIterator[Guarded]:
    async with guarded_by(shared_nats, postgres_server, tmp_path) as here:
        yield here


async def test_only_a_higher_rank_borrows_from_a_session_that_was_lost_with_its_gateway(guarded: Guarded) -> None:
    agent = await guarded.app("a", sub="helper", rank="agent", **OPERATOR)
    script = await guarded.app("b", sub="night watch", rank="script", **OPERATOR)
    equal = await guarded.app("b", sub="another", rank="agent", **OPERATOR)
    person = await guarded.app("b", sub="ann", rank="person", **OPERATOR)
    token = await bound(agent)
    await guarded.place.gateway("a").drain()
    await owned_by(guarded.place, "b")
    await lease_of(script, "ABSENT")
    refused = "robot/lamp is held by helper, which is not of lower rank than this application: request it instead"
    for lower in (script, equal):
        assert await lower.why("openrois.lease.borrow", **LAMP) == ("OUT_OF_RESOURCES", refused)
    assert await person.code("openrois.lease.borrow", **LAMP) == "OK"
    again = await guarded.app("b", sub="helper", rank="agent", **OPERATOR)
    assert (await again.ask("openrois.lease.resume", token=token, command_ids=[]))["return_code"] == "OK"
    assert await person.code("openrois.lease.give_back", **LAMP) == "OK"
    await lease_of(again, "MINE")
