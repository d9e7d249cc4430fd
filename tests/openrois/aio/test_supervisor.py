"""What a service manager hears of a gateway."""

import asyncio
import os
import signal
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from openrois.aio.supervisor import Supervisor


@pytest.fixture
def manager(tmp_path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "notify"))
        listening.settimeout(30)
        yield listening


def test_without_a_manager_nothing_is_told() -> None:
    Supervisor({}).notify_state("READY=1")


def test_a_manager_that_is_gone_is_no_fault(tmp_path: Path) -> None:
    Supervisor({"NOTIFY_SOCKET": str(tmp_path / "gone")}).notify_state("READY=1")


@pytest.mark.parametrize("microseconds", ["", "0", "soon"])
async def test_a_manager_that_does_not_watch_hears_nothing(microseconds: str, manager: socket.socket) -> None:
    told = Supervisor({"NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": microseconds})
    await told.watch()


async def test_it_hears_twice_in_the_time_that_it_asks_for(manager: socket.socket) -> None:
    slept: list[float] = []

    async def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) == 3:
            raise asyncio.CancelledError

    told = Supervisor({"NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": "10000000"}, sleep)
    with pytest.raises(asyncio.CancelledError):
        await told.watch()
    assert slept == [5.0] * 3
    assert [manager.recv(100) for _ in slept] == [b"WATCHDOG=1"] * 3


async def test_an_abstract_name() -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind("")
        listening.settimeout(30)
        name = listening.getsockname()
        Supervisor({"NOTIFY_SOCKET": "@" + name[1:].decode()}).notify_state("READY=1")
        assert listening.recv(100) == b"READY=1"


async def test_a_gateway_tells_that_it_is_ready_and_that_it_stops(manager: socket.socket) -> None:
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "openrois.cli", "gateway", "--port", "0"),
        stdout=asyncio.subprocess.DEVNULL,
        env=os.environ | {"NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": "20000000"},
    )
    assert (await asyncio.to_thread(manager.recv, 100)).startswith(b"READY=1\nSTATUS=listening http://127.0.0.1:")
    assert await asyncio.to_thread(manager.recv, 100) == b"WATCHDOG=1"
    process.send_signal(signal.SIGTERM)
    assert await asyncio.to_thread(manager.recv, 100) == b"STOPPING=1"
    assert await process.wait() == 0
