"""The scene of an embedded game engine, with a real child process that plays the engine."""

import asyncio
import logging
import os
import signal

import pytest
from openrois_avatar.link.messages import Log, Pause
from openrois_avatar.scene import Pauses, embedded_scene
from openrois_streaming.clock import SystemClock

from openrois.errors import Aborted


class Sayings(logging.Handler):
    """What the engine has said of speech: its process id and the speech's id."""

    def __init__(self) -> None:
        super().__init__()
        self.queue = asyncio.Queue[tuple[int, str]]()

    def emit(self, record: logging.LogRecord) -> None:
        pid, _, speech = record.getMessage().removeprefix("game engine: ").partition(" speaks ")
        if speech:
            self.queue.put_nowait((int(pid), speech))


@pytest.mark.engine
async def test_a_game_engine_that_dies_in_mid_speech_comes_back_speaking(caplog: pytest.LogCaptureFixture) -> None:
    sayings, body = Sayings(), logging.getLogger("openrois_body.body")
    caplog.set_level(logging.INFO, body.name)
    body.addHandler(sayings)
    try:
        async with asyncio.timeout(30), embedded_scene("avatar", "tests.support.fake_engine", SystemClock()) as scene:
            assert scene.voice is not None
            said = scene.voice.say("one two " * 100, ssml=False, language="en", character="default", volume=50)
            saying = asyncio.ensure_future(said)
            first, speech = await sayings.queue.get()
            os.kill(first, signal.SIGKILL)
            second, again = await sayings.queue.get()
            assert (second != first, again) == (True, speech)
            assert not saying.done()
            scene.voice.interrupt("enough")
            with pytest.raises(Aborted, match="enough"):
                await saying
    finally:
        body.removeHandler(sayings)


def test_pause_is_notified_once_for_each_change() -> None:
    pauses, told = Pauses(), list[bool]()
    pauses.changed.add(told.append)
    for event in (Log("x"), Pause(False), Pause(True), Pause(True), Pause(False), Pause(True)):
        pauses.handle_event(event)
    pauses.clear()
    pauses.clear()
    assert told == [True, False, True, False]
    assert not pauses.on
