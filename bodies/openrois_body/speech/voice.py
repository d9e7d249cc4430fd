"""The voice: texts are synthesized and played, and the mouth moves with the sound."""

from openrois.aio.listeners import Listeners
from openrois.errors import OutOfResources
from openrois_body.body import Body
from openrois_body.sound.mixer import BodySound, SoundBusy
from openrois_body.speech.playout_delay import PlayoutDelay
from openrois_body.speech.speaker import Speaker, Synthesis
from openrois_body.speech.utterance import Progress, Utterance

__all__ = ["Voice"]


class Voice(Speaker):
    """Speaks through the body's sound, and moves its mouth.

    Args:
        synthesizer: synthesizes texts.
        sound: the body's sound.
        body: moves the mouth.
    """

    def __init__(self, synthesizer: Synthesis, sound: BodySound, body: Body) -> None:
        super().__init__(synthesizer)
        self.playout_delay = PlayoutDelay()
        """The playout delay of the viewers that hear it."""
        self.progress: Listeners[Progress] = Listeners()
        """Called with each word when the viewers hear it, each mark, and the end of each speech."""
        self._sound = sound
        self._body = body
        self._utterances: list[Utterance] = []

    async def say(self, text: str, *, ssml: bool, language: str, character: str, volume: int) -> None:
        """Speak a text until the viewers heard its last sample; cancelling this cuts voice and mouth within 20 ms."""
        utterance = Utterance(self._sound, self._body, self.playout_delay, self.progress.notify_all, text, is_ssml=ssml)
        self._utterances.append(utterance)
        try:
            speech = await self.make_speech(text, ssml=ssml, language=language, character=character, volume=volume)
            await utterance.play(speech)
        except SoundBusy as error:
            raise OutOfResources(str(error)) from error
        finally:
            self._utterances.remove(utterance)

    def interrupt(self, why: str) -> None:
        """Cut off all speeches, also those that wait: voice and mouth stop within a block of sound (20 ms)."""
        for utterance in self._utterances:
            utterance.cut(why)

    async def silent(self) -> None:
        """Wait until every `say` that has begun has ended; after `interrupt` that takes no time."""
        for utterance in tuple(self._utterances):
            if utterance.begun:
                await utterance.over.wait()

    def pause(self) -> None:
        """Fall silent within a block of sound, until `go_on`."""
        for utterance in self._utterances:
            utterance.pause()

    def go_on(self) -> None:
        """Resume where it was paused, in the middle of a word too."""
        for utterance in self._utterances:
            utterance.go_on()
