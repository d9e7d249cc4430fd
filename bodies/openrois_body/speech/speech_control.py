"""Speech as a stream: the sound of the one application that holds the component, played by the body's voice."""

import json
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from openrois_streaming.clock import MediaClock
from openrois_streaming.input.credit import CreditReceiver
from openrois_streaming.input.messages import InputError
from openrois_streaming.input.reader import MALFORMED_LIMIT, Label
from openrois_streaming.input.speech import (
    Begin,
    Clear,
    End,
    Finished,
    Frame,
    Granted,
    Refused,
    SpeechMessage,
    SpeechTold,
    Started,
    Starved,
    Words,
    parse_frame,
    read_clear,
    read_speech,
)
from openrois_streaming.network.guard import Allowance
from openrois_streaming.peer.input_channels import InputSink

from openrois.aio.tasks import TaskScope
from openrois.contract import Client
from openrois.errors import Aborted, OutOfResources
from openrois.types.streams import HolderNotification
from openrois_body.holder import ComponentHolder
from openrois_body.sound.playback import SoundOverrun
from openrois_body.speech.contract import NamedMark, Word
from openrois_body.speech.progress import Progress, SpeechBegan, SpeechEnded, SpeechStarved
from openrois_body.speech.stream_sound import StreamSound
from openrois_body.speech.utterance import Utterance
from openrois_body.speech.voice import Voice

__all__ = [
    "FRAMES_AT_ONCE",
    "FRAMES_PER_SECOND",
    "STREAMS_AT_ONCE",
    "WORDS_AT_ONCE",
    "WORDS_PER_SECOND",
    "SpeechControl",
    "SpeechFigures",
    "SpeechOutcomes",
]

STREAMS_AT_ONCE: Final = 8
"""Speeches of one application that may be played or wait for their turn."""
FRAMES_AT_ONCE: Final = 1_000
FRAMES_PER_SECOND: Final = 500.0
"""Frames and messages of one application. One that sends packets of 2.5 ms has 400 frames a second."""
WORDS_AT_ONCE: Final = 1_000
WORDS_PER_SECOND: Final = 50.0
"""Words and marks of one application: each is an event to all that subscribe, and speech has five a second."""
_REFUSAL_INTERVAL: Final = 1.0
"""Seconds between two notices to an application that frames without a speech are dropped."""


@dataclass(slots=True)
class SpeechFigures:
    """Counts of what came over the channels of all applications, by outcome."""

    taken: int = 0
    """Frames that are played."""
    dropped: int = 0
    """Frames of speeches that are over, or were refused."""
    refused: int = 0
    """Speeches that were refused before their first sound."""
    malformed: int = 0
    """Messages and frames that cannot be read, or break a rule."""


@dataclass(slots=True)
class SpeechOutcomes:
    """Counts of speeches of all applications."""

    begun: int = 0
    starved: int = 0
    """How often one has run dry."""
    finished: int = 0
    """Heard to their end."""
    cut: int = 0
    """Interrupted."""


class SpeechControl:
    """Decides which application speaks by sound through one body: the one that holds its component.

    Args:
        component_ref: of the component that has to be bound.
        voice: plays it, in one line with all other speech.
        clock: for the pace of refusals.
        tasks: own what plays.
    """

    def __init__(self, component_ref: str, voice: Voice, clock: MediaClock, tasks: TaskScope) -> None:
        self.figures = SpeechFigures()
        self.outcomes = SpeechOutcomes()
        self.voice = voice
        self.clock = clock
        self.tasks = tasks
        self._held = ComponentHolder(component_ref)
        self._streams: list[_Stream] = []

    @property
    def streams(self) -> int:
        """Speeches that are played or wait for their turn."""
        return len(self._streams)

    @property
    def component_ref(self) -> str:
        """The component that has to be bound."""
        return self._held.component_ref

    @property
    def holder(self) -> Client | None:
        """The application that holds the component."""
        return self._held.client

    def apply_holder(self, notification: HolderNotification, client: Client) -> None:
        """Follow the gateway's notification of the application that holds a component."""
        lost = self._held.apply(notification, client)
        if lost:
            self.interrupt(lost)

    def forget_client(self, client: Client) -> None:
        """End the speech of an application that has disconnected."""
        if self._held.forget_client(client):
            self.interrupt("the application that spoke is gone")

    def speech_sink(self, client: Client, reply: Callable[[str], None]) -> InputSink:
        """Return the sink of what an application sends; `reply` sends it a message over `speech`."""
        return _ClientSpeech(self, client, reply)

    def interrupt(self, why: str) -> None:
        """Cut off all speeches that come as sound, also those that wait."""
        for stream in tuple(self._streams):
            stream.utterance.cut(why)

    def play(self, stream: "_Stream") -> None:
        """Play a speech that has begun, until it is over."""
        self._streams.append(stream)
        self.tasks.start(self._play(stream))

    async def _play(self, stream: "_Stream") -> None:
        try:
            await self.voice.utter(stream.utterance)
        except (Aborted, OutOfResources):
            pass  # The application was told when the speech ended.
        finally:
            self._streams.remove(stream)


