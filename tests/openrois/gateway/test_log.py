"""One request can be followed through the log, from the gateway to the adapter; and no token is in it."""

import asyncio
import io
import json
import logging
from collections.abc import Iterator
from typing import Any

import aiohttp
import pytest

from openrois.gateway.server import Gateway
from openrois.observability.log_lines import JsonLine, Redaction
from openrois.transport.credentials import Credentials
from openrois.transport.websocket import dial
from tests.support import deployment
from tests.support.deployment import Door

TOKEN = "not-a-token-that-a-pattern-knows"


class Nothing(Redaction):
    """Hides nothing, so that a secret in the log shows."""

    def __call__(self, text: str) -> str:
        return text


@pytest.fixture
def log() -> Iterator[io.StringIO]:
    """What the whole process logs, everything at DEBUG, as JSON lines; nothing is hidden in it."""
    text = io.StringIO()
    handler = logging.StreamHandler(text)
    handler.setFormatter(JsonLine(Nothing()))
    loggers = [
        logging.getLogger(name) for name in (None, "openrois", "aiohttp", "websockets", "websockets.client", "asyncio")
    ]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.DEBUG)
    logging.root.addHandler(handler)
    yield text
    logging.root.removeHandler(handler)
    for logger, level in zip(loggers, before, strict=True):
        logger.setLevel(level)


def lines(log: io.StringIO) -> list[dict[str, Any]]:
    return [json.loads(line) for line in log.getvalue().splitlines()]


async def test_a_request_is_followed_from_the_application_to_the_adapter(log: io.StringIO) -> None:
    async with (
        deployment.gateway() as gateway,
        deployment.adapter(gateway, Door()),
        deployment.application(gateway) as app,
    ):
        await app.ask("rois.command.bind", component_ref="robot/door")
        unit = {"component_ref": "robot/door", "command_type": "open", "command_id": "1", "arguments": []}
        await app.ask("rois.command.execute", command_unit_list=[unit])
        request_id = f"req-{app.last_id}"
        await app.completed("1")
    found = lines(log)
    of_request = [line for line in found if line.get("correlation", "").endswith(f"/{request_id}")]
    assert len({line["correlation"] for line in of_request}) == 1
    assert of_request[0]["message"] == "asked for rois.command.execute"
    told = [line["message"] for line in of_request]
    (asking,) = [line for line in told if line.startswith("asks robot for rois.command.execute")]
    number = asking.rpartition(" ")[2]
    at_adapter = [line for line in found if line.get("correlation", "").startswith("gateway-")]
    assert "asked for rois.command.execute" in [
        line["message"] for line in at_adapter if line["correlation"].endswith(f"/{number}")
    ]


async def test_no_token_is_logged_by_any_library(log: io.StringIO) -> None:
    async with deployment.gateway() as gateway:
        headers = {"Authorization": f"Bearer {TOKEN}"}
        async with dial(gateway.url.replace("http", "ws"), credentials=Credentials(TOKEN)) as stream:
            await stream.send('{"jsonrpc": "2.0", "id": 1, "method": "rois.system.connect"}')
            assert "OK" in await stream.receive()
        async with aiohttp.ClientSession() as http, http.get(f"{gateway.url}?token={TOKEN}", headers=headers) as answer:
            assert TOKEN not in await answer.text()
        await malformed(gateway)
    assert "asked for rois.system.connect" in log.getvalue()
    assert "requests that cannot be read" in log.getvalue()
    assert TOKEN not in log.getvalue()


async def malformed(gateway: Gateway) -> None:
    """Send a request that cannot be read, and whose header holds a token."""
    host, port = gateway.url.removeprefix("http://").rstrip("/").split(":")
    for request in (
        f"GET / HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {TOKEN}\x00\r\n\r\n",
        f"GET /?x={TOKEN}\x00 HTTP/1.1\r\nHost: localhost\r\n\r\n",
        f"GET / HTTP/9.9 {TOKEN}\r\n\r\n",
        f"{TOKEN} / HTTP/1.1\r\n\r\n",
    ):
        reader, writer = await asyncio.open_connection(host, int(port))
        writer.write(request.encode())
        async with deployment.patience():
            assert b"400" in await reader.readline()
        writer.close()
