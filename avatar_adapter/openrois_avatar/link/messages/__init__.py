"""The JSON messages of the engine link: greeting, commands, events and farewell, checked on the way in.

Every `from_json` takes one decoded JSON object, raises `LinkError` naming the field that is wrong, and ignores members
it does not know, so that a later revision may add some. Every `to_json` gives the object that goes on the wire.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, TypeAlias

from openrois_avatar.link.messages.demand import Demand, Idle
from openrois_avatar.link.messages.encoding import Bitrate, KeyFrame
from openrois_avatar.link.messages.events import Completed, Log, Pause, Status
from openrois_avatar.link.messages.gestures import (
    MAX_VISEMES,
    VISEMES,
    Input,
    Look,
    Quit,
    React,
    Silence,
    Speak,
    Stop,
    Viseme,
)
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
from openrois_avatar.link.messages.motion import (
    Drive,
    Floor,
    Halt,
    Place,
    Reached,
    Thing,
    Things,
    Walk,
    Waypoint,
)
from openrois_avatar.link.messages.reading import MAX_NAME, MAX_TEXT, LinkError, text
from openrois_avatar.link.messages.viewpoint import Viewpoint

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

Command: TypeAlias = (
    React | Speak | Silence | Look | Stop | Walk | Drive | Halt | Input | Demand | KeyFrame | Bitrate | Viewpoint | Quit
)
Event: TypeAlias = Completed | Log | Pause | Idle | Reached | Place | Floor | Things

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
    """The command that the body of a COMMAND message names."""
    name = text(body, "command", MAX_NAME)
    read = _COMMANDS.get(name)
    if read is None:
        raise LinkError(f"command: unknown: {name!r}")
    return read(body)


def event_from_json(body: Mapping[str, Any]) -> Event:
    """The event that the body of an EVENT message names."""
    name = text(body, "event", MAX_NAME)
    read = _EVENTS.get(name)
    if read is None:
        raise LinkError(f"event: expected one of {', '.join(_EVENTS)}, not {name!r}")
    return read(body)
