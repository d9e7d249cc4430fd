"""A gateway without options is reached at one port of this machine, and gives other clients no information."""

import asyncio
import os
import re
import signal
import socket
import sys
from pathlib import Path

import aiohttp
import pytest

from tests.support import deployment

SILENT = ("metrics", "debug", "debug/vars", "status", "stats", "info", "config", "admin", "api", "env", "server-status")

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="what a process listens to stands in /proc"
)


def listening(pid: int) -> set[tuple[str, int]]:
    """Return the addresses at which a process takes TCP connections, and where it takes datagrams."""
    folder = Path("/proc", str(pid))
    links = [str(link.readlink()) for link in (folder / "fd").iterdir()]
    inodes = {inode[1] for link in links if (inode := re.fullmatch(r"socket:\[(\d+)]", link))}
    found: set[tuple[str, int]] = set()
    for table, state in (("tcp", "0A"), ("tcp6", "0A"), ("udp", "07"), ("udp6", "07")):
        for line in (folder / "net" / table).read_text().splitlines()[1:]:
            cells = line.split()
            if cells[3] == state and cells[9] in inodes:
                address, _, port = cells[1].partition(":")
                shown = socket.inet_ntoa(bytes.fromhex(address)[::-1]) if len(address) == 8 else address
                found.add((shown, int(port, 16)))
    return found


async def test_one_port_of_this_machine_and_nothing_to_see_there() -> None:
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "openrois.cli", "gateway", "--port", "0"),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
        env={name: value for name, value in os.environ.items() if not name.startswith("OPENROIS_")},
    )
    assert process.stdout is not None
    try:
        async with asyncio.timeout(30):
            url = (await process.stdout.readline()).decode().removeprefix("listening ").strip()
        port = int(url.rpartition(":")[2].strip("/"))
        assert listening(process.pid) == {("127.0.0.1", port)}
        async with aiohttp.ClientSession() as http, deployment.patience():
            for path in SILENT:
                async with http.get(url + path) as answer:
                    assert (path, answer.status) in {(path, 404), (path, 503)}
                    assert "openrois_gateway" not in await answer.text()
    finally:
        process.send_signal(signal.SIGTERM)
        assert await process.wait() == 0
