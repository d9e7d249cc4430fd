"""The senses of the operator's microphone put together: three components of the standard and one of ours."""

import asyncio
from dataclasses import dataclass

from openrois_streaming.clock import MediaClock

from openrois.component.component import Component
from openrois_avatar.backends import chosen
from openrois_avatar.components.hearing import Hearing as HearingComponent
from openrois_avatar.components.sound_detection import SoundDetection
from openrois_avatar.components.sound_localization import SoundLocalization
from openrois_avatar.components.speech_recognition import SpeechRecognition
from openrois_avatar.devices import Microphone
from openrois_avatar.hearing.ear import Ear
from openrois_avatar.hearing.hearing import Hearing
from openrois_avatar.hearing.recognition import Recognition
from openrois_avatar.hearing.recognizer import RECOGNIZERS, SpeechRecognizer
from openrois_avatar.hearing.sphinx import Sphinx

__all__ = ["MicrophoneSenses", "microphone_senses"]


@dataclass(frozen=True, slots=True)
class MicrophoneSenses:
    """The components, and what they share, which has to `run`."""

    components: tuple[Component, ...]
    hearing: Hearing
    """Tells when the operator speaks, for a voice that is to fall silent then."""
    ear: Ear
    recognition: Recognition

    async def run(self) -> None:
        """Hear for ever, while anybody listens."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self.ear.run(), name="ear")
            tasks.create_task(self.recognition.run(), name="speech recognition")


def microphone_senses(
    engine_id: str, microphone: Microphone, clock: MediaClock, recognizer: SpeechRecognizer | None = None
) -> MicrophoneSenses:
    """Return the senses of a microphone.

    Args:
        engine_id: leads every ref.
        microphone: whose sound.
        clock: the media clock.
        recognizer: what writes down speech; None for the best that is installed.
    """
    recognizer = recognizer or chosen(RECOGNIZERS, Sphinx)
    ear = Ear(microphone, clock)
    hearing = Hearing(ear)
    recognition = Recognition(hearing, recognizer, clock)
    components = (
        SoundDetection(ear, clock),
        SoundLocalization(engine_id, ear, clock),
        SpeechRecognition(hearing, recognition, recognizer, clock),
        HearingComponent(ear, hearing, recognition, clock),
    )
    return MicrophoneSenses(components, hearing, ear, recognition)
