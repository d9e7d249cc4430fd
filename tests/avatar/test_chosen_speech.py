"""`openrois avatar` with a voice and ears that were chosen, and a component that was added, as a process of its own."""

import asyncio
import os
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from openrois.client import Client, ComponentFailed
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.packages import ROOT
from tests.support.speech_server import says, speech_server

pytestmark = [pytest.mark.engine, pytest.mark.media]

EXAMPLES = ROOT / "docs/examples"


@asynccontextmanager
async def avatar(folder: Path, *options: str) -> AsyncIterator[Client]:
    """Run an avatar that waits for its game engine, and an application."""
    environment = {**os.environ, "PYTHONPATH": f"{EXAMPLES}:{os.environ.get('PYTHONPATH', '')}"}
    async with asyncio.timeout(90), run_gateway(GatewaySettings(port=0)) as gateway:
        attached = asyncio.Event()
        gateway.engine.on_change(attached.set)
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "openrois.cli", "avatar", "--engine", "external"),
            *("--link", f"unix:{folder / 'link'}", "--gateway", gateway.url, *options),
            env=environment,
            stderr=asyncio.subprocess.PIPE,
        )
        try:
            ended = asyncio.ensure_future(process.wait())
            coming = asyncio.ensure_future(attached.wait())
            await asyncio.wait({ended, coming}, return_when=asyncio.FIRST_COMPLETED)
            coming.cancel()
            assert not ended.done(), await _text(process)
            async with Client(gateway.url) as client:
                yield client
        finally:
            if process.returncode is None:
                process.terminate()
            (folder / "log").write_text(await _text(process))
            await process.wait()


async def _text(process: asyncio.subprocess.Process) -> str:
    assert process.stderr is not None
    return (await process.stderr.read()).decode()


async def test_an_added_component_speaks_in_the_voice_of_a_server(tmp_path: Path) -> None:
    key = tmp_path / "key"
    key.write_text("sk-of-the-voice")
    async with speech_server("sk-of-the-voice") as server:
        options = ("--voice-url", server.address.base, "--voice-key-file", str(key), "--voice-name", "nova")
        async with avatar(tmp_path, *options, "--component", "greeter:Greeter") as client:
            greeter = client.component("avatar/greeter")
            async with greeter.bound(), greeter.event("greeted") as greeted:
                await greeter.command("greet", name="Ann")
                assert await anext(aiter(greeted)) == {"name": "Ann"}
                assert await greeter.query("number_greeted") == {"number": 1}
                server.behaviour = says(429, {"error": {"message": "no quota"}})
                with pytest.raises(ComponentFailed, match=r"takes no more now \(429\): no quota"):
                    await greeter.command("greet", name="Ben")
            progress = client.component("avatar/speech_progress")
            assert await progress.query("synthesizer") == {"sent_to": ""}
    assert [(asked["voice"], asked["input"]) for asked in server.asked] == [
        ("nova", "Hello, Ann!"),
        ("nova", "Hello, Ben!"),
    ]
    log = (tmp_path / "log").read_text()
    assert "Traceback" not in log
    assert "sk-of-the-voice" not in log


async def test_where_speech_and_words_go_is_told_and_sound_needs_consent(tmp_path: Path) -> None:
    options = ("--voice-url", "https://voice.example/v1", "--ears-url", "https://ears.example")
    async with avatar(tmp_path, *options) as client:
        hearing = client.component("avatar/hearing")
        assert await hearing.query("recognizer") == {"sent_to": "https://ears.example", "allowed": False}
        progress = client.component("avatar/speech_progress")
        assert await progress.query("synthesizer") == {"sent_to": "https://voice.example"}
    log = (tmp_path / "log").read_text()
    assert log.count("speech: texts that are spoken are sent to https://voice.example") == 1
    assert log.count("recognised words: the sound of the microphone is sent to https://ears.example") == 1
    async with avatar(tmp_path, *options, "--ears-consented") as client:
        hearing = client.component("avatar/hearing")
        assert await hearing.query("recognizer") == {"sent_to": "https://ears.example", "allowed": True}
