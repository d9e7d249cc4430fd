"""Adapters that say what a body offers and do nothing else: thousands of them in one process.

`python -m openrois_bench.gateway.fleet.stubs URL FIRST LAST` holds the bodies until it is stopped. Their token is
in the environment.
"""

import asyncio
import json
import os
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import Final

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois_bench.errors import within

__all__ = ["TOKEN_VARIABLE", "body_name", "body_profile", "stub_bodies"]

TOKEN_VARIABLE: Final = "BENCH_TOKEN"  # noqa: S105

AT_ONCE: Final = 16
"""Connections that are opened at a time."""

_PATIENCE: Final = 600.0
_ENGINE: Final = "@engine@"
"""Stands for the engine's id in what every body says."""


def body_name(number: int) -> str:
    """Return the engine id of a body."""
    return f"body-{number:05}"


def body_profile(engine_id: str) -> str:
    """Return what a body of 17 components answers to `rois.system.get_profile`, as JSON."""
    return _PROFILE.replace(_ENGINE, engine_id)


def _profile() -> str:
    refs = [f"{_ENGINE}/{kind.name}" for kind in BASIC_COMPONENTS]
    return json.dumps(
        {
            "return_code": "OK",
            "profile": {"identifier": {"code": _ENGINE}, "component_ids": refs},
            "component_profiles": {
                f"{_ENGINE}/{kind.name}": kind.profile().model_dump(mode="json") for kind in BASIC_COMPONENTS
            },
        }
    )


_PROFILE: Final = _profile()
_HELLO: Final = json.dumps({"return_code": "OK", "version": "1", "extensions": ["openrois.lease"], "engines": []})


async def _serve(socket: ClientConnection, engine_id: str) -> None:
    """Answer the gateway until the connection ends."""
    results = {"rois.system.get_profile": body_profile(engine_id), "openrois.hello": _HELLO}
    with suppress(ConnectionClosed):
        async for text in socket:
            asked = json.loads(text)
            if "id" in asked:
                result = results.get(asked["method"], '{"return_code": "UNSUPPORTED"}')
                await socket.send(f'{{"jsonrpc": "2.0", "id": {json.dumps(asked["id"])}, "result": {result}}}')


@asynccontextmanager
async def stub_bodies(url: str, numbers: range, token: str = "") -> AsyncIterator[None]:
    """Hold bodies of 17 components each at a gateway while the block runs; they may not be attached yet.

    Args:
        url: where adapters dial.
        numbers: of the bodies.
        token: of an adapter; empty for a gateway that asks for none.
    """
    free = asyncio.Semaphore(AT_ONCE)
    serving: list[asyncio.Task[None]] = []
    sockets: list[ClientConnection] = []
    headers = {"Authorization": f"Bearer {token}"} if token else {}

    async def enter(number: int) -> None:
        async with free:
            socket = await connect(
                url, compression=None, max_size=None, ping_interval=None, proxy=None, additional_headers=headers
            )
        sockets.append(socket)
        serving.append(asyncio.ensure_future(_serve(socket, body_name(number))))

    try:
        async with within(_PATIENCE, f"connecting {len(numbers)} bodies"), asyncio.TaskGroup() as opening:
            for number in numbers:
                opening.create_task(enter(number))
        yield
    finally:
        for socket in sockets:
            socket.transport.abort()
        if serving:
            await asyncio.wait(serving)


async def _main(url: str, first: str, last: str) -> None:
    print("connecting", flush=True)
    async with stub_bodies(url, range(int(first), int(last)), os.environ.get(TOKEN_VARIABLE, "")):
        await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(_main(*sys.argv[1:]))
