"""The figures of gateways that share NATS and PostgreSQL: what they own, ask of each other, and have lost."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import pytest

from openrois.gateway.cluster_metrics import CLUSTER_FIGURES
from tests.support import deployment
from tests.support.deployment import PATIENCE, Application
from tests.support.nats import NatsServer, nats_server
from tests.support.place import Place, place_of
from tests.support.postgres import Server
from tests.support.scraped import Samples, scraped

pytestmark = pytest.mark.extra(name="cluster")

PREFIX = "openrois_gateway_"


async def figures(
    place: Place, gateway_id: str, until: Callable[[dict[str, Samples]], object] = lambda _found: True
) -> dict[str, Samples]:
    """Read a gateway's figures until something holds of them."""
    async with asyncio.timeout(PATIENCE):
        while True:
            found = {
                name.removeprefix(PREFIX): samples
                for name, samples in (await scraped(place.gateway(gateway_id))).items()
            }
            if until(found):
                return found


async def resumed(app: Application, token: str) -> str:
    answer = await app.ask("openrois.lease.resume", token=token, command_ids=[])
    return str(answer["return_code"])


async def test_what_is_owned_asked_of_others_and_resumed_is_counted(
    shared_nats: NatsServer, postgres_server: Server
) -> None:
    async with place_of(shared_nats, postgres_server, "a", "b", metrics="0") as place:
        await place.attach("a")
        app = await place.app("b")
        assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"
        token = (await app.ask("openrois.lease.token"))["token"]
        owner, front = await figures(place, "a"), await figures(place, "b")
        assert (owner["owned_engines"][()], front["owned_engines"][()]) == (1, 0)
        assert owner["claims_total"] == {("granted",): 1, ("refused",): 0, ("failed",): 0}
        assert 0 < owner["claims_hold_seconds"][()] <= 10
        for each in owner, front:
            assert (each["store_up"][()], each["nats_up"][()], each["peers"][()]) == (1, 1, 1)
            assert (each["store_failures_total"][()], each["holdings_lost_total"][()]) == (0, 0)
            assert each["store_seconds_total"][()] > 0
        # Each follows the other's directory, too.
        assert (owner["peer_streams"], owner["sub_sessions"][()]) == ({("b",): 3}, 2)
        assert front["relayed_calls_total"][("answered",)] == front["relay_seconds_count"][("rois.command.bind",)] == 1
        assert owner["relayed_calls_total"] == dict.fromkeys(owner["relayed_calls_total"], 0)
        assert [await resumed(await place.app("a"), shown) for shown in (token, token, "none")] == [
            "OK",
            "UNSUPPORTED",
            "UNSUPPORTED",
        ]
        owner = await figures(place, "a")
        assert owner["resumed_sessions_total"] == {("whole",): 1, ("partial",): 0, ("refused",): 1, ("replayed",): 1}
        assert {f"{PREFIX}{name}" for name in owner} >= {figure.name for figure in CLUSTER_FIGURES}


async def test_what_fails_without_nats_is_counted(postgres_server: Server, tmp_path: Path) -> None:
    with nats_server(tmp_path) as nats:
        async with place_of(nats, postgres_server, "a", "b", metrics="0") as place:
            await place.attach("a")
            app = await place.app("b")
            token = (await app.ask("openrois.lease.token"))["token"]
            nats.kill()
            found = await figures(place, "b", lambda found: not found["nats_up"][()])
            assert (found["peers"][()], found["store_up"][()]) == (0, 1)
            assert "peer_streams" not in found
            assert await app.code("rois.command.bind", component_ref="robot/bell") != "OK"
            found = await figures(place, "b")
            assert found["relayed_calls_total"][("unreached",)] == 1
            again = await place.stack.enter_async_context(deployment.application(place.gateway("b")))
            assert await resumed(again, token) == "OK"
            assert (await figures(place, "b"))["resumed_sessions_total"][("partial",)] == 1


@pytest.mark.long  # until the gateway asks for its next renewal
async def test_what_fails_without_the_store_is_counted(shared_nats: NatsServer, postgres_server: Server) -> None:
    async with place_of(shared_nats, postgres_server, "a", metrics="0") as place:
        postgres_server.kill()
        try:
            found = await figures(place, "a", lambda found: not found["store_up"][()])
            assert (found["store_failures_total"][()] > 0, found["nats_up"][()]) == (True, 1)
        finally:
            postgres_server.start()
        await figures(place, "a", lambda found: found["store_up"][()])


async def test_a_gateway_on_its_own_has_none_of_them() -> None:
    async with deployment.gateway(metrics="0") as alone:
        assert not {figure.name for figure in CLUSTER_FIGURES} & set(await scraped(alone))
