"""The options of a body's voice and ears: which synthesizer speaks, which recogniser listens, and where they are."""

import argparse
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from openrois_streaming.clock import MediaClock

from openrois.cli.command_line import given_options
from openrois_body.backends import chosen, named
from openrois_body.hearing.recognizer import RECOGNIZERS, EarsSettings, SpeechRecognizer
from openrois_body.hearing.sphinx import Sphinx
from openrois_body.services.address import ServiceAddress, read_address
from openrois_body.speech.contract import DEFAULT_SYNTHESIZER, SYNTHESIZERS, SpeechSynthesizer, VoiceSettings

__all__ = [
    "EarsChoice",
    "VoiceChoice",
    "add_ears_options",
    "add_voice_options",
    "ears_arguments",
    "ears_choice",
    "voice_arguments",
    "voice_choice",
]

_OWN_EARS: Final = frozenset({"sphinx", "openai"})
"""Recognisers that come with this package; of others the first that works is used where none is named."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class VoiceChoice:
    """Which synthesizer speaks.

    Attributes:
        name: of its entry point.
        settings: of it.
    """

    name: str = DEFAULT_SYNTHESIZER
    settings: VoiceSettings = field(default_factory=VoiceSettings)

    def make(self, clock: MediaClock) -> SpeechSynthesizer:
        """Return the synthesizer, and log where it sends texts.

        Raises:
            ValueError: there is none of this name, or it cannot be loaded.
        """
        synthesizer: SpeechSynthesizer = named(SYNTHESIZERS, self.name, replace(self.settings, clock=clock))[0]
        if synthesizer.destination:
            _log.warning("speech: texts that are spoken are sent to %s", synthesizer.destination)
        return synthesizer


@dataclass(frozen=True, slots=True)
class EarsChoice:
    """Which recogniser listens.

    Attributes:
        name: of its entry point; empty: the first of another package that works, else PocketSphinx.
        settings: of it.
        consented: whether those who speak have agreed that their sound is sent to its server.
    """

    name: str = ""
    settings: EarsSettings = field(default_factory=EarsSettings)
    consented: bool = False

    def make(self) -> SpeechRecognizer:
        """Return the recogniser.

        Raises:
            ValueError: there is none of this name, or it cannot be loaded.
        """
        if self.name:
            recognizer: SpeechRecognizer = named(RECOGNIZERS, self.name, self.settings)[0]
            return recognizer
        return chosen(RECOGNIZERS, Sphinx, settings=(self.settings,), own=_OWN_EARS)

    @property
    def may_send(self) -> Callable[[], bool] | None:
        """Whether sound may be sent, as `Recognition` asks it: None leaves it to where the recogniser is."""
        return (lambda: True) if self.consented else None


def add_voice_options(parser: argparse.ArgumentParser) -> None:
    """Add `--voice` and the options that belong to it."""
    group = parser.add_argument_group(
        "voice", "what speaks: espeak-ng, a server with an API like OpenAI's, Piper, or another package's synthesizer"
    )
    group.add_argument(
        "--voice",
        metavar="NAME",
        help=f"espeak, openai, piper, or an entry point of {SYNTHESIZERS} (openai with --voice-url, piper with"
        f" --voice-file, else {DEFAULT_SYNTHESIZER})",
    )
    group.add_argument(
        "--voice-url", metavar="URL", help="of a server with /v1/audio/speech, as http://127.0.0.1:8880/v1"
    )
    group.add_argument("--voice-model", default="", metavar="NAME", help="that speaks at the server")
    group.add_argument(
        "--voice-name", default="", metavar="NAME[,NAME]", help="voices to choose from, the first one by default"
    )
    group.add_argument(
        "--voice-key-file", type=Path, metavar="FILE", help="holds the key for the server in its first line"
    )
    group.add_argument("--voice-file", type=Path, metavar="FILE", help="a voice of Piper, NAME.onnx")
    group.add_argument(
        "--speech-unencrypted",
        action="store_true",
        help="servers of other machines may be spoken to over http://, where it can be read on the way",
    )


def add_ears_options(parser: argparse.ArgumentParser) -> None:
    """Add `--ears` and the options that belong to it; `add_voice_options` adds one that they share."""
    group = parser.add_argument_group(
        "ears", "what recognises speech: PocketSphinx, a server with an API like OpenAI's, or another package's"
    )
    group.add_argument(
        "--ears",
        metavar="NAME",
        help=f"sphinx, openai, or an entry point of {RECOGNIZERS} (openai with --ears-url, else the first one of"
        " another package that works, else sphinx)",
    )
    group.add_argument(
        "--ears-url", metavar="URL", help="of a server with /v1/audio/transcriptions, as http://127.0.0.1:8000/v1"
    )
    group.add_argument("--ears-model", default="", metavar="NAME", help="that recognises at the server")
    group.add_argument(
        "--ears-key-file", type=Path, metavar="FILE", help="holds the key for the server in its first line"
    )
    group.add_argument(
        "--ears-consented",
        action="store_true",
        help="all who speak before the microphone have agreed that the sound is sent to a server on another machine;"
        " without it nothing is sent there, and with it nothing of visitors who do not consent to transfer",
    )


def voice_choice(chosen_options: argparse.Namespace) -> VoiceChoice:
    """Return what the options say of the voice.

    Raises:
        ValueError: they contradict each other, or the named synthesizer does not work here; a sentence for a person.
    """
    options = chosen_options
    names = tuple(name.strip() for name in options.voice_name.split(",") if name.strip())
    url = _address(options.voice_url, "--voice-url", "audio/speech", unencrypted=options.speech_unencrypted)
    settings = VoiceSettings(url, options.voice_model, names, options.voice_key_file, options.voice_file)
    if url is not None and options.voice_file is not None:
        raise ValueError("--voice-url and --voice-file are for two voices; give one of them")
    implied = "openai" if url is not None else "piper" if options.voice_file is not None else ""
    named_for = {"espeak": "", "openai": "openai", "piper": "piper"}
    if options.voice in named_for and implied not in {"", named_for[options.voice]}:
        wrong = "--voice-url" if url is not None else "--voice-file"
        raise ValueError(f"--voice {options.voice} does not use {wrong}; leave one of them out")
    name = options.voice or implied
    if name:
        _require(SYNTHESIZERS, "--voice", name, settings)
    return VoiceChoice(name or DEFAULT_SYNTHESIZER, settings)


def ears_choice(chosen_options: argparse.Namespace) -> EarsChoice:
    """Return what the options say of the ears.

    Raises:
        ValueError: they contradict each other, or the named recogniser does not work here; a sentence for a person.
    """
    options = chosen_options
    url = _address(options.ears_url, "--ears-url", "audio/transcriptions", unencrypted=options.speech_unencrypted)
    settings = EarsSettings(url, options.ears_model, options.ears_key_file)
    if options.ears == "sphinx" and url is not None:
        raise ValueError("--ears sphinx does not use --ears-url; leave one of them out")
    name = options.ears or ("openai" if url is not None else "")
    if name:
        _require(RECOGNIZERS, "--ears", name, settings)
    return EarsChoice(name, settings, options.ears_consented)


def voice_arguments(chosen_options: argparse.Namespace) -> Sequence[str]:
    """Return the options of the voice, for another command line."""
    return given_options(
        chosen_options,
        *("voice", "voice_url", "voice_model", "voice_name", "voice_key_file", "voice_file", "speech_unencrypted"),
    )


def ears_arguments(chosen_options: argparse.Namespace) -> Sequence[str]:
    """Return the options of the ears, for another command line."""
    return given_options(chosen_options, "ears", "ears_url", "ears_model", "ears_key_file", "ears_consented")


def _address(text: str | None, option: str, path: str, *, unencrypted: bool) -> ServiceAddress | None:
    if text is None:
        return None
    try:
        return read_address(text, path, unencrypted=unencrypted)
    except ValueError as error:
        raise ValueError(f"{option}: {error}") from None


def _require(group: str, option: str, name: str, settings: object) -> None:
    """Refuse a backend that does not work here, and say why."""
    try:
        _, problem = named(group, name, settings)
    except ValueError as error:
        raise ValueError(f"{option}: {error}") from None
    if problem:
        raise ValueError(f"{option} {name}: {problem}")
