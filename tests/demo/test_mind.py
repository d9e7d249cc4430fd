"""`openrois demo --mind`: a visitor speaks, and the body acts and answers."""

import asyncio
import os
import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import psutil
import pytest
from aiohttp import ClientSession
from openrois_media import Media, Purpose

from openrois.client import Client
from openrois.client.components import Reaction
from openrois.types.profiles import component_urn
from tests.support.chat_server import chat_server
from tests.support.demo import PATIENCE, Demo, end, running_demo, start
from tests.support.hearing import spoken
from tests.support.microphone import Microphone

pytestmark = [pytest.mark.media, pytest.mark.engine]


async def happens(subscription: Any, holds: Callable[[dict[str, Any]], bool] = lambda _data: True) -> dict[str, Any]:
    """Wait for an event."""
    async with asyncio.timeout(PATIENCE):
        async for data in subscription:
            if holds(data):
                return dict(data)
    raise AssertionError("the subscription has ended")


async def page_token(demo: Demo) -> str:
    """The token that the demo gives a page: of a visitor, who goes before programs."""
    async with ClientSession() as session, session.get(f"{demo.page}page-token") as answer:
        return str((await answer.json())["token"])


def lines_of(demo: Demo) -> list[str]:
    """The lines behind the one that says it is ready, until what can be said."""
    assert demo.process.stdout is not None
    lines: list[str] = []
    while not (lines and lines[-1].startswith("say")):
        line = demo.process.stdout.readline()
        assert line, demo.log()
        lines.append(line.rstrip())
    return lines


def pause(demo: Demo) -> None:
    """Let the demo go on for a moment, which has not ended."""
    with suppress(subprocess.TimeoutExpired):
        status = demo.process.wait(0.1)
        raise AssertionError(f"the demo has ended with status {status}: {demo.log()}")


def until_logged(demo: Demo, line: str) -> None:
    """Wait until the demo's log has a line."""
    until = time.monotonic() + PATIENCE
    while line not in demo.log():
        assert time.monotonic() < until, demo.log()
        pause(demo)


def restarted(demo: Demo) -> psutil.Process:
    """Wait until the mind's process is there again."""
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        for each in demo.tree():
            with suppress(psutil.Error):
                if "mind" in each.cmdline():
                    return each
        pause(demo)
    raise AssertionError(demo.log())


@pytest.mark.long
def test_a_mind_that_hangs_is_killed_and_started_again_and_does_not_hold_the_end_up(tmp_path: Path) -> None:
    with running_demo(tmp_path, more=("--mind",)) as demo:
        lines_of(demo)
        first = demo.program("mind")
        first.send_signal(signal.SIGSTOP)
        first.wait(PATIENCE)
        until_logged(demo, "mind is ready again")
        assert "mind runs but does not answer: it is killed, and started again" in demo.log()
        # It takes no signal now.
        demo.program("mind").send_signal(signal.SIGSTOP)
        os.killpg(demo.process.pid, signal.SIGINT)
        assert demo.process.wait(20) == 0
        assert "mind did not end within 2.0 s and is killed" in demo.log()


def test_options_of_a_mind_without_one_are_a_mistake() -> None:
    process = start("demo", "--wake-word", "computer")
    try:
        assert process.wait(PATIENCE) == 2
        assert process.stderr is not None
        assert "add --mind" in process.stderr.read()
    finally:
        end(process)


@pytest.mark.usefixtures("flite", "pocketsphinx")
async def test_a_body_waves_and_answers_when_it_is_spoken_to(tmp_path: Path) -> None:
    with running_demo(tmp_path, "puppet", ("--mind",)) as demo:
        assert "who are you" in lines_of(demo)[-1]
        microphone = Microphone()
        async with Client(demo.url, token=await page_token(demo)) as client, Media(client) as media:
            avatar = next(each for each in await client.bodies() if each.engine_id == "avatar")
            words = client.component(avatar.refs(component_urn("Hearing", "OpenRoIS"))[0])
            voice = client.component(avatar.refs(component_urn("SpeechProgress", "OpenRoIS"))[0])
            reaction = client.component(avatar.refs(Reaction)[0])
            consent = [Purpose.LIVE, Purpose.RECOGNITION, Purpose.AGENT]
            async with (
                words.event("heard") as heard,
                voice.event("speech_began") as began,
                media.send(microphone=microphone, consent=consent, to="avatar"),
            ):
                microphone.say(spoken("wave your hand"))
                await happens(heard, lambda data: data["final"] and "wave" in data["text"])
                async with asyncio.timeout(PATIENCE):
                    while (await reaction.query("component_status"))["status"] != "BUSY":
                        pass
                microphone.say(spoken("good morning"))
                assert (await happens(began))["text"]
                # The page sends its microphone as a visitor, and the mind keeps all that it acts with.
                for component_ref in (*avatar.refs(Reaction), "avatar/speech_synthesizer", "avatar/dialogue"):
                    assert (await client.control.status(component_ref)).holder == "agent"
        # With its gateway there, which the demo ends behind it, it ends by itself however long that takes, and puts its
        # grammar back.
        demo.program("mind").terminate()
        until_logged(demo, "mind ended with status 0 and is started again")
        assert demo.interrupt() == 0
        assert "was not put back" not in demo.log()
        assert "Traceback" not in demo.log()


@pytest.mark.extra(name="speech")
@pytest.mark.usefixtures("flite", "pocketsphinx")
async def test_a_language_model_answers_a_visitor_of_the_page_who_agrees(tmp_path: Path) -> None:
    async with chat_server() as server:
        server.words = "Welcome to this house."
        options = ("--mind", "--llm-url", server.address.base, "--llm-model", "m")
        with running_demo(tmp_path, "puppet", options) as demo:
            assert lines_of(demo)[-1] == "say what you like"
            microphone = Microphone()
            async with Client(demo.url, token=await page_token(demo)) as client, Media(client) as media:
                voice = client.component("avatar/speech_progress")
                consent = [Purpose.LIVE, Purpose.RECOGNITION]
                async with (
                    voice.event("speech_began") as began,
                    media.send(microphone=microphone, consent=consent, to="avatar") as sending,
                ):
                    microphone.say(spoken("good morning to you all"))
                    assert "agree that a program" in (await happens(began))["text"]
                    assert not server.asked
                    await sending.consent(*consent, Purpose.AGENT)
                    microphone.say(spoken("good morning to you all"))
                    await happens(began, lambda data: data["text"] == server.words)
                    assert server.asked[0]["model"] == "m"
                    assert (await client.control.status("avatar/dialogue")).holder == "agent"
            assert "Traceback" not in demo.log()


def test_a_mind_that_dies_is_started_again_and_ends_with_the_demo(tmp_path: Path) -> None:
    with running_demo(tmp_path, more=("--mind",)) as demo:
        lines_of(demo)
        first = demo.program("mind")
        first.send_signal(signal.SIGKILL)
        first.wait(PATIENCE)
        again = restarted(demo)
        assert again.pid != first.pid
        os.killpg(demo.process.pid, signal.SIGINT)
        assert demo.process.wait(20) == 0
        assert not psutil.wait_procs([again], timeout=PATIENCE)[1]
        assert "mind ended with status -9 and is started again" in demo.log()
