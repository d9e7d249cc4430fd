"""`openrois mind --llm-url` as a process of its own, at a real gateway, with a scripted server."""

import asyncio
import os
import re
import signal
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import aiohttp
import pytest

from openrois.adapter.running import serve
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.actors import Actor, Visitors
from tests.support.chat_server import Behaviour, ChatServer, breaking, calls, chat_server, chunk, floods, halting, says
from tests.support.conversing import until
from tests.support.http_answers import event as sent
from tests.support.packages import ROOT

pytestmark = pytest.mark.timeout(180)

KEY = "secret-0123456789"
MIND = "import sys; from openrois_agents.mind.command import main; sys.exit(main(sys.argv[1:]))"


@dataclass
class Scene:
    server: ChatServer
    actor: Actor
    process: asyncio.subprocess.Process
    figures: str

    def hear(self, text: str, visitor: str = "ann") -> None:
        self.actor.hearing.heard(text, True, visitor_ref=visitor)

    async def until_said(self, sentence: str) -> None:
        await until(lambda: sentence in self.actor.speaking.did)

    async def figure(self, name: str) -> float:
        async with aiohttp.ClientSession() as http, http.get(self.figures) as answer:
            lines = (await answer.text()).splitlines()
        (line,) = (each for each in lines if each.startswith(f"{name} "))
        return float(line.split()[1])

    async def end(self) -> str:
        """End the process, and return what it logged."""
        self.process.send_signal(signal.SIGTERM)
        _, logged = await self.process.communicate()
        assert self.process.returncode == 0
        return logged.decode()


@asynccontextmanager
async def scene(
    folder: Path, *script: Behaviour, at_once: bool = True, more: tuple[str, ...] = ()
) -> AsyncIterator[Scene]:
    # One of them consents.
    visitors = Visitors({"ann": "presence agent", "bob": "presence"})
    actor, there = Actor(at_once=at_once, visitors=visitors), asyncio.Event()
    key_file = folder / "key"
    key_file.write_text(f"{KEY}\n")
    async with run_gateway(GatewaySettings(port=0)) as gateway, chat_server(KEY) as server:
        url = gateway.url.replace("http", "ws", 1)
        gateway.engine.on_change(there.set)
        async with serve(*actor.parts, engine_id="robot", gateway=f"{url}adapter"):
            async with asyncio.timeout(60):
                await there.wait()
            server.script.extend(script)
            command = [sys.executable, "-c", MIND, "--gateway", url, "--metrics", "0"]
            command += ["--llm-url", server.address.base, "--llm-model", "m", "--llm-key-file", str(key_file), *more]
            process = await asyncio.create_subprocess_exec(
                *command, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE, env=dict(os.environ)
            )
            try:
                assert process.stdout is not None
                async with asyncio.timeout(60):
                    figures = (await process.stdout.readline()).decode().split()
                    assert (await process.stdout.readline()).startswith(b"ready ")
                assert figures[0] == "figures"
                yield Scene(server, actor, process, figures[1])
            finally:
                if process.returncode is None:
                    process.kill()
                    await process.communicate()


async def test_a_visitor_is_answered_by_a_language_model_that_acts(tmp_path: Path) -> None:
    script = (calls(("gesture", {"name": "wave"}), first="Look here."), says("I waved. ", "And now?"))
    async with scene(tmp_path, *script) as there:
        there.hear("please wave")
        await there.until_said("And now?")
        assert there.actor.speaking.did == ["Look here.", "I waved.", "And now?"]
        assert "urn:x-rois:def:reaction:OpenRoIS::wave" in there.actor.gesturing.did
        assert there.server.keys == [f"Bearer {KEY}"] * 2
        assert await there.figure("openrois_mind_model_requests_total") == 2
        assert await there.figure("openrois_mind_model_read_tokens_total") == 200
        assert KEY not in await there.end()


