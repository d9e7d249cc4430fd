"""SpeechRecognition: when the operator speaks, and what is said (component 9)."""

from datetime import UTC, datetime
from typing import Annotated, Any

from openrois_streaming.clock import MediaClock, wall_at
from pydantic import Field

from openrois.adapter import BadParameter, ComponentStatus, ErrorType, components, parameter
from openrois_body.components.sensing import Sense
from openrois_body.hearing.recognition import Recognition
from openrois_body.hearing.recognizer import OTHER_SPEECH, Expectation, SpeechRecognizer
from openrois_body.hearing.speech_detector import SpeechDetector

__all__ = ["SpeechRecognition"]

Languages = Annotated[tuple[Annotated[str, Field(max_length=35)], ...], Field(min_length=1, max_length=16)]


class SpeechRecognition(Sense, components.SpeechRecognition):
    """Announces when speech begins and ends, and what may have been said, the likeliest first.

    Args:
        speech: tells when the operator speaks.
        recognition: recognises each utterance.
        recognizer: its backend.
        clock: the media clock.
    """

    languages: Languages = parameter(
        ("en",), description="ISO 639-1 codes of what is spoken, of recognizable_languages"
    )
    grammar: Annotated[str, Field(max_length=16_384)] = parameter(
        "default", description="`default`: anything; or the text of a grammar in JSGF"
    )
    rule: Annotated[str, Field(max_length=64)] = parameter(
        "default", description="the grammar's public rule to begin with; `default` is its first"
    )

    def __init__(
        self, speech: SpeechDetector, recognition: Recognition, recognizer: SpeechRecognizer, clock: MediaClock
    ) -> None:
        super().__init__()
        self._speech = speech
        self._recognition = recognition
        self._recognizer = recognizer
        self._clock = clock
        self._has_begun = False
        """Whether a beginning was announced, and its end was not yet."""
        if not set(self.languages) <= set(recognizer.languages):
            self.languages = recognizer.languages[:1]
        self._works, _ = recognizer.available()
        recognition.expected = self._expected
        speech.speech_began.add(self._began)
        speech.speech_ended.add(self._ended)
        recognition.recognized.add(self._on_recognized)
        recognition.failed.add(lambda reason: self.report(ErrorType.COMPONENT_INTERNAL_ERROR, reason))
        self.activity.while_working(self._recognition.want)

    def condition(self) -> ComponentStatus:
        """Return READY where a recogniser is installed and works, else ERROR."""
        return ComponentStatus.READY if self._works and not self._recognition.failure else ComponentStatus.ERROR

    def problem(self) -> str:
        """Return why speech is not recognised now, or what to install."""
        return self._recognition.failure or self._recognizer.available()[1]

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse an unknown language and an unusable grammar."""
        languages = changes.get("languages", self.languages)
        unknown = [each for each in languages if _code(each) not in self._recognizer.languages]
        if unknown:
            known = ", ".join(self._recognizer.languages)
            raise BadParameter(f"{', '.join(unknown)} cannot be recognised here; recognizable_languages has {known}")
        grammar, rule = changes.get("grammar", self.grammar), changes.get("rule", self.rule)
        if "grammar" in changes and "rule" not in changes:
            changes, rule = {**changes, "rule": "default"}, "default"
        if reason := self._recognizer.refusal(Expectation(languages, grammar, rule)):
            raise BadParameter(reason)
        return changes

    async def recognizable_languages(self) -> tuple[str, ...]:
        """Return the ISO 639-1 codes that `languages` takes."""
        return self._recognizer.languages

    def _expected(self) -> Expectation:
        return Expectation(tuple(_code(each) for each in self.languages), self.grammar, self.rule)

    def _moment(self, at: float) -> datetime:
        return datetime.fromtimestamp(wall_at(self._clock, at), UTC)

    def _began(self, at: float) -> None:
        if self.activity.works:
            self._has_begun = True
            self.visitor_ref = self._speech.sender
            self.speech_input_started(self._moment(at))

    def _ended(self, at: float) -> None:
        if self._has_begun:
            self._has_begun = False
            self.visitor_ref = self._speech.sender
            self.speech_input_finished(self._moment(at))

    def _on_recognized(self, candidates: tuple[str, ...], at: float, sender: str) -> None:
        if self.activity.works and candidates != (OTHER_SPEECH,):
            self.visitor_ref = sender
            self.speech_recognized(candidates, self._moment(at))


def _code(language: str) -> str:
    """Return the ISO 639-1 code of a language tag: `en` of `en-GB`."""
    return language.replace("_", "-").partition("-")[0].lower()
