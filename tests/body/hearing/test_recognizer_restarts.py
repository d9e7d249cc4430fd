"""The recogniser's process is killed again and again: each time what is said next is written down all the same."""

import asyncio
from collections.abc import Callable
from contextlib import suppress

import numpy as np
import psutil
import pytest
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.recognition import Recognition
from openrois_body.hearing.recognizer import Expectation
from openrois_body.hearing.speech_detector import SpeechDetector
from openrois_body.hearing.sphinx import Sphinx

from tests.support.hearing import spoken, stereo_48k
from tests.support.listening import Listened

SILENCE = np.zeros((48_000, 2), np.int16)
COMMANDS = Expectation(("en",), "#JSGF V1.0;\ngrammar robot;\npublic <command> = go to the (window | door);\n")


def recognizers() -> list[psutil.Process]:
    """The recogniser's processes, those too that have ended and were not waited for."""
    found = []
    for process in psutil.Process().children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            words = process.cmdline()
            if process.status() == psutil.STATUS_ZOMBIE or "openrois_body.hearing.sphinx_child" in words:
                found.append(process)
    return found


@pytest.mark.usefixtures("flite", "pocketsphinx")
@pytest.mark.timeout(300)
@pytest.mark.parametrize("times", [3, pytest.param(20, marks=pytest.mark.long)])
async def test_a_recogniser_that_is_killed_again_and_again_is_there_for_the_next_utterance(times: int) -> None:
    utterance = np.concatenate([SILENCE[:14_400], stereo_48k(spoken("go to the window")), SILENCE])
    room, heard = Listened(), list[tuple[str, ...]]()
    ear = Ear(room.microphone, room.clock)
    recognition = Recognition(SpeechDetector(ear), Sphinx(), room.clock)
    recognition.expected = lambda: COMMANDS
    recognition.recognized.add(lambda candidates, _at, _sender: heard.append(candidates))

    async def until(so: Callable[[], object]) -> None:
        """Wait for the process, while the time between two tries passes on the clock of the test."""
        while not so():
            await room.clock.advance(1.0)
            await asyncio.sleep(0.01)

    running = (asyncio.ensure_future(ear.run()), asyncio.ensure_future(recognition.run()))
    async with room.plugged(*running):
        leave = recognition.want()
        # The first process opens what belongs to this one, too.
        await until(recognizers)
        descriptors = psutil.Process().num_fds()
        for _ in range(times):
            before = len(heard)
            await until(lambda: len(recognizers()) == 1)
            recognizers()[0].kill()
            await room.say(utterance)
            await until(lambda: len(heard) > before)  # noqa: B023 - it is waited for here
        await until(lambda: len(recognizers()) == 1)
        assert psutil.Process().num_fds() <= descriptors
        leave()
        await until(lambda: not recognizers())
    assert heard == [("go to the window",)] * times
