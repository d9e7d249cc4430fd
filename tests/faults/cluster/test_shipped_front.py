"""Three gateways as `packaging/` has them: its configuration with TLS and tokens, and its haproxy in front of them."""

import asyncio
import shutil
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pytest

from openrois.adapter import Component, command, query, serve
from openrois.client import BindingRestored, Client, ComponentProxy, Disconnected, Reconnect
from openrois.errors import RoISError
from tests.support.certificates import Authority
from tests.support.demo import free_port
from tests.support.gateway_processes import PATIENCE, GatewayProcesses, Own, gateway_processes, until
from tests.support.nats import nats_server
from tests.support.packages import ROOT
from tests.support.postgres import Server
from tests.support.proxies import ShippedProxy, shipped_proxy
from tests.support.tokens import issue, key_file

pytestmark = [pytest.mark.usefixtures("haproxy", "nats"), pytest.mark.timeout(300)]


LACKING: Final = {"NATS": "NATS, which joins the gateways", "PostgreSQL": "the store that the gateways share"}


class Arm(Component, authority="Test", function="actuation"):
    """Counts how often it is moved."""

    moved = 0

    @command
    async def move(self) -> None:
        self.moved += 1

    @query
    async def times(self) -> int:
        """Return how often it was moved."""
        return self.moved


@dataclass
class Place:
    """The gateways and their proxy.

    Attributes:
        cluster: the gateways.
        front: the proxy.
        folder: with the authority of their certificate, and the tokens.
    """

    cluster: GatewayProcesses
    front: ShippedProxy
    folder: Path

    def _client(self) -> Client:
        return Client(
            self.front.url.replace("http", "wss", 1),
            token=issue(time.time()),
            ca_file=self.folder / "ca.pem",
            reconnect=Reconnect(first=0.05, limit=0.3),
        )

    @asynccontextmanager
    async def client_at(self, gateway_id: str, backend: str = "ready") -> AsyncIterator[Client]:
        """Let an application dial the proxy while that has one gateway for it, and be there while the block runs."""
        others = [each for each in self.cluster.gateways if each != gateway_id]
        for each in others:
            await self.front.ask(f"set server {backend}/{each} state drain")
        async with self._client() as client:
            for each in others:
                await self.front.ask(f"set server {backend}/{each} state ready")
            assert (await self.front.shown("scur", backend))[gateway_id] == "1"
            yield client

    @asynccontextmanager
    async def arm_at(self, gateway_id: str) -> AsyncIterator[Arm]:
        """Let an adapter with an arm dial one gateway while the block runs."""
        token = self.folder / "adapter.token"
        token.write_text(issue(time.time(), sub="robot", roles=["adapter"], scope=["robot/*"]))
        url, arm = self.cluster[gateway_id].adapter_url, Arm("arm")
        async with serve(arm, engine_id="robot", gateway=url, token_file=token, ca_file=self.folder / "ca.pem"):
            await self.cluster.owner("robot")
            yield arm


@pytest.fixture
async def place(postgres_server: Server, tmp_path: Path) -> AsyncIterator[Place]:
    """Three gateways with the shipped configuration, each as a process, and the shipped proxy."""
    shutil.copy(ROOT / "packaging/cluster.toml", tmp_path)
    cert, cert_key = Authority(tmp_path).issue()
    cert.rename(tmp_path / "tls.pem")
    cert_key.rename(tmp_path / "tls.key")
    key_file(tmp_path).rename(tmp_path / "key.pem.pub")
    options = ("--config", str(tmp_path / "cluster.toml"), "--host", "127.0.0.1")
    own = {each: Own(options=("--metrics", f"127.0.0.1:{free_port()}")) for each in "abc"}
    async with AsyncExitStack() as stack:
        nats = stack.enter_context(nats_server(tmp_path))
        made = gateway_processes(nats, postgres_server, tmp_path, options=options, own=own, scheme="https")
        cluster = await stack.enter_async_context(made)
        front = await stack.enter_async_context(shipped_proxy(*(each.url for each in cluster.gateways.values())))
        await front.takes_for("UP", "UP", "UP")
        yield Place(cluster, front, tmp_path)


async def times(arm: ComponentProxy) -> int:
    """Ask an arm how often it was moved."""
    return int((await arm.query("times"))["times"])


async def arm_of(app: Client) -> ComponentProxy:
    """Return the arm as soon as an application reaches it: on a busy machine gateways miss each other for a moment."""
    arm = app.component("robot/arm")

    async def is_reached() -> bool:
        with suppress(RoISError):
            await times(arm)
            return True
        return False

    await until(is_reached, "the arm is not reached", PATIENCE)
    return arm


@pytest.mark.parametrize("missing", ["NATS", pytest.param("PostgreSQL", marks=pytest.mark.long)])
async def test_f47_f48_the_shipped_proxy_cuts_no_application_off_while_no_gateway_is_ready(
    missing: str, place: Place
) -> None:
    gateways, nats, postgres = place.cluster.gateways.values(), place.cluster.nats, place.cluster.postgres
    async with place.arm_at("a") as arm, place.client_at("a") as app, place.client_at("b") as elsewhere:
        here, there = await arm_of(app), await arm_of(elsewhere)
        gone = asyncio.ensure_future(anext(aiter(app.notices(Disconnected))))
        async with here.bound():
            await here.command("move")
            assert await times(there) == arm.moved == 1
            (nats if missing == "NATS" else postgres).kill()
            try:
                for each in gateways:
                    await each.lacks(LACKING[missing])
                await place.front.takes_for("NOLB", "NOLB", "NOLB")
                # A connection that comes now is better at a gateway that lives than nowhere.
                async with place.client_at("a", "living") as late:
                    assert await times(late.component("robot/arm")) == 1
                for _ in range(20):
                    await here.command("move")
                if missing == "NATS":
                    with pytest.raises(RoISError, match="NATS"):
                        await times(there)
                else:
                    assert await times(there) == 21
            finally:
                (nats if missing == "NATS" else postgres).start()
            for each in gateways:
                await each.ready()
            await place.front.takes_for("UP", "UP", "UP")
            await here.command("move")
            assert await times(await arm_of(elsewhere)) == 22
        assert not gone.done()
        gone.cancel()


@pytest.mark.long
async def test_f46_an_application_of_a_gateway_that_stands_still_is_elsewhere_and_keeps_its_robot(place: Place) -> None:
    async with place.arm_at("b") as arm, place.client_at("a") as app:
        component = await arm_of(app)
        restored = app.notices(BindingRestored)
        async with component.bound():
            await component.command("move")
            place.cluster["a"].freeze()
            await anext(aiter(restored))
            assert (await place.front.shown("scur"))["a"] == "0"
            await component.command("move")
            assert arm.moved == 2
            place.cluster["a"].thaw()
            await place.front.takes_for("UP", "UP", "UP")
