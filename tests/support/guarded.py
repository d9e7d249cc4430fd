"""A gateway that asks for tokens, as a whole: on a real socket, with a key of its own and a clock of the test."""

import json
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.tokens import issue, key_file


@dataclass
class Guarded:
    """A gateway, and how to reach it."""

    gateway: Gateway
    folder: Path
    asked: int = field(default=0)

    @property
    def address(self) -> str:
        return self.gateway.url.replace("http", "ws", 1)

    def dial(
        self,
        token: str | None = None,
        *,
        path: str = "",
        origin: str | None = None,
        offered: tuple[str, ...] = (),
        **more: Any,
    ) -> connect:
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        return connect(
            f"{self.address}{path}",
            additional_headers=headers | more.pop("headers", {}),
            origin=None if origin is None else Origin(origin),
            subprotocols=[Subprotocol(name) for name in offered] or None,
            compression=None,
            proxy=None,
            **more,
        )

    def audited(self) -> list[dict[str, Any]]:
        """Return the audit trail, which is complete once the gateway has stopped."""
        return [json.loads(line) for line in (self.folder / "audit.jsonl").read_text().splitlines()]


@asynccontextmanager
async def guarded(folder: Path, **settings: Any) -> AsyncIterator[Guarded]:
    """Run a gateway that knows the secret of the tests, unless the settings name other keys."""
    keys = {} if {"auth_jwks", "auth_jwks_file", "auth_keys"} & settings.keys() else {"auth_keys": (key_file(folder),)}
    chosen = GatewaySettings(port=0, audit_file=folder / "audit.jsonl", **keys, **settings)
    async with run_gateway(chosen) as gateway:
        yield Guarded(gateway, folder)


def fresh(**claims: object) -> str:
    """Return a good token of now."""
    return issue(time.time(), **claims)


async def ask(connection: ClientConnection, method: str, **params: object) -> dict[str, Any]:
    """Ask and return the answer; notifications on the way are dropped."""
    await connection.send(json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}))
    while True:
        message: dict[str, Any] = json.loads(await connection.recv())
        if message.get("id") == 1:
            return message