class _Stream:
    """One speech of an application.

    Args:
        begin: how it began.
        tell: sends the application a message.
        control: whose voice plays it.
        ended: called when it is over.
    """

    def __init__(
        self, begin: Begin, tell: Callable[[SpeechTold], None], control: SpeechControl, ended: Callable[[int], None]
    ) -> None:
        self._number = begin.utterance
        self._outcomes = control.outcomes
        self._tell = tell
        self._ended = ended
        self._sound = StreamSound(begin.format, begin.rate)
        self._credit = CreditReceiver(begin.rate)
        self._sequence = 0
        self._text = begin.text
        """What is left of the text behind the last word that was found in it."""
        self._length = len(begin.text)
        """Characters of the whole text, with the words that it lacked."""
        self._place = 0
        """The character of the whole text at which what is left begins."""
        self.utterance: Utterance = control.voice.make_utterance(
            begin.text, on_played=self._played, on_progress=self._progressed
        )

    def forget_application(self) -> None:
        """Tell the application no more of it: its channels are lost."""
        self._tell = lambda _told: None
        self._ended = lambda _number: None

    def push(self, frame: Frame) -> None:
        """Append the sound of a frame. Raises InputError and SoundOverrun."""
        if frame.sequence != self._sequence:
            raise InputError(f"frame {frame.sequence} came where {self._sequence} was due: sound was lost on the way")
        self._sequence += 1
        samples = self._sound.read(frame.sound)
        self._credit.receive(self._sound.count(samples))
        self.utterance.push(self._sound.resample(samples))

    def handle(self, message: Words | End) -> None:
        """Handle a message about it. Raises SoundOverrun."""
        if isinstance(message, End):
            self.utterance.push(self._sound.finish())
            self.utterance.finish()
            return
        words = [Word(float(each.start_ms), each.text, self._place_of(each.text)) for each in message.words]
        self.utterance.add_moments([*words, *(NamedMark(float(each.start_ms), each.text) for each in message.marks)])

    def _place_of(self, word: str) -> int:
        """Return where a word stands in the text; one that is not found in what is left is added to its end."""
        found = self._text.find(word)
        if found < 0:
            place = self._length + 1 if self._length else 0
            self._length = place + len(word)
            return place
        place = self._place + found
        self._text = self._text[found + len(word) :]
        self._place = place + len(word)
        return place

    def _played(self, samples: int) -> None:
        played = self._sound.counted(samples)
        granted = self._credit.grant(played)
        if granted is not None:
            self._tell(Granted(self._number, granted, played))

    def _progressed(self, progress: Progress) -> None:
        match progress:
            case SpeechBegan(speech_id):
                self._tell(Started(self._number, speech_id))
            case SpeechStarved(_, heard_ms):
                self._outcomes.starved += 1
                self._tell(Starved(self._number, heard_ms))
            case SpeechEnded(_, _, reason):
                self._outcomes.finished += not reason
                self._outcomes.cut += bool(reason)
                self._ended(self._number)
                self._tell(Finished(self._number, progress.heard_ms, reason))


