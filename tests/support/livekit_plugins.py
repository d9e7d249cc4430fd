"""Speech recognition, language model and voice for LiveKit Agents that need no service."""

import asyncio
from collections.abc import Mapping
from typing import Any

import numpy as np
from livekit.agents import APIConnectOptions, llm, stt, tts
from livekit.agents.types import DEFAULT_API_CONNECT_OPTIONS

from tests.support.sounds import tone

__all__ = ["Beeps", "Pitches", "Rules"]

_LOUD = 1_000
_RATE = 16_000
_QUIET = 0.6
"""Seconds without sound that end what is said, and are not what a busy machine lost of it."""


class Pitches(stt.STT):
    """Recognises tones: each pitch is a word.

    Args:
        words: the word of each pitch.

    Attributes:
        heard: seconds of sound that were loud.
    """

    def __init__(self, words: Mapping[float, str]) -> None:
        super().__init__(capabilities=stt.STTCapabilities(streaming=True, interim_results=True))
        self.words = words
        self.heard = 0.0

    async def _recognize_impl(self, buffer: Any, **_: Any) -> stt.SpeechEvent:
        raise NotImplementedError("it recognises streams")

    def stream(self, *, conn_options: APIConnectOptions = DEFAULT_API_CONNECT_OPTIONS, **_: Any) -> "_Recognition":
        return _Recognition(stt=self, conn_options=conn_options, sample_rate=_RATE)


class _Recognition(stt.RecognizeStream):
    """Emits a word when a tone begins, and again when it is over."""

    async def _run(self) -> None:
        said = np.zeros(0, np.int16)
        quiet = 0.0
        async for frame in self._input_ch:
            if isinstance(frame, self._FlushSentinel):
                continue
            samples = np.frombuffer(frame.data, np.int16)
            if np.abs(samples.astype(int)).max(initial=0) > _LOUD:
                self._stt.heard += frame.duration
                if not len(said):
                    self._emit(stt.SpeechEventType.START_OF_SPEECH)
                said, quiet = np.concatenate((said, samples)), 0.0
                if len(said) >= _RATE // 10:
                    self._emit(stt.SpeechEventType.INTERIM_TRANSCRIPT, self._word(said))
            elif len(said) and (quiet := quiet + frame.duration) >= _QUIET:
                self._emit(stt.SpeechEventType.FINAL_TRANSCRIPT, self._word(said))
                self._emit(stt.SpeechEventType.END_OF_SPEECH)
                said = np.zeros(0, np.int16)

    def _word(self, said: Any) -> str:
        pitch = np.abs(np.fft.rfft(said)).argmax() * _RATE / len(said)
        words: Mapping[float, str] = self._stt.words
        return words[min(words, key=lambda each: abs(each - pitch))]

    def _emit(self, kind: stt.SpeechEventType, text: str = "") -> None:
        said = [stt.SpeechData(language="en", text=text)] if text else []
        self._event_ch.send_nowait(stt.SpeechEvent(type=kind, alternatives=said))


class Rules(llm.LLM):
    """Answers by rules.

    Args:
        answers: to what was said last.

    Attributes:
        asked: the first word of all that was said.
    """

    def __init__(self, answers: Mapping[str, str]) -> None:
        super().__init__()
        self.answers = answers
        self.asked: list[str] = []

    def chat(
        self,
        *,
        chat_ctx: llm.ChatContext,
        tools: list[llm.Tool] | None = None,
        conn_options: APIConnectOptions = DEFAULT_API_CONNECT_OPTIONS,
        **_: Any,
    ) -> "_Answer":
        return _Answer(self, chat_ctx=chat_ctx, tools=tools or [], conn_options=conn_options)


class _Answer(llm.LLMStream):
    async def _run(self) -> None:
        said = [each.text_content for each in self._chat_ctx.messages() if each.role == "user"]
        # A tone with a gap is two words.
        asked = (said[-1] or "").split(" ")[0] if said else ""
        self._llm.asked.append(asked)
        for word in self._llm.answers[asked].split(" "):
            self._event_ch.send_nowait(
                llm.ChatChunk(id="answer", delta=llm.ChoiceDelta(role="assistant", content=f"{word} "))
            )
            await asyncio.sleep(0)


class Beeps(tts.TTS):
    """A voice that beeps for so long as a text is, much faster than it is heard.

    Args:
        per_word: seconds of a word.
        pitches: of texts; 300 Hz unless given.
    """

    def __init__(self, per_word: float, pitches: Mapping[str, float]) -> None:
        super().__init__(capabilities=tts.TTSCapabilities(streaming=False), sample_rate=_RATE, num_channels=1)
        self.per_word = per_word
        self.pitches = pitches

    def synthesize(self, text: str, *, conn_options: APIConnectOptions = DEFAULT_API_CONNECT_OPTIONS) -> "_Sound":
        return _Sound(tts=self, input_text=text, conn_options=conn_options)


class _Sound(tts.ChunkedStream):
    async def _run(self, output_emitter: tts.AudioEmitter) -> None:
        output_emitter.initialize(request_id="beep", sample_rate=_RATE, num_channels=1, mime_type="audio/pcm")
        pitch = self._tts.pitches.get(self.input_text.strip(), 300)
        sound = tone(len(self.input_text.split()) * self._tts.per_word, _RATE, pitch)
        output_emitter.push(sound.tobytes())
        output_emitter.flush()
