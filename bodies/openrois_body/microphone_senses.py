"""The senses of the operator's microphone: three components of the standard and one of OpenRoIS."""

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

from openrois_media.devices import Microphone
from openrois_media.visitors.registry import VisitorRegistry
from openrois_media.visitors.visitor import Visitor
from openrois_streaming.clock import MediaClock

from openrois.component.component import Component
from openrois.types.codes import Purpose
from openrois_body.components.hearing import Hearing
from openrois_body.components.sound_detection import SoundDetection
from openrois_body.components.sound_localization import SoundLocalization
from openrois_body.components.speech_recognition import SpeechRecognition
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.recognition import Recognition
from openrois_body.hearing.recognizer import SpeechRecognizer
from openrois_body.hearing.speech_detector import SpeechDetector

__all__ = ["MicrophoneSenses", "microphone_senses"]

_RECOGNITION: Final = frozenset({Purpose.RECOGNITION})


_log = logging.getLogger(__name__)


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
    engine_id: str,
    microphone: Microphone,
    clock: MediaClock,
    recognizer: SpeechRecognizer,
    may_send: Callable[[], bool] | None = None,
    visitors: VisitorRegistry | None = None,
) -> MicrophoneSenses:
    """Return the senses of a microphone.

    Args:
        engine_id: leads every ref.
        microphone: source of the sound.
        clock: the media clock.
        recognizer: recognises speech.
        may_send: whether sound may be sent to the recogniser, as `Recognition` asks it.
        visitors: those whose microphone it may be; None for one that needs no consent.
    """
    if recognizer.destination:
        _log.warning("recognised words: the sound of the microphone is sent to %s", recognizer.destination)
    ear = Ear(microphone, clock)
    speech = SpeechDetector(ear)
    purposes = purposes_of(recognizer)
    if visitors is None:
        recognition = Recognition(speech, recognizer, clock, may_send)
    else:
        recognition = Recognition(speech, recognizer, clock, may_send, partial(_admits, visitors, purposes))
    hearing = Hearing(ear, speech, recognition, clock)
    components = (
        SoundDetection(ear, clock),
        SoundLocalization(engine_id, ear, clock),
        SpeechRecognition(speech, recognition, recognizer, clock),
        hearing,
    )
    if visitors is not None:

        def forget(visitor: Visitor, withdrawn: frozenset[Purpose]) -> None:
            if withdrawn & purposes:
                recognition.forget_speech(visitor.visitor_ref)
            if withdrawn & _RECOGNITION:
                ear.forget_sound(visitor.visitor_ref)
                hearing.forget_words(visitor.visitor_ref)

        visitors.withdrawn.add(forget)
    return MicrophoneSenses(components, speech, ear, recognition)


def purposes_of(recognizer: SpeechRecognizer) -> frozenset[Purpose]:
    """Return what a visitor has to consent to for its speech to be given to a recogniser."""
    return _RECOGNITION | {Purpose.TRANSFER} if recognizer.destination else _RECOGNITION


def _admits(visitors: VisitorRegistry, purposes: frozenset[Purpose], sender: str, began_at: float) -> bool:
    return visitors.admits(sender, purposes, began_at)
