"""The messages between an adapter and the engine of its body: commands and events, checked when they are read. Pure.

Every `from_json` takes one decoded JSON object, raises `LinkError` naming the field that is wrong, and ignores members
it does not know, so that a later revision may add some. Every `to_json` gives the object that goes on the wire. They
need the standard library alone, as the side that moves the body imports them, too; that of a game engine has more.
"""

from __future__ import annotations

from typing import TypeAlias

from openrois_body.messages.events import Completed, Log, Pause, Status
from openrois_body.messages.gestures import (
    MAX_VISEMES,
    VISEMES,
    Input,
    Look,
    Quit,
    React,
    Silence,
    Speak,
    Stop,
    Viewpoint,
    Viseme,
)
from openrois_body.messages.motion import (
    FAR,
    MAX_PATH,
    Drive,
    Floor,
    Halt,
    Kind,
    Place,
    Point,
    Reached,
    Thing,
    Things,
    Walk,
    Waypoint,
)
from openrois_body.messages.reading import MAX_NAME, MAX_TEXT, LinkError

__all__ = [
    "FAR",
    "MAX_NAME",
    "MAX_PATH",
    "MAX_TEXT",
    "MAX_VISEMES",
    "VISEMES",
    "Command",
    "Completed",
    "Drive",
    "Event",
    "Floor",
    "Halt",
    "Input",
    "Kind",
    "LinkError",
    "Log",
    "Look",
    "Pause",
    "Place",
    "Point",
    "Quit",
    "Reached",
    "React",
    "Silence",
    "Speak",
    "Status",
    "Stop",
    "Thing",
    "Things",
    "Viewpoint",
    "Viseme",
    "Walk",
    "Waypoint",
]

Command: TypeAlias = React | Speak | Silence | Look | Stop | Walk | Drive | Halt | Input | Viewpoint | Quit
Event: TypeAlias = Completed | Log | Pause | Reached | Place | Floor | Things
