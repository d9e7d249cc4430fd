"""What servers in tests answer, whichever API they have: pieces, events, or nothing for a while."""

import asyncio
import json
from typing import Protocol

from aiohttp import web

__all__ = ["Withholding", "begin", "cut", "event", "silent"]


class Withholding(Protocol):
    """A server that withholds something until a test says so."""

    go_on: asyncio.Event


async def begin(request: web.Request, kind: str) -> web.StreamResponse:
    """Begin an answer in pieces."""
    response = web.StreamResponse(headers={"Content-Type": kind})
    await response.prepare(request)
    return response


def event(told: object) -> bytes:
    """Return a server-sent event."""
    return f"data: {json.dumps(told)}\n\n".encode()


async def silent(server: Withholding, _request: web.Request) -> web.StreamResponse:
    """Send nothing, no header either, until the test says so."""
    await server.go_on.wait()
    raise web.HTTPNoContent


async def cut(request: web.Request, kind: str, before: bytes) -> web.StreamResponse:
    """Close the connection behind the beginning of an answer."""
    response = await begin(request, kind)
    await response.write(before)
    assert request.transport is not None
    request.transport.close()
    return response
