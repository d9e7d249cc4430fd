"""Reads the input messages of an application, bounded in size and rate, and counts them. Pure."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from openrois_streaming.input.messages import MESSAGE_LIMIT, InputError, Message, read_change, read_state
from openrois_streaming.network.guard import Allowance

__all__ = ["AT_ONCE", "MALFORMED_LIMIT", "PER_SECOND", "InputFigures", "InputReader", "Label"]

Label: TypeAlias = Literal["input", "control", "speech"]
"""The channels: states that are lost or late without harm, changes that all come, in order, and speech as sound."""

AT_ONCE: Final = 200
PER_SECOND: Final = 200.0
"""Messages of one application, of both channels together. A page that sends with each picture has about 100."""

MALFORMED_LIMIT: Final = 32
"""Malformed messages after which the reader stops reading."""


@dataclass(slots=True)
class InputFigures:
    """Counts of the messages of one application."""

    read: int = 0
    malformed: int = 0
    """Malformed or too long messages."""
    excess: int = 0
    """Messages beyond the rate limit."""


class InputReader:
    """Reader for one application. `clock` gives seconds, monotonic."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self.figures = InputFigures()
        self.last_fault = ""
        """The fault of the last malformed message."""
        self._allowance = Allowance(clock, AT_ONCE, PER_SECOND)

    @property
    def is_cut(self) -> bool:
        """Whether the reader has stopped after too many malformed messages."""
        return self.figures.malformed >= MALFORMED_LIMIT

    def read(self, label: Label, data: str | bytes) -> Message | None:
        """Return the message in `data`; None if it is malformed, beyond the rate, or the reader is cut."""
        if self.is_cut:
            return None
        if not self._allowance.admits():
            self.figures.excess += 1
            return None
        try:
            message = _read(label, data)
        except InputError as fault:
            self.figures.malformed += 1
            self.last_fault = str(fault)
            return None
        self.figures.read += 1
        return message


def _read(label: Label, data: str | bytes) -> Message:
    if isinstance(data, bytes):
        raise InputError("the message is binary: send text")
    # A text has at least as many bytes as characters.
    if len(data) > MESSAGE_LIMIT or len(data.encode("utf-8", "surrogatepass")) > MESSAGE_LIMIT:
        raise InputError(f"the message has more than the {MESSAGE_LIMIT} bytes allowed")
    return read_state(data) if label == "input" else read_change(data)
