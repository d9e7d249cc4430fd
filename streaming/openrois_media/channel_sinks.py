"""Sinks of what an application sends over its data channels: operator input, and speech as sound."""

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

from openrois_streaming.input.messages import InputError
from openrois_streaming.input.reader import Label
from openrois_streaming.input.speech import Begin, Refused, is_clear, read_speech
from openrois_streaming.peer.input_channels import InputSink

from openrois.contract import Client
from openrois.types.streams import HolderNotification

__all__ = ["ChannelSinks", "NoSpeech", "OperatorInput", "SpeechInput"]


class OperatorInput(Protocol):
    """Input of the application that operates a body by hand."""

    def apply_holder(self, notification: HolderNotification, client: Client) -> None:
        """Apply a notification on the application that holds a component."""
        ...

    def input_sink(
        self, client: Client, reply: Callable[[str], None], round_trip: Callable[[], float | None] = ...
    ) -> InputSink:
        """Return the sink of an application's input; `reply` sends it a message over its own channel."""
        ...

    def forget_client(self, client: Client) -> None:
        """Release an application that is gone."""
        ...


class SpeechInput(Protocol):
    """Speech of the application that speaks by sound through a body."""

    def apply_holder(self, notification: HolderNotification, client: Client) -> None:
        """Apply a notification on the application that holds a component."""
        ...

    def speech_sink(self, client: Client, reply: Callable[[str], None]) -> InputSink:
        """Return the sink of an application's speech; `reply` sends it a message over `speech`."""
        ...

    def forget_client(self, client: Client) -> None:
        """End the speech of an application that is gone."""
        ...


@dataclass(frozen=True, slots=True)
class NoSpeech:
    """Speech to a body that plays no sound of applications: it is refused.

    Attributes:
        reason: why, and what to use instead.
    """

    reason: str = "this body plays no sound of applications: use its speech_synthesizer where it has that"

    def apply_holder(self, notification: HolderNotification, client: Client) -> None:
        """Pass over who holds a component: no component speaks by sound."""

    def speech_sink(self, _client: Client, reply: Callable[[str], None]) -> InputSink:
        """Return a sink that refuses each speech when it begins."""
        return _Refusing(self.reason, reply)

    def forget_client(self, client: Client) -> None:
        """Have nothing to end."""


@dataclass(frozen=True, slots=True)
class _Refusing:
    reason: str
    reply: Callable[[str], None]

    def input_came(self, _label: Label, data: str | bytes) -> None:
        with suppress(InputError):
            message = None if isinstance(data, bytes) else read_speech(data)
            if isinstance(message, Begin):
                self.reply(json.dumps(Refused(message.utterance, self.reason).to_json()))

    def input_lost(self, _reason: str) -> None:
        pass


@dataclass(frozen=True, slots=True)
class ChannelSinks:
    """Passes what comes over the channels of one application to the sink that it is meant for."""

    operator: InputSink | None
    speech: InputSink

    def input_came(self, label: Label, data: str | bytes) -> None:
        """Pass on a message as it came."""
        is_speech = label == "speech" or (label == "control" and isinstance(data, str) and is_clear(data))
        sink = self.speech if is_speech else self.operator
        if sink is not None:
            sink.input_came(label, data)

    def input_lost(self, reason: str) -> None:
        """Pass on that all channels were lost."""
        if self.operator is not None:
            self.operator.input_lost(reason)
        self.speech.input_lost(reason)
