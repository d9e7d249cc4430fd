"""What a streamer and one of its players say to each other over their data channel. Pure: it is told the time."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

from openrois_streaming.input.messages import Message as InputMessage
from openrois_streaming.network.guard import Allowance

from openrois_avatar.pixel_streaming import protocol
from openrois_avatar.pixel_streaming.hands import Hands
from openrois_avatar.pixel_streaming.protocol import Message, MessageError

__all__ = ["AT_ONCE", "MALFORMED_LIMIT", "PER_SECOND", "Conversation", "Figures", "Stage"]

AT_ONCE: Final = 500
PER_SECOND: Final = 1500.0
"""Messages of one player. A page with a gamepad sends all its axes and pressed buttons with each picture of the screen,
which is 250 a second and more."""

MALFORMED_LIMIT: Final = 32
"""Messages that cannot be read, after which nothing more is."""

_SETTINGS: Final = {
    "PixelStreaming": {"AllowPixelStreamingCommands": False, "DisableLatencyTest": False},
    "Encoder": {},
    "WebRTC": {},
    # The avatar looks where the pointer is, so that it must not be locked.
    "ConfigOptions": {"DefaultToHover": True},
}


class Stage(Protocol):
    """What a player looks at."""

    def send(self, message: bytes) -> None:
        """Send the player a message."""
        ...

    def show_anew(self) -> None:
        """The player needs a picture that stands for itself."""
        ...

    def play(self, on: bool) -> None:
        """The player wants to see and hear, or not."""
        ...

    def operate(self, message: InputMessage, hands: Hands) -> None:
        """The player does something."""
        ...


@dataclass(slots=True)
class Figures:
    """The messages of one player, by what became of them."""

    read: int = 0
    unknown: int = 0
    """With numbers that are not known here."""
    malformed: int = 0
    excess: int = 0
    """Faster than they are taken."""
    refused: int = 0
    """What a person did whose turn it was not."""


class Conversation:
    """The conversation with one player, from the moment when its data channel is open.

    Args:
        stage: what it looks at.
        clock: seconds, monotonic.
        wall: seconds since the epoch.
    """

    def __init__(self, stage: Stage, clock: Callable[[], float], wall: Callable[[], float]) -> None:
        self.hands = Hands(clock)
        self.figures = Figures()
        self._stage = stage
        self._wall = wall
        self._allowance = Allowance(clock, AT_ONCE, PER_SECOND)
        self._owns = False
        self._open = False

    def opened(self) -> None:
        """The data channel is open."""
        self._open = True
        for table in protocol.tables():
            self._stage.send(table)
        self._say_who_operates()

    def own(self, on: bool) -> None:
        """The player operates the avatar from now on, or does not."""
        self._owns = on
        if self._open:
            self._say_who_operates()

    def take(self, data: str | bytes) -> None:
        """Take a message of the player."""
        if self.figures.malformed >= MALFORMED_LIMIT:
            return
        if not self._allowance.admits():
            self.figures.excess += 1
            return
        try:
            if isinstance(data, str):
                raise MessageError("a text, where all messages are binary")
            message = protocol.read(data)
            if message is None:
                self.figures.unknown += 1
                return
            self._do(message)
        except MessageError:
            self.figures.malformed += 1
        else:
            self.figures.read += 1

    def _do(self, message: Message) -> None:
        match message:
            case Message("IFrameRequest"):
                self._stage.show_anew()
            case Message("StartStreaming" | "StopStreaming"):
                self._stage.play(message.name == "StartStreaming")
            case Message("RequestQualityControl"):
                # Each player is sent what its own path carries; there is nothing for one of them to decide.
                self._stage.send(protocol.flag("QualityControlOwnership", False))
            case Message("RequestInitialSettings"):
                self._stage.send(protocol.text("InitialSettings", json.dumps(_SETTINGS)))
            case Message("GamepadConnected"):
                number = self.hands.add_pad()
                if number is not None:
                    self._stage.send(protocol.text("GamepadResponse", json.dumps({"controllerId": number})))
            case _:
                self._measure(message)

    def _measure(self, message: Message) -> None:
        match message:
            case Message("LatencyTest"):
                now = round(self._wall() * 1000)
                times = {"ReceiptTimeMs": now, "TransmissionTimeMs": now}
                self._stage.send(protocol.text("LatencyTest", json.dumps(times)))
            case Message("TestEcho"):
                self._stage.send(protocol.flag("TestEcho", True))
            case _:
                for each in self.hands.take(message):
                    self._stage.operate(each, self.hands)

    def _say_who_operates(self) -> None:
        self._stage.send(protocol.flag("InputControlOwnership", self._owns))
