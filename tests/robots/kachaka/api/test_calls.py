"""Calls of the robot: deadlines, large messages, and failures in a sentence."""

import ast
import asyncio
import socket
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import openrois_robots.kachaka
import pytest
from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_robots.kachaka.api import calls
from openrois_robots.kachaka.api.address import Address
from openrois_robots.kachaka.api.calls import KachakaApi, RobotSilent, RobotUnreachable
from openrois_robots.kachaka.simulator.servicer import SimulatorServicer

from openrois.adapter import ComponentFailed, Unsupported
from tests.support.kachaka import simulated, simulator_process


class Odd(SimulatorServicer):
    """A robot that fails, and has a map of 5 MB."""

    async def GetRobotVersion(self, _request: Any, _context: Any) -> Any:  # noqa: N802
        raise RuntimeError("worn out")

    async def GetRobotSerialNumber(self, _request: Any, _context: Any) -> Any:  # noqa: N802
        await asyncio.Event().wait()


@pytest.fixture
async def api() -> AsyncIterator[KachakaApi]:
    async with simulated(servicer=Odd) as (servicer, address), KachakaApi(address) as api:
        servicer.map_data = bytes(5_000_000)
        yield api


async def test_a_call_is_answered(api: KachakaApi) -> None:
    response = await api.call("GetBatteryInfo")
    assert response.remaining_percentage == pytest.approx(80, abs=1)


async def test_a_call_that_is_not_answered_ends_at_its_deadline(api: KachakaApi) -> None:
    with pytest.raises(RobotSilent, match=r"GetRobotSerialNumber was not answered within 0\.1 s"):
        await api.call("GetRobotSerialNumber", deadline=0.1)


async def test_a_map_of_five_megabytes_comes_whole(api: KachakaApi) -> None:
    response: pb2.GetPngMapResponse = await api.call("GetPngMap", deadline=10)
    assert len(response.map.data) == 5_000_000


async def test_a_method_that_the_robot_does_not_have_is_unsupported(api: KachakaApi) -> None:
    with pytest.raises(Unsupported, match="the robot has no GetRosImu: its software may be too old, or"):
        await api.call("GetRosImu")


async def test_a_failure_of_the_robot_says_which_call_failed(api: KachakaApi) -> None:
    with pytest.raises(ComponentFailed, match=r"GetRobotVersion failed: .*worn out"):
        await api.call("GetRobotVersion")


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        (Address("127.0.0.1", 1), "nothing listens at this port"),
        (Address("no-such-robot.invalid"), "this name is not known in the network"),
    ],
)
async def test_a_wrong_address_is_explained(address: Address, reason: str) -> None:
    async with KachakaApi(address) as api:
        with pytest.raises((RobotUnreachable, RobotSilent)) as raised:
            await api.call("GetRobotPose", deadline=20)
    assert str(raised.value) == (f"{reason}; check --robot, and that the Kachaka API is switched on in the robot's app")


async def test_what_is_no_kachaka_is_explained() -> None:
    async def talk(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b"220 mail.example ESMTP\r\n" * 10)
        writer.close()

    server = await asyncio.start_server(talk, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    async with server, KachakaApi(Address("127.0.0.1", port)) as api:
        with pytest.raises((RobotUnreachable, RobotSilent), match="check --robot"):
            await api.call("GetRobotPose", deadline=20)


async def test_names_are_not_looked_up_on_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    def blocking(*_arguments: object) -> str:
        raise AssertionError("gethostbyname blocks the loop")

    monkeypatch.setattr(socket, "gethostbyname", blocking)
    monkeypatch.setattr(socket, "getaddrinfo", blocking)
    async with simulated() as (_, address), KachakaApi(Address("localhost", address.port)) as api:
        await api.call("GetBatteryInfo", deadline=20)


async def test_a_robot_that_comes_back_is_connected_again_soon() -> None:
    async with simulator_process() as home, KachakaApi(home.address) as api:
        await api.call("GetRobotPose", deadline=10)
        await home.kill()
        for _ in range(5):
            with pytest.raises((RobotUnreachable, RobotSilent)):
                await api.call("GetRobotPose")
        await home.start_again()
        loop = asyncio.get_running_loop()
        back_at = loop.time()
        async with asyncio.timeout(30):
            while True:
                try:
                    await api.call("GetRobotPose")
                except (RobotUnreachable, RobotSilent):
                    await asyncio.sleep(0.05)
                else:
                    break
        # gRPC's own pause grows up to two minutes; ours is a second and a fifth of it at most.
        print(f"connected again after {loop.time() - back_at:.2f} s")


def test_it_tries_again_each_second_and_pings_no_robot() -> None:
    """The robot's server answers pings of its clients with GOAWAY, and no ping has ever noticed a robot that hangs."""
    options = dict(calls._OPTIONS)
    assert options["grpc.max_reconnect_backoff_ms"] <= 1000
    assert options["grpc.initial_reconnect_backoff_ms"] <= 1000
    assert not any("keepalive" in name or "ping" in name for name in options)


def test_of_the_vendors_package_the_generated_stub_alone_is_used() -> None:
    named = {
        name
        for module in sorted(Path(openrois_robots.kachaka.__path__[0]).rglob("*.py"))
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8")))
        for name in _imported(node)
        if name.startswith("kachaka_api")
    }
    assert named <= {
        "kachaka_api.generated.kachaka_api_pb2",
        *(f"kachaka_api.generated.kachaka_api_pb2_grpc.{each}" for each in _OF_THE_STUB),
    }


_OF_THE_STUB = ("KachakaApiStub", "KachakaApiServicer", "add_KachakaApiServicer_to_server")


def _imported(node: ast.AST) -> list[str]:
    if isinstance(node, ast.Import):
        return [each.name for each in node.names]
    return [f"{node.module}.{each.name}" for each in node.names] if isinstance(node, ast.ImportFrom) else []
