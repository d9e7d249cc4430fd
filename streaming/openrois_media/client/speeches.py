"""All speech by sound of one application: which number is whose, and what is lost with its channels."""

import itertools
import json
import logging
from collections import deque
from typing import Final

from openrois_streaming.input.messages import InputError
from openrois_streaming.input.speech import Begin, Clear, Finished, read_told

from openrois.client import ConnectionLost
from openrois_media.client.speaking import LOST, Speaking, SpeechSender
from openrois_media.client.stream import CarrierStream

__all__ = ["Speeches"]

_MOST_UNCLEAR: Final = 64
_NUMBERS: Final = itertools.count(1)
"""Of this process: an application may open its media anew, and a body takes none of its numbers twice."""
_log = logging.getLogger(__name__)


class Speeches:
    """The speeches that are not over, by their numbers, which no two speeches of an application share."""

    def __init__(self) -> None:
        self._spoken: dict[int, tuple[Speaking, SpeechSender, CarrierStream]] = {}
        self._unclear: deque[tuple[int, CarrierStream]] = deque(maxlen=_MOST_UNCLEAR)
        """Speeches that were lost, and are to be cleared where the body waits for the rest of them."""

    def next_number(self) -> int:
        """Return the number of the next speech."""
        return next(_NUMBERS)

    def begin_speech(self, begin: Begin, speaking: Speaking, carrier: CarrierStream) -> SpeechSender:
        """Begin a speech over the channels of a stream.

        Raises:
            ConnectionLost: none are open.
        """
        channel = carrier.channel
        if channel is None:
            raise ConnectionLost(f"there is no connection to {speaking.component_ref} now: {_why(carrier)}")
        sender = SpeechSender(begin, channel)
        self._spoken[begin.utterance] = speaking, sender, carrier
        return sender

    def handle(self, text: str) -> None:
        """Handle what a body tells."""
        try:
            told = read_told(text)
        except InputError as error:
            _log.warning("what a body tells of speech cannot be read: %s", error)
            return
        found = None if told is None else self._spoken.get(told.utterance)
        if told is None or found is None:
            return
        speaking, sender, _ = found
        speaking.handle(sender, told)
        if sender.result is not None:
            del self._spoken[told.utterance]

    def follow(self) -> None:
        """End what was spoken over channels that are closed now."""
        for number, (speaking, sender, carrier) in tuple(self._spoken.items()):
            if sender.channel.is_open:
                continue
            del self._spoken[number]
            self._unclear.append((number, carrier))
            speaking.handle(sender, Finished(number, round(sender.played * 1000), LOST))
        for number, carrier in tuple(self._unclear):
            if carrier.channel is not None:
                self._unclear.remove((number, carrier))
                carrier.channel.overtake(json.dumps(Clear(number).to_json()))


def _why(carrier: CarrierStream) -> str:
    return carrier.problem or "its data channels are not open"
