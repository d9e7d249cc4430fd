"""Our voice on the robot's loudspeaker: texts are synthesized here, and played by the daemon."""

import asyncio
import secrets
import wave
from collections.abc import Coroutine
from contextlib import suppress
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any, Final

from openrois_body.speech.contract import Speech, SpeechSynthesizer, Word
from openrois_body.speech.speaker import Speaker
from openrois_body.speech.utterance import place_of
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import SAMPLE_RATE

from openrois.adapter import ComponentFailed, OutOfResources, RoISError
from openrois.errors import Aborted
from openrois_robots.reachy.robot import Reachy

__all__ = ["RobotVoice", "wave_file"]

_MOST: Final = 32
"""Speeches that may wait for their turn."""
_LATENESS: Final = 0.2
"""Seconds for which the daemon may still play when a sound should be over: it does not tell its end."""
_EVERY: Final = 2
"""Of so many samples one is sent: the synthesizer makes nothing above what is left."""


@dataclass(eq=False, slots=True)
class _Saying:
    """A speech that is said, or waits.

    Attributes:
        cut_off: why it was; empty: it was not.
        last: the last word that was begun.
        disturbed: set when it is paused or cut off.
        going_on: set while it is not paused.
        over: set when nothing more of it is heard.
    """

    cut_off: str = ""
    last: Word | None = None
    disturbed: asyncio.Event = field(default_factory=asyncio.Event)
    going_on: asyncio.Event = field(default_factory=asyncio.Event)
    over: asyncio.Event = field(default_factory=asyncio.Event)


class RobotVoice(Speaker):
    """Speaks on one robot, one text at a time; others wait their turn.

    Args:
        synthesizer: synthesizes texts.
        robot: the robot.
        clock: the media clock.
    """

    def __init__(self, synthesizer: SpeechSynthesizer, robot: Reachy, clock: MediaClock) -> None:
        super().__init__(synthesizer)
        self._robot = robot
        self._clock = clock
        self._turn = asyncio.Lock()
        self._sayings: list[_Saying] = []

    def available(self) -> tuple[bool, str]:
        """Return whether texts can be spoken and heard now; if not, why, or what to install."""
        if problem := self._robot.told.sound_problem:
            return False, problem
        return super().available()

    async def say(self, text: str, *, ssml: bool, language: str, character: str, volume: int) -> None:
        """Speak a text until its last sample was heard; cancelling this cuts it off."""
        if len(self._sayings) >= _MOST:
            raise OutOfResources(f"{_MOST} speeches wait already, which is the limit; wait until one has ended")
        saying = _Saying()
        saying.going_on.set()
        self._sayings.append(saying)
        try:
            speech = await self.make_speech(text, ssml=ssml, language=language, character=character, volume=volume)
            async with self._turn:
                await self._robot.link.during(self._play_all(speech, saying))
        finally:
            saying.over.set()
            self._sayings.remove(saying)

    def interrupt(self, why: str) -> None:
        """Cut off all speeches, also those that wait; the sound ends when the daemon has stopped it."""
        for saying in self._sayings:
            saying.cut_off = why
            saying.disturbed.set()
            saying.going_on.set()

    async def silent(self) -> None:
        """Wait until every `say` that has begun has ended; after `interrupt` that takes no time."""
        for saying in tuple(self._sayings):
            await saying.over.wait()

    def pause(self) -> None:
        """Fall silent until `go_on`."""
        for saying in self._sayings:
            saying.going_on.clear()
            saying.disturbed.set()

    def go_on(self) -> None:
        """Resume where it was paused, in the middle of a word too."""
        for saying in self._sayings:
            if not saying.cut_off:
                saying.disturbed.clear()
            saying.going_on.set()

    async def _play_all(self, speech: Speech, saying: _Saying) -> None:
        rest: Speech | None = speech
        while rest is not None:
            await saying.going_on.wait()
            if saying.cut_off:
                raise Aborted(f"{saying.cut_off} {place_of(saying.last)}")
            rest = await self._play(rest, saying)

    async def _play(self, speech: Speech, saying: _Saying) -> Speech | None:
        """Play a speech, and return what was not heard of it; None where all was."""
        if problem := self._robot.told.sound_problem:
            raise ComponentFailed(problem)
        name = f"openrois-{secrets.token_hex(8)}.wav"
        daemon = self._robot.daemon
        await daemon.upload_sound(name, wave_file(speech))
        try:
            if saying.disturbed.is_set():
                return speech
            await daemon.post("/api/media/play_sound", {"file": name})
            begun = self._clock.now()
            try:
                await self._pass(speech.duration + _LATENESS, saying)
            finally:
                heard = self._clock.now() - begun
                saying.last = _last(speech, heard) or saying.last
                if heard < speech.duration + _LATENESS:
                    await daemon.post("/api/media/stop_sound")
            return None if heard >= speech.duration else speech.after(round(heard * SAMPLE_RATE))
        finally:
            with suppress(RoISError):
                await daemon.delete(f"/api/media/sounds/{name}")

    async def _pass(self, seconds: float, saying: _Saying) -> None:
        """Let so much time pass, or less where the speech is disturbed."""
        waits: tuple[Coroutine[Any, Any, Any], ...] = (
            self._clock.sleep_until(self._clock.now() + seconds),
            saying.disturbed.wait(),
        )
        tasks = [asyncio.ensure_future(each) for each in waits]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()


def wave_file(speech: Speech) -> bytes:
    """Return a speech as a WAV file."""
    file = BytesIO()
    with wave.open(file, "wb") as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(SAMPLE_RATE // _EVERY)
        sound.writeframes(speech.samples[::_EVERY].astype("<i2").tobytes())
    return file.getvalue()


def _last(speech: Speech, heard: float) -> Word | None:
    """Return the last word that was begun when so many seconds were heard."""
    begun = [word for word in speech.words if word.offset_ms <= heard * 1000]
    return begun[-1] if begun else None
