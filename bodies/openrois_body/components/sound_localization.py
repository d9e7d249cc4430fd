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
from openrois_body.components.sensing import Localizing
from openrois_body.hearing.bearing import WINDOW, BearingFinder, is_stereo
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.noise_floor import Presence
from openrois_body.sensing.changes import Place

__all__ = ["ASSUMED_DISTANCE", "SoundLocalization", "place_at"]

ASSUMED_DISTANCE: Final = 1.0
"""Metres from the microphones to a source: two microphones tell its bearing only."""
_SMOOTHED: Final = 5
"""Bearings of which the median is announced, so that a single echo is no place."""
_AGREEING: Final = 3
"""Bearings that are needed first."""
_MONO_AFTER: Final = 12
"""Windows with a sound and one channel, about a second, after which an error says that bearings need two."""
_MONO: Final = "the operator's microphone has one channel; locating a sound needs a microphone with two"
_MILLIMETRE: Final = 0.001


class SoundLocalization(Localizing, components.SoundLocalization):
    """Announces the bearing of the loudest sound, as a place at an assumed distance of 1 m before the microphones.

    Needs a microphone with two channels; otherwise it reports an error and announces no places.

    Args:
        engine_id: leads every ref.
        ear: the microphone's sound.
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
        """Number of the present or last sound."""
        self._begin()
        self.activity.while_working(self._listen)
        ear.forgotten.add(self._begin)

    def _listen(self) -> Callable[[], None]:
        self._begin()
        return self._ear.listen(self._on_sound)

    def _begin(self) -> None:
        self._presence = Presence()
        self._there = False
        self._waiting = np.zeros((0, 2), np.int16)
        self._bearings: deque[float] = deque(maxlen=_SMOOTHED)
        self._mono = 0
        self.forget_places()

    def _on_sound(self, sound: RawAudio) -> None:
        there, before = bool(self._presence.add(sound.samples)), self._there
        self._there = there
        if there and not before:
            self._number += 1
        if not there:
            self._waiting = self._waiting[:0]
            self._bearings.clear()
            self.is_news({}, sound.captured_at)
            if self._ear.channels == 0:
                self._mono = 0
            return
        self._waiting = np.concatenate((self._waiting, sound.samples[:, [0, -1]]))
        while len(self._waiting) >= WINDOW:
            window, self._waiting = np.split(self._waiting, [WINDOW])
            self._analyse_window(window, sound.captured_at)

    def _analyse_window(self, window: np.ndarray[tuple[int, int], np.dtype[np.int16]], at: float) -> None:
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
        place = place_at(median(self._bearings))
        ref = f"urn:x-rois:def:sound:OpenRoIS::{self._engine_id}/microphone/{self._number}"
        if self.is_news({ref: place}, at):
            moment = datetime.fromtimestamp(wall_at(self._clock, at), UTC)
            self.visitor_ref = self._ear.sender
            self.sound_localized((ref,), (place.text,), moment)


def place_at(bearing: float) -> Place:
    """Return the place of a source at the assumed distance that faces the microphones.

    Args:
        bearing: radians from straight ahead, to the right.
    """
    x, y = ASSUMED_DISTANCE * math.sin(bearing), ASSUMED_DISTANCE * math.cos(bearing)
    return Place(x, y, math.atan2(-y, -x))
