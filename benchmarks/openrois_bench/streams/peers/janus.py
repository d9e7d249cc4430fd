"""Janus with its streaming plugin: one mountpoint that takes RTP in, and a session of its API for each viewer."""

import asyncio
import itertools
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import aiohttp

HTTP_PORT = 18088
_START_TIMEOUT = 10.0

_UNUSED_PLUGINS = (
    "audiobridge duktape echotest lua nosip recordplay sip textroom videocall videoroom voicemail"  # all but streaming
)
_UNUSED_TRANSPORTS = "mqtt nanomsg pfunix rabbitmq websockets"
_GENERAL = """
general: {{ session_timeout = 0, debug_level = 3, debug_timestamps = false, configs_folder = "{folder}" }}
media: {{ no_media_timer = 0 }}
plugins: {{ disable = "{plugins}" }}
transports: {{ disable = "{transports}" }}
events: {{ broadcast = false }}
"""
_HTTP = """
general: {{ json = "compact", base_path = "/janus", http = true, port = {port}, interface = "lo", https = false }}
admin: {{ admin_http = false }}
"""
_STREAMING = """
peers: {{ type = "rtp", id = 1, audio = false, video = true, videoport = {port}, videopt = 96, videocodec = "h264",
  videofmtp = "profile-level-id=42e01f;packetization-mode=1" }}
"""


class Janus:
    """A Janus that runs."""

    def __init__(self, client: aiohttp.ClientSession, pid: int) -> None:
        self.pid = pid
        self._client = client
        self._numbers = itertools.count()
        self._handles: dict[int, str] = {}

    async def offer(self, viewer: int) -> str:
        """Have one more viewer watch; the SDP of its offer."""
        session = f"/janus/{(await self._ask('/janus', janus='create'))['data']['id']}"
        attached = await self._ask(session, janus="attach", plugin="janus.plugin.streaming")
        self._handles[viewer] = f"{session}/{attached['data']['id']}"
        await self._ask(self._handles[viewer], janus="message", body={"request": "watch", "id": 1})
        return str((await self._event(session))["jsep"]["sdp"])

    async def apply_answer(self, viewer: int, sdp: str) -> None:
        """Take the answer of a viewer in."""
        jsep = {"type": "answer", "sdp": sdp}
        await self._ask(self._handles[viewer], janus="message", body={"request": "start"}, jsep=jsep)

    async def _ask(self, path: str, **request: Any) -> dict[str, Any]:
        request["transaction"] = str(next(self._numbers))
        async with self._client.post(path, json=request) as response:
            answer: dict[str, Any] = await response.json(content_type=None)
        if answer["janus"] not in ("success", "ack"):
            raise RuntimeError(f"Janus: {answer}")
        return answer

    async def _event(self, session: str) -> dict[str, Any]:
        """Poll the next event with a description."""
        async with asyncio.timeout(_START_TIMEOUT):
            while True:
                async with self._client.get(session, params={"maxev": 1}) as response:
                    told = await response.json(content_type=None)
                for event in told if isinstance(told, list) else [told]:
                    if "jsep" in event:
                        return dict(event)

    async def wait_for_start(self) -> None:
        """Return when its API answers."""
        async with asyncio.timeout(_START_TIMEOUT):
            while True:
                try:
                    async with self._client.get("/janus/info"):
                        return
                except aiohttp.ClientError:
                    await asyncio.sleep(0.1)


@asynccontextmanager
async def janus(rtp_port: int) -> AsyncIterator[Janus]:
    """Run Janus, which takes RTP at that port of 127.0.0.1 in.

    Raises:
        FileNotFoundError: it is not installed.
        TimeoutError: it does not start.
    """
    with tempfile.TemporaryDirectory(prefix="peers-") as name:
        folder = Path(name)
        plugins = ",".join(f"libjanus_{each}.so" for each in _UNUSED_PLUGINS.split())
        transports = ",".join(f"libjanus_{each}.so" for each in _UNUSED_TRANSPORTS.split())
        general = _GENERAL.format(folder=folder, plugins=plugins, transports=transports)
        (folder / "janus.jcfg").write_text(general)
        (folder / "janus.transport.http.jcfg").write_text(_HTTP.format(port=HTTP_PORT))
        (folder / "janus.plugin.streaming.jcfg").write_text(_STREAMING.format(port=rtp_port))
        with (folder / "log").open("w") as log:
            process = await asyncio.create_subprocess_exec(
                "janus", "-F", str(folder), "-C", str(folder / "janus.jcfg"), stdout=log, stderr=log
            )
        try:
            async with aiohttp.ClientSession(f"http://127.0.0.1:{HTTP_PORT}") as client:
                running = Janus(client, process.pid)
                await running.wait_for_start()
                yield running
        except TimeoutError:
            print((folder / "log").read_text()[-4000:])
            raise
        finally:
            if process.returncode is None:
                process.terminate()
            await process.wait()
