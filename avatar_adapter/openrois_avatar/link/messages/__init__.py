"""The JSON messages of the engine link: those of every body, with greeting, demand, encoding and farewell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, TypeAlias

from openrois_body.messages import (
    MAX_NAME,
    MAX_TEXT,
    MAX_VISEMES,
    VISEMES,
    Completed,
    Drive,
    Floor,
    Halt,
    Input,
    LinkError,
    Log,
    Look,
    Pause,
    Place,
    Quit,
    Reached,
    React,
    Silence,
    Speak,
    Status,
    Stop,
    Thing,
    Things,
    Viewpoint,
    Viseme,
    Walk,
    Waypoint,
)
from openrois_body.messages import Command as BodyCommand
from openrois_body.messages import Event as BodyEvent
from openrois_body.messages.reading import text

from openrois_avatar.link.messages.greeting import (
    FORMATS,
    MAX_CHANNELS,
    MAX_REACTIONS,
    MAX_SIDE,
    MIN_SIDE,
    SLOT_HEAD,
    Bye,
    Hello,
    RingPlace,
    VideoShape,
    Welcome,
)
from openrois_avatar.link.messages.picture_commands import Bitrate, Demand, Idle, KeyFrame

__all__ = [
    "FORMATS",
    "MAX_CHANNELS",
    "MAX_NAME",
    "MAX_REACTIONS",
    "MAX_SIDE",
    "MAX_TEXT",
    "MAX_VISEMES",
    "MIN_SIDE",
    "SLOT_HEAD",
    "VISEMES",
    "Bitrate",
    "Bye",
    "Command",
    "Completed",
    "Demand",
    "Drive",
    "Event",
    "Floor",
    "Halt",
    "Hello",
    "Idle",
    "Input",
    "KeyFrame",
    "LinkError",
    "Log",
    "Look",
    "Pause",
    "Place",
    "Quit",
    "Reached",
    "React",
    "RingPlace",
    "Silence",
    "Speak",
    "Status",
    "Stop",
    "Thing",
    "Things",
    "VideoShape",
    "Viewpoint",
    "Viseme",
    "Walk",
    "Waypoint",
    "Welcome",
    "command_from_json",
    "event_from_json",
]

Command: TypeAlias = BodyCommand | Demand | KeyFrame | Bitrate
Event: TypeAlias = BodyEvent | Idle

_COMMANDS: Final[Mapping[str, Callable[[Mapping[str, Any]], Command]]] = {
    "react": React.from_json,
    "speak": Speak.from_json,
    "silence": Silence.from_json,
    "look": Look.from_json,
    "stop": Stop.from_json,
    "walk": Walk.from_json,
    "drive": Drive.from_json,
    "halt": Halt.from_json,
    "input": Input.from_json,
    "demand": Demand.from_json,
    "key_frame": KeyFrame.from_json,
    "bitrate": Bitrate.from_json,
    "viewpoint": Viewpoint.from_json,
    "quit": Quit.from_json,
}
_EVENTS: Final[Mapping[str, Callable[[Mapping[str, Any]], Event]]] = {
    "completed": Completed.from_json,
    "log": Log.from_json,
    "pause": Pause.from_json,
    "idle": Idle.from_json,
    "reached": Reached.from_json,
    "place": Place.from_json,
    "floor": Floor.from_json,
    "things": Things.from_json,
}


def command_from_json(body: Mapping[str, Any]) -> Command:
    """Read the body of a COMMAND message."""
    name = text(body, "command", MAX_NAME)
    read = _COMMANDS.get(name)
    if read is None:
        raise LinkError(f"command: expected one of {', '.join(_COMMANDS)}, not {name!r}")
    return read(body)


def event_from_json(body: Mapping[str, Any]) -> Event:
    """Read the body of an EVENT message."""
    name = text(body, "event", MAX_NAME)
    read = _EVENTS.get(name)
    if read is None:
        raise LinkError(f"event: expected one of {', '.join(_EVENTS)}, not {name!r}")
    return read(body)
