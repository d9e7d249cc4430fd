"""A server with an API like OpenAI's on this machine: it speaks with espeak-ng, and does what a test asks it."""

import asyncio
import json
import ssl
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from aiohttp import web
from numpy.typing import NDArray
from openrois_body.services.address import ServiceAddress
from openrois_body.speech.synthesizer import Synthesizer

from tests.support.http_answers import begin, cut, event

RATE = 24_000
SOUND = "audio/pcm"
Behaviour = Callable[["SpeechServer", web.Request], Awaitable[web.StreamResponse]]


@dataclass
class SpeechServer:
    """A running server.

    Attributes:
        address: of it.
        synthesizer: speaks.
        behaviour: answers the next requests instead of what is asked for; None: it does what it is asked.
        asked: the fields of each request; of a transcription with `sound`, the bytes of its file.
        keys: the header of authorization of each request, if it had one.
        go_on: what is withheld waits for it.
        broken: set when the other side has closed the connection before the answer had ended.
        arrived: is released with each request.
        words: that it recognises.
    """

    address: ServiceAddress
    synthesizer: Synthesizer
    behaviour: Behaviour | None = None
    asked: list[dict[str, Any]] = field(default_factory=list)
    keys: list[str | None] = field(default_factory=list)
    go_on: asyncio.Event = field(default_factory=asyncio.Event)
    broken: asyncio.Event = field(default_factory=asyncio.Event)
    arrived: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(0))
    words: str = "Hello there."

    async def sound(self, text: str) -> NDArray[np.int16]:
        """Return a text as it is spoken here, at 24 kHz."""
        return (await self.synthesizer.synthesize(text, volume=100)).samples[::2]

    async def speak(self, request: web.Request) -> web.StreamResponse:
        told = await request.json()
        self.asked.append(told)
        self.keys.append(request.headers.get("Authorization"))
        self.arrived.release()
        if self.behaviour is not None:
            return await self.behaviour(self, request)
        response = await begin(request, SOUND)
        await response.write((await self.sound(told["input"])).astype("<i2").tobytes())
        return response

    async def transcribe(self, request: web.Request) -> web.StreamResponse:
        form = await request.post()
        fields: dict[str, Any] = {name: value for name, value in form.items() if isinstance(value, str)}
        sent = form["file"]
        assert isinstance(sent, web.FileField)
        self.asked.append({**fields, "sound": sent.file.read()})
        self.keys.append(request.headers.get("Authorization"))
        self.arrived.release()
        if self.behaviour is not None:
            return await self.behaviour(self, request)
        if fields.get("stream") == "true":
            return await streamed(self, request)
        return web.json_response({"text": self.words})


async def streamed(server: SpeechServer, request: web.Request) -> web.StreamResponse:
    """Tell the words one by one, and then all of them."""
    response = await begin(request, "text/event-stream")
    for number, word in enumerate(server.words.split()):
        await response.write(event({"type": "transcript.text.delta", "delta": word if number == 0 else f" {word}"}))
    await response.write(event({"type": "transcript.text.done", "text": server.words}))
    return response


async def first_half(server: SpeechServer, request: web.Request) -> web.StreamResponse:
    """Send the first half of the sound at once, and the rest when the test says so."""
    sound = (await server.sound(server.asked[-1]["input"])).astype("<i2").tobytes()
    response = await begin(request, SOUND)
    half = len(sound) // 4 * 2
    await response.write(sound[:half])
    await server.go_on.wait()
    await response.write(sound[half:])
    return response


async def odd_pieces(server: SpeechServer, request: web.Request) -> web.StreamResponse:
    """Send the sound in pieces that cut samples in two."""
    sound = (await server.sound(server.asked[-1]["input"])).astype("<i2").tobytes()
    response = await begin(request, SOUND)
    for first in range(0, len(sound), 1001):
        await response.write(sound[first : first + 1001])
    return response


async def early_end(_server: SpeechServer, request: web.Request) -> web.StreamResponse:
    """Close the connection in the middle of the answer."""
    return await cut(request, SOUND, b"\1\0" * 4800)


async def flood(server: SpeechServer, request: web.Request) -> web.StreamResponse:
    """Send sound without end, until the other side has had enough."""
    response = await begin(request, SOUND)
    try:
        while True:
            await response.write(bytes(1 << 20))
    except ConnectionError:
        server.broken.set()
    return response


def says(status: int, told: object = None, kind: str = "application/json") -> Behaviour:
    """Return a behaviour that answers with a status and a text, or an object as JSON."""

    async def answer(_server: SpeechServer, _request: web.Request) -> web.StreamResponse:
        text = told if isinstance(told, str) else json.dumps(told)
        return web.Response(status=status, text=text, content_type=kind)

    return answer


@asynccontextmanager
async def speech_server(key: str | None = None, tls: ssl.SSLContext | None = None) -> AsyncIterator[SpeechServer]:
    """Run a server on a free port; it wants the key, if one is given."""

    @web.middleware
    async def admit(request: web.Request, handler: Any) -> web.StreamResponse:
        if key is not None and request.headers.get("Authorization") != f"Bearer {key}":
            return web.json_response({"error": {"message": f"Incorrect API key provided: {key}"}}, status=401)
        response: web.StreamResponse = await handler(request)
        return response

    application = web.Application(middlewares=[admit])
    runner = web.AppRunner(application, shutdown_timeout=0.1)
    async with Synthesizer() as synthesizer:
        server = SpeechServer(ServiceAddress(""), synthesizer)
        application.router.add_post("/v1/audio/speech", server.speak)
        application.router.add_post("/v1/audio/transcriptions", server.transcribe)
        await runner.setup()
        site = web.TCPSite(runner, "127.0.0.1", 0, ssl_context=tls)
        await site.start()
        try:
            _, port = runner.addresses[0]
            server.address = ServiceAddress(f"{'http' if tls is None else 'https'}://127.0.0.1:{port}/v1")
            yield server
        finally:
            server.go_on.set()
            await runner.cleanup()
