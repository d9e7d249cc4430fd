"""The messages between a streamer and one of its players over their data channel. Pure: the clock is an argument."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

from openrois_streaming.input.messages import Message as InputMessage
from openrois_streaming.network.guard import Allowance

from openrois_avatar.pixel_streaming import protocol
from openrois_avatar.pixel_streaming.player_input import PlayerInput
from openrois_avatar.pixel_streaming.protocol import Message, MessageError

__all__ = ["AT_ONCE", "MALFORMED_LIMIT", "PER_SECOND", "Conversation", "Figures", "Stage"]

AT_ONCE: Final = 500
PER_SECOND: Final = 1500.0
"""Messages of one player. A page with a gamepad sends all its axes and pressed buttons with each picture of the screen,
which is 250 a second and more."""

MALFORMED_LIMIT: Final = 32
"""Malformed messages, after which no more are read."""

_SETTINGS: Final = {
    "PixelStreaming": {"AllowPixelStreamingCommands": False, "DisableLatencyTest": False},
    "Encoder": {},
    "WebRTC": {},
    # The avatar looks where the pointer is, so the pointer must not be locked.
    "ConfigOptions": {"DefaultToHover": True},
}


class Stage(Protocol):
    """The side of the adapter in a conversation."""

    def send(self, message: bytes) -> None:
        """Send the player a message."""
        ...

    def show_anew(self) -> None:
        """Send a key frame."""
        ...

    def play(self, on: bool) -> None:
        """Play or suspend the streams."""
        ...

    def operate(self, message: InputMessage, player_input: PlayerInput) -> None:
        """Handle input of the player."""
        ...


@dataclass(slots=True)
class Figures:
    """Counts of the messages of one player, by outcome."""

    read: int = 0
    unknown: int = 0
    """Messages with unknown ids."""
    malformed: int = 0
    excess: int = 0
    """Messages beyond the rate limit."""
    refused: int = 0
    """Input of a player that does not operate."""


class Conversation:
    """The conversation with one player, from the opening of its data channel on.

    Args:
        stage: the side of the adapter.
        clock: seconds, monotonic.
        wall: seconds since the epoch.
    """

    def __init__(self, stage: Stage, clock: Callable[[], float], wall: Callable[[], float]) -> None:
        self.player_input = PlayerInput(clock)
        self.figures = Figures()
        self._stage = stage
        self._wall = wall
        self._allowance = Allowance(clock, AT_ONCE, PER_SECOND)
        self._owns = False
        self._open = False

    def opened(self) -> None:
        """Send the message tables: the data channel is open."""
        self._open = True
        for table in protocol.tables():
            self._stage.send(table)
        self._send_ownership()

    def own(self, on: bool) -> None:
        """Report to the player whether it operates the avatar from now on."""
        self._owns = on
        if self._open:
            self._send_ownership()

    def handle_message(self, data: str | bytes) -> None:
        """Handle a message of the player."""
        if self.figures.malformed >= MALFORMED_LIMIT:
            return
        if not self._allowance.admits():
            self.figures.excess += 1
            return
        try:
            if isinstance(data, str):
                raise MessageError("the message is a text; all messages are binary")
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
                # Each player is sent what its own path carries; no player decides for the others.
                self._stage.send(protocol.flag("QualityControlOwnership", False))
            case Message("RequestInitialSettings"):
                self._stage.send(protocol.text("InitialSettings", json.dumps(_SETTINGS)))
            case Message("GamepadConnected"):
                number = self.player_input.add_pad()
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
                for each in self.player_input.read_changes(message):
                    self._stage.operate(each, self.player_input)

    def _send_ownership(self) -> None:
        self._stage.send(protocol.flag("InputControlOwnership", self._owns))