class _ClientSpeech:
    """The speech of one application; an `InputSink`."""

    def __init__(self, control: SpeechControl, client: Client, reply: Callable[[str], None]) -> None:
        self._control = control
        self._client = client
        self._reply = reply
        self._streams: dict[int, _Stream] = {}
        self._newest = -1
        """The greatest number of a speech so far."""
        self._cleared: deque[int] = deque(maxlen=STREAMS_AT_ONCE)
        """Speeches that were cleared before they began: `clear` overtakes."""
        self._malformed = 0
        self._allowance = Allowance(control.clock.now, FRAMES_AT_ONCE, FRAMES_PER_SECOND)
        self._words = Allowance(control.clock.now, WORDS_AT_ONCE, WORDS_PER_SECOND)
        self._refused_at: float | None = None

    def input_came(self, label: Label, data: str | bytes) -> None:
        if self._malformed >= MALFORMED_LIMIT:
            return
        if not self._allowance.admits() and label == "speech":
            self._control.figures.dropped += 1
            self._cut_all(f"more than {FRAMES_PER_SECOND:g} frames and messages a second came: send longer ones")
            return
        try:
            if isinstance(data, bytes):
                self._push(parse_frame(data))
            elif label == "control":
                self._clear(read_clear(data))
            else:
                self._handle(read_speech(data))
        except InputError as fault:
            self._note_fault(str(fault))

    def input_lost(self, reason: str) -> None:
        self._cut_all(reason)
        # What comes over other channels begins anew, as that of a program that was started again.
        for stream in self._streams.values():
            stream.forget_application()
        self._streams.clear()
        self._newest = -1
        self._cleared.clear()
        self._malformed = 0

    def _push(self, frame: Frame) -> None:
        stream = self._streams.get(frame.utterance)
        if stream is not None:
            self._control.figures.taken += 1
            self._on_stream(stream, lambda: stream.push(frame))
            return
        self._control.figures.dropped += 1
        if frame.utterance > self._newest:
            now = self._control.clock.now()
            if self._refused_at is None or now - self._refused_at >= _REFUSAL_INTERVAL:
                self._refused_at = now
                self._tell(Refused(frame.utterance, "a speech has to begin before its first frame"))

    def _handle(self, message: SpeechMessage) -> None:
        if isinstance(message, Begin):
            self._begin(message)
            return
        stream = self._streams.get(message.utterance)
        if isinstance(message, Words) and not self._words.admits(len(message.words) + len(message.marks)):
            self._control.figures.dropped += 1
            self._cut_all(f"more than {WORDS_PER_SECOND:g} words and marks a second came: send fewer")
        elif stream is not None:
            self._on_stream(stream, lambda: stream.handle(message))
        elif message.utterance > self._newest:
            raise InputError(f"the speech {message.utterance} has not begun")

    def _begin(self, begin: Begin) -> None:
        if begin.utterance <= self._newest:
            fault = f"utterance: must be greater than {self._newest}, the number of the last speech"
            if begin.utterance not in self._streams:
                self._tell(Refused(begin.utterance, fault))
            raise InputError(fault)
        self._newest = begin.utterance
        reason = self._refusal(begin)
        if reason:
            self._control.figures.refused += 1
            self._tell(Refused(begin.utterance, reason))
            return
        stream = self._streams[begin.utterance] = _Stream(begin, self._tell, self._control, self._forget)
        self._control.outcomes.begun += 1
        self._control.play(stream)

    def _refusal(self, begin: Begin) -> str:
        """Return why a speech cannot begin; empty if it can."""
        if self._control.holder is not self._client:
            return (
                f"{self._control.component_ref} has to be bound first; while it is lent, or a person has stopped the "
                "body for programs, an application that has bound it waits"
            )
        if begin.utterance in self._cleared:
            return "the speech was cleared"
        if len(self._streams) >= STREAMS_AT_ONCE:
            return f"{STREAMS_AT_ONCE} speeches wait already, which is the limit; wait until one has finished"
        return ""

    def _clear(self, clear: Clear) -> None:
        stream = self._streams.get(clear.utterance)
        if stream is not None:
            stream.utterance.cut("the speech was cleared")
        elif clear.utterance > self._newest:
            self._cleared.append(clear.utterance)

    def _on_stream(self, stream: _Stream, act: Callable[[], None]) -> None:
        """Act on a speech; what breaks a rule ends it."""
        try:
            act()
        except (InputError, SoundOverrun) as fault:
            stream.utterance.cut(str(fault))
            self._control.figures.malformed += 1

    def _note_fault(self, fault: str) -> None:
        self._malformed += 1
        self._control.figures.malformed += 1
        if self._malformed >= MALFORMED_LIMIT:
            self._cut_all(f"{MALFORMED_LIMIT} messages could not be read, the last one: {fault}")

    def _cut_all(self, reason: str) -> None:
        for stream in tuple(self._streams.values()):
            stream.utterance.cut(reason)

    def _forget(self, number: int) -> None:
        self._streams.pop(number, None)

    def _tell(self, told: SpeechTold) -> None:
        self._reply(json.dumps(told.to_json(), ensure_ascii=False))
