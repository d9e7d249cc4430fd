"""coturn on a loopback address, as `docs/network.md` sets it up."""

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

SECRET = "an example of a secret"
LISTENS = "127.0.0.1"
PATIENCE = 10.0


@dataclass(frozen=True)
class Turn:
    """A TURN server that runs."""

    port: int
    secret: str
    process: asyncio.subprocess.Process

    def url(self, transport: str = "udp") -> str:
        return f"turn:{LISTENS}:{self.port}?transport={transport}"

    def server(self, expires_at: float, *, secret: str | None = None, transport: str = "udp") -> IceServer:
        username, credential = turn_credential(secret or self.secret, int(expires_at), "alice")
        return IceServer(urls=(self.url(transport),), username=username, credential=credential)


@asynccontextmanager
async def coturn(folder: Path) -> AsyncIterator[Turn]:
    """Run it for as long as the block does; it relays between loopback addresses, which a real one must not."""
    with socket.create_server((LISTENS, 0)) as probe:
        port = probe.getsockname()[1]
    program = shutil.which("turnserver")
    assert program is not None
    settings = folder / "turnserver.conf"
    settings.write_text(
        f"listening-ip={LISTENS}\nrelay-ip={LISTENS}\nlistening-port={port}\nrealm=example.org\n"
        f"use-auth-secret\nstatic-auth-secret={SECRET}\nallow-loopback-peers\nno-cli\nno-tls\nno-dtls\nno-tcp-relay\n"
        f"no-multicast-peers\nno-software-attribute\nlog-file=stdout\nsimple-log\nuserdb={folder}/users\n"
        f"pidfile={folder}/pid\nuser-quota=8\ntotal-quota=8\n"
    )
    process = await asyncio.create_subprocess_exec(
        program, "-c", str(settings), stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.DEVNULL
    )
    try:
        async with asyncio.timeout(PATIENCE):
            await asyncio.to_thread(_wait_for, port)
        yield Turn(port, SECRET, process)
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


def _wait_for(port: int) -> None:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        with socket.socket() as probe:
            if probe.connect_ex((LISTENS, port)) == 0:
                return
        time.sleep(0.02)