async def test_its_figures_are_served_as_they_are_documented(tmp_path: Path) -> None:
    documented = (ROOT / "docs/reference/metrics.md").read_text().partition("<!-- printed: mind-figures -->")[2]
    rows = re.findall(r"^\| `(\w+)` \| (\w+) \| (.+) \|$", documented, re.MULTILINE)
    async with scene(tmp_path, says("Welcome.")) as there:
        there.hear("hello")
        await there.until_said("Welcome.")
        there.hear("hello", "bob")
        asked = "I may only answer you if you agree that a program that answers gets your words"
        await there.until_said(f"{asked}: please do so where your microphone is.")
        async with aiohttp.ClientSession() as http, http.get(there.figures) as answer:
            assert answer.status == 200
            text = await answer.text()
        kinds, meanings = (
            dict(re.findall(rf"^# {what} (openrois_mind_\w+) (.+)$", text, re.MULTILINE)) for what in ("TYPE", "HELP")
        )
        assert kinds == {name: kind for name, kind, _ in rows}
        assert meanings == {name: meaning.replace("\\", "\\\\") for name, _, meaning in rows}
        assert await there.figure("openrois_mind_conversations_total") == 1
        assert await there.figure("openrois_mind_turns_total") == 2
        assert await there.figure("openrois_mind_conversing") == 1


async def test_of_a_visitor_who_does_not_consent_nothing_is_sent(tmp_path: Path) -> None:
    async with scene(tmp_path, says("Welcome.")) as there:
        there.hear("hello", "bob")
        there.hear("hello", "ann")
        await there.until_said("Welcome.")
        assert len(there.server.asked) == 1
        assert await there.figure('openrois_mind_refusals_total{reason="consent"}') == 1


async def test_further_words_cancel_an_answer_and_close_its_request(tmp_path: Path) -> None:
    async with scene(tmp_path, halting(chunk({"content": "This is long. And"})), says("Yes?"), at_once=False) as there:
        there.hear("tell me a story")
        async with asyncio.timeout(60):
            await there.actor.speaking.begun.wait()
        there.hear("wait")
        async with asyncio.timeout(60):
            await there.server.broken.wait()
            await there.actor.speaking.stopped.wait()
        await there.until_said("Yes?")
        assert await there.figure("openrois_mind_model_interruptions_total") == 1
        there.actor.speaking.may_end.set()


@pytest.mark.parametrize(
    ("behaviour", "sentence"),
    [
        (floods(lambda _: b"x" * 65_536), "I am sorry, I cannot think of an answer now. Please try again in a moment."),
        (floods(lambda n: sent(chunk({"content": f"{n}, "}))), None),
        (breaking, "I am sorry, I have lost my thread. Please ask me again."),
    ],
    ids=["lines", "tokens", "breaking"],
)
async def test_a_server_that_fails_leaves_the_rest_at_work(
    tmp_path: Path, behaviour: Behaviour, sentence: str | None
) -> None:
    async with scene(tmp_path, behaviour, says("I am back.")) as there:
        there.hear("hello")
        if sentence is None:
            async with asyncio.timeout(60):
                await there.server.broken.wait()
        else:
            await there.until_said(sentence)
        there.hear("are you there?")
        await there.until_said("I am back.")
        logged = await there.end()
        assert sentence is None or "the language model at http://127.0.0.1" in logged


async def test_a_limit_is_said_and_the_model_is_not_asked_any_more(tmp_path: Path) -> None:
    more = ("--limit-turns", "9,1", "--use-file", str(tmp_path / "use.json"))
    async with scene(tmp_path, says("One."), more=more) as there:
        there.hear("hello")
        await there.until_said("One.")
        there.hear("and now?")
        await there.until_said("I have talked as much as I may today. Please come back tomorrow.")
        await there.end()
    async with scene(tmp_path, says("Never."), more=more) as there:
        there.hear("hello again")
        await there.until_said("I have talked as much as I may today. Please come back tomorrow.")
        assert there.server.asked == []
