"""SoundLocalization: where a sound at the operator's microphones comes from (component 8)."""

import math
from collections import deque
from collections.abc import Callable
from datetime import UTC, datetime
from statistics import median
from typing import Annotated, Final

import numpy as np
from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.source.source import RawAudio
from pydantic import Field

from openrois.adapter import ErrorType, components, parameter
from openrois_avatar.components.sensing import Localizing
from openrois_avatar.hearing.bearing import WINDOW, BearingFinder, is_stereo
from openrois_avatar.hearing.ear import Ear
from openrois_avatar.hearing.presence import Presence
from openrois_avatar.sensing.changes import Place

__all__ = ["ASSUMED_DISTANCE", "SoundLocalization"]

ASSUMED_DISTANCE: Final = 1.0
"""Metres from the microphones to a source: two microphones tell its bearing only."""
_SMOOTHED: Final = 5
"""Bearings of which the middle one is told, so that a single echo is nobody's place."""
_AGREEING: Final = 3
"""Bearings that have to be there first."""
_MONO_AFTER: Final = 12
"""Windows with a sound and one channel, about a second, after which it is said that bearings need two."""
_MONO: Final = "the operator's microphone has one channel: where a sound comes from can be told with two"
_MILLIMETRE: Final = 0.001


class SoundLocalization(Localizing, components.SoundLocalization):
    """Tells the bearing of the loudest sound, as a place at an assumed distance of 1 m in front of the microphones.

    Needs a microphone with two channels; of one that has not it reports so, and tells no places.

    Args:
        engine_id: leads every ref.
        ear: what is heard.
        clock: the media clock.
    """

    microphone_distance: Annotated[int, Field(ge=10, le=2000)] = parameter(
        150, description="millimetres from the left to the right microphone"
    )

    def __init__(self, engine_id: str, ear: Ear, clock: MediaClock) -> None:
        super().__init__()
        self._engine_id = engine_id
        self._ear = ear
        self._clock = clock
        self._number = 0
        """Of the sound that is heard, or was last."""
        self._begin()
        self.activity.while_working(self._listen)

    def _listen(self) -> Callable[[], None]:
        self._begin()
        return self._ear.listen(self._hear)

    def _begin(self) -> None:
        self._presence = Presence()
        self._there = False
        self._waiting = np.zeros((0, 2), np.int16)
        self._bearings: deque[float] = deque(maxlen=_SMOOTHED)
        self._mono = 0
        self.forget_places()

    def _hear(self, sound: RawAudio) -> None:
        there, before = bool(self._presence.add(sound.samples)), self._there
        self._there = there
        if there and not before:
            self._number += 1
        if not there:
            self._waiting = self._waiting[:0]
            self._bearings.clear()
            self.tells({}, sound.captured_at)
            if self._ear.channels == 0:
                self._mono = 0
            return
        self._waiting = np.concatenate((self._waiting, sound.samples[:, [0, -1]]))
        while len(self._waiting) >= WINDOW:
            window, self._waiting = np.split(self._waiting, [WINDOW])
            self._look(window, sound.captured_at)

    def _look(self, window: np.ndarray[tuple[int, int], np.dtype[np.int16]], at: float) -> None:
        if not is_stereo(window):
            self._mono += 1
            if self._mono == _MONO_AFTER:
                self.report(ErrorType.USER_DEFINED_ERROR, _MONO)
            return
        bearing = BearingFinder(self.microphone_distance * _MILLIMETRE).find(window)
        if bearing is not None:
            self._bearings.append(bearing)
        if bearing is None or len(self._bearings) < _AGREEING:
            return
        place = _place(median(self._bearings))
        ref = f"urn:x-rois:def:sound:OpenRoIS::{self._engine_id}/microphone/{self._number}"
        if self.tells({ref: place}, at):
            moment = datetime.fromtimestamp(wall_at(self._clock, at), UTC)
            self.sound_localized((ref,), (place.text,), moment)


def _place(bearing: float) -> Place:
    """A source at the assumed distance, which faces the microphones."""
    x, y = ASSUMED_DISTANCE * math.sin(bearing), ASSUMED_DISTANCE * math.cos(bearing)
    return Place(x, y, math.atan2(-y, -x))
