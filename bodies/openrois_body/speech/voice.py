"""The voice: texts are synthesized and played, and the mouth moves with the sound."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager
from typing import Final

from openrois_streaming.source.source import SAMPLE_RATE

from openrois.aio.listeners import Listeners
from openrois.errors import Aborted, OutOfResources, RoISError
from openrois_body.body import Body
from openrois_body.sound.mixer import BodySound, SoundBusy
from openrois_body.speech.contract import SpeechChunk, SpeechSynthesizer
from openrois_body.speech.lips import Lips, ToldLips
from openrois_body.speech.playout_delay import PlayoutDelay
from openrois_body.speech.progress import Progress
from openrois_body.speech.speaker import Speaker
from openrois_body.speech.turns import Line
from openrois_body.speech.utterance import Utterance

__all__ = ["AHEAD", "Voice"]

AHEAD: Final = 30.0
"""Seconds of a text's sound that are taken from its synthesizer before they are played."""


class Voice(Speaker):
    """Speaks through the body's sound, and moves its mouth.

    Args:
        synthesizer: synthesizes texts.
        sound: the body's sound.
        body: moves the mouth.
    """

    def __init__(self, synthesizer: SpeechSynthesizer, sound: BodySound, body: Body) -> None:
        super().__init__(synthesizer)
        self.playout_delay = PlayoutDelay()
        """The playout delay of the viewers that hear it."""
        self.progress: Listeners[Progress] = Listeners()
        """Called with each word when the viewers hear it, each mark, and the end of each speech."""
        self._sound = sound
        self._body = body
        self._line = Line(sound.clock)
        self._utterances: list[Utterance] = []
        self._saying: list[asyncio.Event] = []
        """Of each text that is said, set when that has ended."""

    async def say(self, text: str, *, ssml: bool, language: str, character: str, volume: int) -> None:
        """Speak a text until the viewers heard its last sample; cancelling this cuts voice and mouth within 20 ms."""
        lips = ToldLips() if self._synthesizer.tells_visemes else None
        utterance = self.make_utterance(text, ssml=ssml, lips=lips)
        opened = self.open_speech(text, ssml=ssml, language=language, character=character, volume=volume)
        feeding = asyncio.create_task(_feed(utterance, lips, opened), name="speech that comes")
        ended = asyncio.Event()
        self._saying.append(ended)
        try:
            await self.utter(utterance)
        except Aborted:
            if feeding.done() and not feeding.cancelled():
                feeding.result()
            raise
        finally:
            feeding.cancel()
            try:
                await asyncio.wait({feeding})
            finally:
                self._saying.remove(ended)
                ended.set()
            if not feeding.cancelled():
                # Of its failure `cut` has told.
                feeding.exception()

    def make_utterance(
        self,
        text: str = "",
        *,
        ssml: bool = False,
        lips: Lips | None = None,
        on_played: Callable[[int], None] = lambda _samples: None,
        on_progress: Callable[[Progress], None] = lambda _progress: None,
    ) -> Utterance:
        """Return a speech that is pushed as sound while `utter` plays it.

        Args:
            text: what is spoken, as far as it is known.
            ssml: whether `text` is SSML.
            lips: give the shapes of its mouth; those that are read from the sound unless given.
            on_played: called with the number of samples that were played, ten times a second.
            on_progress: called with each step of this speech, before `progress` is; must not raise.
        """

        def tell(progress: Progress) -> None:
            on_progress(progress)
            self.progress.notify_all(progress)

        return Utterance(
            self._sound,
            self._body,
            self.playout_delay,
            tell,
            self._line,
            text=text,
            is_ssml=ssml,
            lips=lips,
            on_played=on_played,
        )

    async def utter(self, utterance: Utterance) -> None:
        """Play a speech of `make_utterance` until the viewers heard its last sample; cancelling this cuts it off.

        Raises:
            Aborted: it was cut off; the sentence says why and where.
            OutOfResources: too many speeches wait already.
        """
        self._utterances.append(utterance)
        try:
            await utterance.play()
        except SoundBusy as error:
            raise OutOfResources(str(error)) from error
        finally:
            self._utterances.remove(utterance)

    def interrupt(self, why: str) -> None:
        """Cut off all speeches, also those that wait: voice and mouth stop within a block of sound (20 ms)."""
        for utterance in self._utterances:
            utterance.cut(why)

    async def silent(self) -> None:
        """Wait until every `say` and `utter` that has begun has ended; after `interrupt` that takes no time."""
        for ended in (*(utterance.over for utterance in self._utterances), *self._saying):
            await ended.wait()

    def pause(self) -> None:
        """Fall silent within a block of sound, until `go_on`."""
        for utterance in self._utterances:
            utterance.pause()

    def go_on(self) -> None:
        """Resume where it was paused, in the middle of a word too."""
        for utterance in self._utterances:
            utterance.go_on()


async def _feed(
    utterance: Utterance,
    lips: ToldLips | None,
    opened: AbstractAsyncContextManager[AsyncIterator[SpeechChunk]],
) -> None:
    """Push a text's sound while it is made; where that fails in the middle the rest is not heard."""
    try:
        async with opened as chunks:
            async for chunk in chunks:
                utterance.add_moments((*chunk.words, *chunk.marks))
                if lips is not None:
                    lips.add(chunk.visemes)
                for first in range(0, len(chunk.samples), SAMPLE_RATE):
                    await utterance.room(AHEAD)
                    utterance.push(chunk.samples[first : first + SAMPLE_RATE])
    except RoISError as error:
        utterance.cut(f"{error}; the speech ended")
        raise
    except BaseException:
        utterance.cut("the speech ended")
        raise
    utterance.finish()
