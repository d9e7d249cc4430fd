"""The scene at a moment, beside the figure's own pose: its place, the visitor, and the shot."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from openrois_avatar.engines.room.plan import HOME
from openrois_avatar.engines.room.shot import HOME_SHOT, Shot
from openrois_avatar.link.messages import Place


@dataclass(frozen=True, slots=True)
class OtherFigure:
    """Another figure: its place, and the offsets of its steps, by channel of a pose."""

    place: Place
    steps: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Scene:
    """The figure's place, the visitor if there is one, and the shot."""

    place: Place = HOME
    visitor: OtherFigure | None = None
    shot: Shot = HOME_SHOT


AT_HOME: Final = Scene()
"""The figure where it begins, alone, in the close view."""
