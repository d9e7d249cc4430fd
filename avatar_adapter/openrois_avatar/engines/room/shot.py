"""The camera: close to the figure's face while it stands and talks, farther away while it walks."""

from dataclasses import dataclass
from math import cos, exp, hypot, pi, sin
from typing import Final

from openrois_avatar.engines.room.plan import HOME
from openrois_avatar.engines.room.walking import Pace, turned
from openrois_avatar.link.messages import Place

METRE: Final = 7.5
"""Decimetres of the sculpted figure to a metre of the room: it stands for a taller person."""
GROUND: Final = -11.0
"""Height of the floor, in dm from the middle of the figure's head."""
EYE_LEVEL: Final = -0.66
"""The camera's height in the close view, in dm over the middle of the head."""
DISTANCE: Final = 15.0
SPAN: Final = 4.7
"""From the camera to the head in the close view, and the height of the picture there, in dm. The lens never changes."""
_FAR: Final = 64.0
"""From the camera to a figure that walks, in dm."""
_MIDDLE: Final = -4.6
_TILT: Final = 0.17
"""Target of the far view, in dm over the middle of the head, and its tilt down, in radians."""
_TALKING, _AWAY = 0.62, 0.62
"""Shares of the way to the far view for a figure that walks and talks, and for one that turns away."""
_ROOM_SHARE: Final = 0.75
"""Share of the figure's way from the middle of the room that the far view follows."""
_LINGER: Final = 1.2
"""Seconds that the figure stands before the camera comes close."""
_BACKING, _NEARING, _PANNING = 3.0, 2.2, 3.6
"""Stiffness of the camera's moves, in 1/s."""
_CLOSEST: Final = 4.0
"""A figure nearer to the camera than that, in dm, is not in the picture."""
_BROAD: Final = 2.5
"""Half the width of a figure with swinging arms, in dm."""
_WHOLE: Final = 1.1
"""Share of the way to the far view, and beyond, for a picture of the whole room."""
_OWN_EYES: Final = (1.3, 0.25, 0.06)
"""Place of the figure's own eyes: before and over the middle of its head, in dm; and their tilt down in radians."""
VIEWPOINTS: Final = ("automatic", "face", "room", "follow", "eyes")
"""The viewpoints: automatic, close to the face, the whole room, beside the figure, and through its eyes."""
_SETTLED: Final = 5e-4
_LONGEST: Final = 1.0
_GOING: Final = 0.05


@dataclass(frozen=True, slots=True)
class Shot:
    """The place of the camera, in dm from the middle of the head of a figure at `HOME`.

    It looks `tilt` radians down and `heading` radians to the left of straight into the room.
    """

    x: float
    y: float
    z: float
    tilt: float
    heading: float = 0.0
    own: bool = False
    """Whether it looks through the figure's own eyes."""

    @property
    def is_close(self) -> bool:
        """Whether no more than head and shoulders of the figure are seen."""
        return self.tilt == 0.0 and not self.own

    def sees(self, place: Place, aspect: float) -> bool:
        """Return whether a figure at a place may be in a picture of this aspect ratio."""
        if self.own:
            return True
        across, away = place.x * METRE - self.x, place.y * METRE - self.y
        return away > _CLOSEST and abs(across) < away * SPAN / 2 / DISTANCE * aspect + _BROAD


@dataclass(slots=True)
class _Spring:
    """A number on its way to another, critically damped."""

    value: float
    speed: float = 0.0

    def move(self, goal: float, stiffness: float, seconds: float) -> None:
        offset = self.value - goal
        drive = self.speed + stiffness * offset
        decay = exp(-stiffness * seconds)
        self.value = goal + (offset + drive * seconds) * decay
        self.speed = (self.speed - stiffness * drive * seconds) * decay
        if abs(self.value - goal) < _SETTLED and abs(self.speed) < _SETTLED:
            self.value, self.speed = goal, 0.0


def shot(x: float, y: float, share: float) -> Shot:
    """Return the shot of a place in metres: `share` 0 is the close view, 1 the far one."""
    eased = share * share * (3 - 2 * share)
    distance = DISTANCE * (_FAR / DISTANCE) ** share
    tilt = _TILT * eased
    height = EYE_LEVEL + (_MIDDLE - EYE_LEVEL) * eased
    return Shot(x * METRE, y * METRE - distance * cos(tilt), height + distance * sin(tilt), tilt)


def own_shot(place: Place) -> Shot:
    """Return the shot through the eyes of a figure at a place."""
    before, over, tilt = _OWN_EYES
    x, y = place.x * METRE + before * cos(place.th), place.y * METRE + before * sin(place.th)
    return Shot(x, y, over, tilt, turned(place.th - pi / 2), own=True)


HOME_SHOT: Final = shot(HOME.x, HOME.y, 0.0)


class Camerawork:
    """Follows one figure. Times never go back from call to call."""

    def __init__(self, time: float) -> None:
        self._time = time
        self._x, self._y, self._share = _Spring(HOME.x), _Spring(HOME.y), _Spring(0.0)
        self._stood = time - _LINGER
        """The time since which the figure stands."""
        self._wanted = 0.0
        """The share that the camera moves to."""
        self.viewpoint = VIEWPOINTS[0]

    def follow(self, time: float, place: Place, pace: Pace, expressive: bool) -> Shot:
        """Return the shot of a figure at a place with a pace; `expressive` while it speaks or reacts."""
        seconds = min(time - self._time, _LONGEST)
        self._time = time
        if hypot(pace.ahead, pace.left) > _GOING:
            self._stood = time
        self._choose(time, place, expressive)
        share, along = self._framing()
        self._share.move(share, _BACKING if share > self._share.value else _NEARING, seconds)
        self._x.move(place.x * along, _PANNING, seconds)
        self._y.move(place.y * along, _PANNING, seconds)
        if self.viewpoint == "eyes":
            return own_shot(place)
        return shot(self._x.value, self._y.value, max(0.0, self._share.value))

    def _framing(self) -> tuple[float, float]:
        """Return the share of the way to the far view, and the share of the figure's way to follow."""
        match self.viewpoint:
            case "face":
                return 0.0, 1.0
            case "room":
                return _WHOLE, 0.0
            case "follow":
                return 1.0, 1.0
            case _:
                return self._wanted, 1 - (1 - _ROOM_SHARE) * self._wanted

    def _choose(self, time: float, place: Place, expressive: bool) -> None:
        """Choose the share of the way to the far view; after a stop it stays for a while."""
        if self._stood == time:
            self._wanted = _TALKING if expressive else 1.0
        elif time - self._stood >= _LINGER:
            self._wanted = 0.0 if cos(turned(place.th + pi / 2)) > 0.3 else _AWAY
