"""SoundLocalization by the microphones in the robot's head (component 8)."""

from collections.abc import Callable
from datetime import UTC, datetime

from openrois_body.components.sensing import Localizing
from openrois_body.components.sound_localization import place_at
from openrois_streaming.clock import MediaClock, wall_at

from openrois.adapter import ComponentStatus, components
from openrois_robots.reachy.directions import Directions
from openrois_robots.reachy.robot import Reachy

__all__ = ["SoundLocalization"]


class SoundLocalization(Localizing, components.SoundLocalization):
    """Announces where a voice comes from, as a place at an assumed distance of 1 m in the axes of the head.

    Args:
        engine_id: leads every ref.
        robot: the robot.
        directions: of voices at it.
        clock: the media clock.
    """

    def __init__(self, engine_id: str, robot: Reachy, directions: Directions, clock: MediaClock) -> None:
        super().__init__()
        self._engine_id = engine_id
        self._robot = robot
        self._directions = directions
        self._clock = clock
        self._number = 0
        """Number of the present or last voice."""
        self._is_heard = False
        self.activity.while_working(self._listen)

    def condition(self) -> ComponentStatus:
        """Return the status of the link; UNINITIALIZED while the robot tells no directions."""
        if not self._robot.link.is_up or self._directions.is_there:
            return self._robot.link.status
        return ComponentStatus.UNINITIALIZED

    def problem(self) -> str:
        """Return why no directions are told."""
        if self._robot.link.problem or self._directions.is_there:
            return self._robot.link.problem
        return "the robot's daemon tells no direction of sounds: it has no microphones, or runs without media"

    def _listen(self) -> Callable[[], None]:
        self.forget_places()
        self._is_heard = False
        ends = self._directions.told.add(self._on_told), self._directions.listen()

        def end() -> None:
            for each in ends:
                each()

        return end

    def _on_told(self, bearing: float | None, at: float) -> None:
        if bearing is not None and not self._is_heard:
            self._number += 1
        self._is_heard = bearing is not None
        if bearing is None:
            self.is_news({}, at)
            return
        place = place_at(bearing)
        ref = f"urn:x-rois:def:sound:OpenRoIS::{self._engine_id}/microphones/{self._number}"
        if self.is_news({ref: place}, at):
            self.sound_localized((ref,), (place.text,), datetime.fromtimestamp(wall_at(self._clock, at), UTC))
