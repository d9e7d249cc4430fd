"""The senses of the operator's microphone: three components of the standard and one of OpenRoIS."""

import asyncio
from dataclasses import dataclass

from openrois_media.devices import Microphone
from openrois_streaming.clock import MediaClock

from openrois.component.component import Component
from openrois_body.backends import chosen
from openrois_body.components.hearing import Hearing
from openrois_body.components.sound_detection import SoundDetection
from openrois_body.components.sound_localization import SoundLocalization
from openrois_body.components.speech_recognition import SpeechRecognition
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.recognition import Recognition
from openrois_body.hearing.recognizer import RECOGNIZERS, SpeechRecognizer
from openrois_body.hearing.speech_detector import SpeechDetector
from openrois_body.hearing.sphinx import Sphinx

__all__ = ["MicrophoneSenses", "microphone_senses"]


@dataclass(frozen=True, slots=True)
class MicrophoneSenses:
    """The components and what they share; `run` has to run."""

    components: tuple[Component, ...]
    speech: SpeechDetector
    """Detects when the operator speaks, so that a voice can be interrupted."""
    ear: Ear
    recognition: Recognition

    async def run(self) -> None:
        """Analyse sound until cancelled, while a sense is active."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self.ear.run(), name="ear")
            tasks.create_task(self.recognition.run(), name="speech recognition")


def microphone_senses(
    engine_id: str, microphone: Microphone, clock: MediaClock, recognizer: SpeechRecognizer | None = None
) -> MicrophoneSenses:
    """Return the senses of a microphone.

    Args:
        engine_id: leads every ref.
        microphone: source of the sound.
        clock: the media clock.
        recognizer: recognises speech; None for the best that is installed.
    """
    recognizer = recognizer or chosen(RECOGNIZERS, Sphinx)
    ear = Ear(microphone, clock)
    speech = SpeechDetector(ear)
    recognition = Recognition(speech, recognizer, clock)
    components = (
        SoundDetection(ear, clock),
        SoundLocalization(engine_id, ear, clock),
        SpeechRecognition(speech, recognition, recognizer, clock),
        Hearing(ear, speech, recognition, clock),
    )
    return MicrophoneSenses(components, speech, ear, recognition)
