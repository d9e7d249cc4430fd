"""coturn on a loopback address."""

import asyncio
import contextlib
import shutil
import socket
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

from openrois_signaling.messages import IceServer
from openrois_signaling.turn import turn_credential

from tests.support.demo import free_port

SECRET = "an example of a secret"
LISTENS = "127.0.0.1"
PATIENCE = 10.0
LOOSE = f"""
listening-ip={LISTENS}
relay-ip={LISTENS}
realm=example.org
use-auth-secret
allow-loopback-peers
no-cli
no-tls
no-dtls
no-tcp-relay
no-multicast-peers
no-software-attribute
user-quota=8
total-quota=8
"""


@dataclass(frozen=True)
class Turn:
    """A TURN server that runs."""

    port: int
    secret: str
    process: asyncio.subprocess.Process
    address: str = LISTENS

    def url(self, transport: str = "udp") -> str:
        return f"turn:{self.address}:{self.port}?transport={transport}"

    def server(self, expires_at: float, *, secret: str | None = None, transport: str = "udp") -> IceServer:
        username, credential = turn_credential(secret or self.secret, int(expires_at), "alice")
        return IceServer(urls=(self.url(transport),), username=username, credential=credential)


@asynccontextmanager
async def coturn(
    folder: Path, settings: str = LOOSE, secret: str = SECRET, address: str = LISTENS
) -> AsyncIterator[Turn]:
    """Run it for as long as the block does.

    Args:
        folder: takes its files.
        settings: lines of its configuration; by default it relays between loopback addresses, as no real one may.
        secret: what its credentials are made with; empty for none.
        address: where it listens and relays.
    """
    # It listens with TCP and with UDP, and peers take UDP ports all the time.
    port = free_port()
    program = shutil.which("turnserver")
    assert program is not None
    settings = settings.replace(f"-ip={LISTENS}", f"-ip={address}")
    lines = [settings, f"listening-port={port}", "log-file=stdout", "simple-log"]
    lines += [f"userdb={folder}/users", f"pidfile={folder}/pid"]
    if secret:
        lines.append(f"static-auth-secret={secret}")
    file = folder / "turnserver.conf"
    file.write_text("\n".join((*lines, "")), encoding="utf-8")
    process = await asyncio.create_subprocess_exec(
        program, "-c", str(file), stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.DEVNULL
    )
    try:
        async with asyncio.timeout(PATIENCE):
            await asyncio.to_thread(_wait_for, address, port)
        yield Turn(port, secret, process, address)
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


def _wait_for(address: str, port: int) -> None:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        with socket.socket() as probe:
            if probe.connect_ex((address, port)) == 0:
                return
        time.sleep(0.02)
