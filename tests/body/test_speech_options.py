"""The options of voice and ears: what is chosen, and what is said of mistakes."""

import argparse
import logging
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from openrois_body import backends
from openrois_body.hearing.server_ears import ServerEars
from openrois_body.hearing.sphinx import Sphinx
from openrois_body.speech.piper import Piper
from openrois_body.speech.server_voice import ServerVoice
from openrois_body.speech.synthesizer import Synthesizer
from openrois_body.speech_options import (
    EarsChoice,
    VoiceChoice,
    add_ears_options,
    add_voice_options,
    ears_arguments,
    ears_choice,
    voice_arguments,
    voice_choice,
)

from tests.support.listening import ScriptedRecognizer
from tests.support.streaming import VirtualClock


def read(*arguments: str) -> tuple[VoiceChoice, EarsChoice]:
    parser = argparse.ArgumentParser()
    add_voice_options(parser)
    add_ears_options(parser)
    chosen = parser.parse_args(arguments)
    return voice_choice(chosen), ears_choice(chosen)


def refusal(*arguments: str) -> str:
    with pytest.raises(ValueError) as refused:
        read(*arguments)
    return str(refused.value)


def test_without_options_espeak_speaks_and_what_is_installed_listens() -> None:
    voice, ears = read()
    assert isinstance(voice.make(VirtualClock()), Synthesizer)
    assert isinstance(ears.make(), Sphinx)
    assert ears.may_send is None
    assert (voice, ears) == (VoiceChoice(), EarsChoice())


def test_the_address_of_a_server_chooses_it() -> None:
    voice, ears = read("--voice-url", "http://localhost:1/v1", "--ears-url", "https://h.example", "--ears-consented")
    assert (voice.name, ears.name) == ("openai", "openai")
    assert isinstance(voice.make(VirtualClock()), ServerVoice)
    recognizer = ears.make()
    assert isinstance(recognizer, ServerEars)
    assert recognizer.destination == "https://h.example"
    assert ears.may_send is not None
    assert ears.may_send()


def test_options_become_the_same_options_of_another_command_line() -> None:
    voice = ["--voice", "openai", "--voice-url", "https://h.example", "--voice-model", "m", "--voice-name", "a,b"]
    voice += ["--voice-key-file", "k", "--speech-unencrypted"]
    ears = ["--ears", "openai", "--ears-url", "http://192.0.2.7:1", "--ears-model", "w", "--ears-key-file", "k"]
    ears += ["--ears-consented"]
    parser = argparse.ArgumentParser()
    add_voice_options(parser)
    add_ears_options(parser)
    chosen = parser.parse_args([*voice, *ears])
    assert (voice_arguments(chosen), ears_arguments(chosen)) == (voice, ears)
    nothing = parser.parse_args([])
    assert (voice_arguments(nothing), ears_arguments(nothing)) == ([], [])


def test_names_models_and_keys_are_read() -> None:
    voice, _ = read(
        *("--voice", "openai", "--voice-url", "https://h.example", "--voice-model", "m", "--voice-name", "a, b,"),
        *("--voice-key-file", "k"),
    )
    assert voice.settings.names == ("a", "b")
    assert (voice.settings.model, voice.settings.key_file) == ("m", Path("k"))


def test_a_voice_file_chooses_piper_and_what_is_missing_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    file = tmp_path / "v.onnx"
    assert refusal("--voice-file", str(file)) == f"--voice piper: --voice-file: there is no file {file}"
    file.touch()
    file.with_name("v.onnx.json").write_text('{"audio": {"sample_rate": 22050}}')
    assert refusal("--voice-file", str(file)).startswith("--voice piper: the program piper is not installed: run")
    (tmp_path / "piper").write_text("#!/bin/sh\n")
    (tmp_path / "piper").chmod(0o755)
    voice, _ = read("--voice-file", str(file))
    assert isinstance(voice.make(VirtualClock()), Piper)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--voice", "alto"), "--voice: there is no 'alto'; there are espeak, openai, piper"),
        (("--ears", "alto"), "--ears: there is no 'alto'; there are openai, sphinx"),
        (
            ("--voice", "openai"),
            "--voice openai: the voice of a server needs its address: --voice-url https://example.org/v1",
        ),
        (
            ("--ears", "openai"),
            "--ears openai: recognition by a server needs its address: --ears-url https://example.org/v1",
        ),
        (("--voice", "piper"), "--voice piper: a voice of Piper needs its file: --voice-file VOICE.onnx"),
        (
            ("--voice", "espeak", "--voice-url", "https://h.example"),
            "--voice espeak does not use --voice-url; leave one of them out",
        ),
        (
            ("--voice", "openai", "--voice-file", "v.onnx"),
            "--voice openai does not use --voice-file; leave one of them out",
        ),
        (
            ("--voice-url", "https://h.example", "--voice-file", "v.onnx"),
            "--voice-url and --voice-file are for two voices; give one of them",
        ),
        (
            ("--ears", "sphinx", "--ears-url", "https://h.example"),
            "--ears sphinx does not use --ears-url; leave one of them out",
        ),
        (
            ("--ears-url", "http://h.example"),
            "--ears-url: h.example is not this machine, and what is said could be read on its way there; use https://,"
            " or allow it with --speech-unencrypted",
        ),
        (
            ("--voice-url", "h.example"),
            "--voice-url: 'h.example' is no address of a server; write one like https://example.org/v1 or"
            " http://127.0.0.1:8000/v1",
        ),
    ],
)
def test_a_mistake_is_named_with_its_remedy(arguments: tuple[str, ...], said: str) -> None:
    assert refusal(*arguments) == said


def test_other_machines_without_tls_may_be_allowed() -> None:
    _, ears = read("--ears-url", "http://192.168.1.20:8000", "--speech-unencrypted")
    assert ears.settings.url is not None
    assert ears.settings.url.destination == "http://192.168.1.20:8000"


class Elsewhere(ScriptedRecognizer):
    """A recogniser of another package, which gets its settings."""

    def __init__(self, settings: object) -> None:
        super().__init__()
        self.settings = settings


class Broken:
    """One that cannot be made."""

    def __init__(self, _settings: object) -> None:
        raise OSError("no such model")


def test_of_other_packages_the_first_recogniser_that_works_is_used_and_gets_the_settings(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    installed = backends.installed("openrois.speech_recognizers")
    added = [
        EntryPoint(name, f"tests.body.test_speech_options:{kind}", "openrois.speech_recognizers")
        for name, kind in (("a", "Broken"), ("whisper", "Elsewhere"))
    ]
    monkeypatch.setattr(backends.chosen, "__defaults__", (lambda _group: (*installed, *added),))
    monkeypatch.setattr(backends.named, "__defaults__", (lambda _group: (*installed, *added),))
    with caplog.at_level(logging.WARNING):
        recognizer = EarsChoice().make()
    assert type(recognizer).__name__ == "Elsewhere"
    assert "a does not work here: OSError('no such model')" in caplog.text
    assert "openai" not in caplog.text
    assert refusal("--ears", "a") == "--ears: a cannot be loaded: OSError('no such model')"
    assert read("--ears", "whisper")[1].name == "whisper"
    assert isinstance(EarsChoice("sphinx").make(), Sphinx)
