"""A server with an API like OpenAI's chat completions on this machine: it answers as a test says, or misbehaves.

`python -m tests.support.chat_server PORT` runs one that greets, for trying `openrois mind --llm-url` by hand.
"""

import asyncio
import json
import sys
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

from aiohttp import web
from openrois_body.services.address import ServiceAddress

from tests.support.http_answers import begin, cut, event

Behaviour = Callable[["ChatServer", web.Request], Awaitable[web.StreamResponse]]

TEXT = "text/event-stream"


@dataclass
class ChatServer:
    """A running server.

    Attributes:
        address: of it.
        script: the behaviour of each next request; without one it says `words`.
        asked: the body of each request.
        keys: the header of authorization of each request, if it had one.
        go_on: what is withheld waits for it.
        broken: set when the other side has closed the connection before the answer had ended.
        arrived: is released with each request.
        written: seconds of the loop's clock at which each event was written.
    """

    address: ServiceAddress = field(default_factory=lambda: ServiceAddress(""))
    script: deque[Behaviour] = field(default_factory=deque)
    words: str = "Hello there."
    asked: list[dict[str, Any]] = field(default_factory=list)
    keys: list[str | None] = field(default_factory=list)
    go_on: asyncio.Event = field(default_factory=asyncio.Event)
    broken: asyncio.Event = field(default_factory=asyncio.Event)
    arrived: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(0))
    written: list[float] = field(default_factory=list)

    async def complete(self, request: web.Request) -> web.StreamResponse:
        self.asked.append(await request.json())
        self.keys.append(request.headers.get("Authorization"))
        self.arrived.release()
        behaviour = self.script.popleft() if self.script else says(self.words)
        try:
            return await behaviour(self, request)
        except (ConnectionError, asyncio.CancelledError):
            self.broken.set()
            raise


def chunk(delta: dict[str, Any], finish: str | None = None) -> dict[str, Any]:
    """Return an event of a stream, as OpenAI's server has it."""
    choice = {"index": 0, "delta": delta, "finish_reason": finish}
    return {"id": "chatcmpl-1", "object": "chat.completion.chunk", "model": "m", "choices": [choice]}


def call_chunk(index: int | None, arguments: str, name: str = "", call_id: str = "") -> dict[str, Any]:
    """Return an event with a part of a tool's call."""
    part: dict[str, Any] = {"function": {"arguments": arguments}}
    if index is not None:
        part["index"] = index
    if name:
        part |= {"id": call_id or f"call_{name}", "type": "function"}
        part["function"]["name"] = name
    return chunk({"tool_calls": [part]})


def says(*texts: str, usage: tuple[int, int] | None = (100, 10)) -> Behaviour:
    """Return a behaviour that says texts, each as a token."""
    return streams(*(chunk({"content": text}) for text in texts), finish="stop", usage=usage)


def calls(*named: tuple[str, object], first: str = "", usage: tuple[int, int] | None = (100, 10)) -> Behaviour:
    """Return a behaviour that says something and calls tools; arguments arrive in pieces of three characters."""
    events = [chunk({"content": first})] if first else []
    for index, (name, arguments) in enumerate(named):
        text = arguments if isinstance(arguments, str) else json.dumps(arguments)
        events.append(call_chunk(index, "", name, f"call{index:05}"))
        events += [call_chunk(index, text[at : at + 3]) for at in range(0, len(text), 3)]
    return streams(*events, finish="tool_calls", usage=usage)


def streams(*events: object, finish: str = "stop", usage: tuple[int, int] | None = None) -> Behaviour:
    """Return a behaviour that sends events, and the end."""

    async def answer(server: ChatServer, request: web.Request) -> web.StreamResponse:
        response = await begin(request, TEXT)
        for each in events:
            await response.write(event(each))
            server.written.append(asyncio.get_running_loop().time())
        await response.write(event(chunk({}, finish)))
        if usage is not None:
            told = {"prompt_tokens": usage[0], "completion_tokens": usage[1], "total_tokens": sum(usage)}
            await response.write(event({"choices": [], "usage": told}))
        await response.write(b"data: [DONE]\n\n")
        return response

    return answer


def halting(*before: object, then: Sequence[bytes] = (), rest: Sequence[object] = ()) -> Behaviour:
    """Return a behaviour that sends events, and the beginning of another one, and the rest when the test says so."""

    async def answer(server: ChatServer, request: web.Request) -> web.StreamResponse:
        response = await begin(request, TEXT)
        for written in (*map(event, before), *then):
            await response.write(written)
            server.written.append(asyncio.get_running_loop().time())
        await server.go_on.wait()
        for each in rest:
            await response.write(event(each))
        await response.write(b"data: [DONE]\n\n")
        return response

    return answer


async def breaking(_server: ChatServer, request: web.Request) -> web.StreamResponse:
    """Close the connection in the middle of a sentence."""
    return await cut(request, TEXT, event(chunk({"content": "I think. Then I am, but"})))


def floods(told: Callable[[int], bytes], kind: str = TEXT) -> Behaviour:
    """Return a behaviour that sends without end, until the other side has had enough."""

    async def answer(_server: ChatServer, request: web.Request) -> web.StreamResponse:
        response, number = await begin(request, kind), 0
        while True:
            await response.write(b"".join(told(number + each) for each in range(64)))
            number += 64

    return answer


def bytes_of(text: bytes, kind: str = TEXT) -> Behaviour:
    """Return a behaviour that answers with bytes."""

    async def answer(_server: ChatServer, request: web.Request) -> web.StreamResponse:
        response = await begin(request, kind)
        await response.write(text)
        return response

    return answer


def refuses(status: int, told: object = None) -> Behaviour:
    """Return a behaviour that answers with a status."""

    async def answer(_server: ChatServer, _request: web.Request) -> web.StreamResponse:
        return web.Response(status=status, text=json.dumps(told), content_type="application/json")

    return answer


@asynccontextmanager
async def chat_server(key: str | None = None, port: int = 0) -> AsyncIterator[ChatServer]:
    """Run a server; it wants the key, if one is given."""

    @web.middleware
    async def admit(request: web.Request, handler: Any) -> web.StreamResponse:
        if key is not None and request.headers.get("Authorization") != f"Bearer {key}":
            return web.json_response({"error": {"message": f"Incorrect API key provided: {key}"}}, status=401)
        response: web.StreamResponse = await handler(request)
        return response

    application = web.Application(middlewares=[admit], client_max_size=16 << 20)
    runner = web.AppRunner(application, shutdown_timeout=0.1, handler_cancellation=True)
    server = ChatServer()
    application.router.add_post("/v1/chat/completions", server.complete)
    await runner.setup()
    site = web.TCPSite(runner, "127.0.0.1", port)
    await site.start()
    try:
        _, chosen = runner.addresses[0]
        server.address = ServiceAddress(f"http://127.0.0.1:{chosen}/v1")
        yield server
    finally:
        server.go_on.set()
        await runner.cleanup()


async def _serve(port: int) -> None:
    async with chat_server(port=port) as server:
        print(server.address.base, flush=True)
        await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(_serve(int(sys.argv[1])))
