"""The animator: commands go in with their time, poses and finished reactions come out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrois_avatar.engines.animation import idle
from openrois_avatar.engines.animation.curves import settling, settling_speed, smooth
from openrois_avatar.engines.animation.gaze import Gaze
from openrois_avatar.engines.animation.pose import Pose, channels, from_channels
from openrois_avatar.engines.animation.reactions import REACTIONS, Reaction
from openrois_avatar.engines.animation.visemes import Track, blended, mixed
from openrois_avatar.engines.animation.voice_mouth import VoiceMouth

MAX_TRACKS: Final = 64
"""Most speech tracks that wait or play at once; of more, the earliest is dropped."""
_REST: Final = channels(Pose())
_SETTLE: Final = 9.0
"""Stiffness (1/s) of the spring that takes an interrupted reaction back to rest: about 0.5 s."""
_INSTANT: Final = 1e-4
_LIMITS: Final = {
    "lid_left": (-0.2, 1.0),
    "lid_right": (-0.2, 1.0),
    "squint": (0.0, 1.0),
    "mouth.jaw": (0.0, 1.1),
    "breath": (0.0, 1.0),
}


@dataclass(frozen=True, slots=True)
class Outcome:
    """A reaction is over: played to its end (OK), stopped or replaced (ABORT), or unknown (ERROR)."""

    id: str
    status: Literal["OK", "ABORT", "ERROR"]


@dataclass(frozen=True, slots=True)
class _Playing:
    id: str
    reaction: Reaction
    start: float


@dataclass(frozen=True, slots=True)
class _Residue:
    """Offset and speed of each channel after an interrupted reaction, coming to rest."""

    time: float
    moving: dict[str, tuple[float, float]]

    def at(self, time: float) -> dict[str, float]:
        elapsed = time - self.time
        return {name: settling(offset, speed, _SETTLE, elapsed) for name, (offset, speed) in self.moving.items()}

    def speeds(self, time: float) -> dict[str, float]:
        elapsed = time - self.time
        return {name: settling_speed(offset, speed, _SETTLE, elapsed) for name, (offset, speed) in self.moving.items()}


class Animator:
    """One avatar's body. Times are seconds on any one clock and never go back from call to call."""

    def __init__(self, seed: int = 1) -> None:
        self._seed = seed
        self._gaze = Gaze()
        self._tracks: list[Track] = []
        self._heard = VoiceMouth()
        self._playing: _Playing | None = None
        self._residue = _Residue(0.0, {})
        self._outcomes: list[Outcome] = []

    def turn_eyes(self, time: float, x: float, y: float) -> None:
        """Turn the eyes to x (-1: the picture's left .. 1) and y (-1: down .. 1)."""
        self._gaze.turn_to(time, x, y)

    def speak(self, time: float, track: Track) -> None:
        """Move the mouth along a track from its own start on."""
        self._tracks = [*(known for known in self._tracks if not known.over(time)), track][-MAX_TRACKS:]

    def follow_voice(self, time: float, blocks: Sequence[NDArray[np.int16]]) -> None:
        """Follow the operator's voice, as it arrives, with the mouth where the avatar does not speak itself."""
        self._heard.hear(time, blocks)

    def silence(self, time: float) -> None:
        """Close the mouth now; tracks that have not begun are dropped."""
        self._tracks = [track for track in self._tracks if track.start <= time]
        for track in self._tracks:
            track.cut(time)

    def react(self, time: float, id: str, name: str) -> None:
        """Play a reaction in place of the one that plays."""
        reaction = REACTIONS.get(name)
        if reaction is None:
            self._outcomes.append(Outcome(id, "ERROR"))
            return
        self._interrupt(time)
        self._playing = _Playing(id, reaction, time)

    def stop(self, time: float, id: str | None = None) -> None:
        """Stop the reaction with this id, or any if it is None."""
        if self._playing is not None and id in (None, self._playing.id):
            self._interrupt(time)

    def outcomes(self, time: float) -> list[Outcome]:
        """Return the reactions that have ended since the last call."""
        if self._playing is not None and time >= self._playing.start + self._playing.reaction.duration:
            self._outcomes.append(Outcome(self._playing.id, "OK"))
            self._playing = None
        done, self._outcomes = self._outcomes, []
        return done

    def is_expressive(self, time: float) -> bool:
        """Return whether the figure speaks or plays a reaction, so that its face or hands matter."""
        return self._playing is not None or any(track.is_spoken(time) for track in self._tracks)

    def pose(self, time: float, walking: Mapping[str, float] = MappingProxyType({})) -> Pose:
        """Return the pose at a time; `walking` has the offsets of its steps by channel."""
        values = dict(_REST)
        reacting, residue = self._reacting(time), self._residue.at(time)
        for layer in (
            self._resting(time),
            self._looking(time),
            self._speaking(time),
            _with_busy_arms(walking, reacting, residue),
            reacting,
            residue,
        ):
            for name, value in layer.items():
                values[name] += value
        for name, (low, high) in _LIMITS.items():
            values[name] = min(max(values[name], low), high)
        return from_channels(values)

    def _resting(self, time: float) -> dict[str, float]:
        drift, lid = idle.drift(time, self._seed), idle.blink(time, self._seed)
        eye_yaw, eye_pitch = idle.glance(time, self._seed)
        return {
            "head_yaw": drift.yaw,
            "head_pitch": drift.pitch,
            "head_roll": drift.roll,
            "side": drift.side,
            # The eyes hold their aim while the head sways.
            "gaze_yaw": eye_yaw - drift.yaw,
            "gaze_pitch": eye_pitch - drift.pitch,
            "lid_left": lid,
            "lid_right": lid,
            "breath": idle.breath(time),
            "mouth.smile": 0.30,
        }

    def _looking(self, time: float) -> dict[str, float]:
        looking = self._gaze.at(time)
        return {
            "head_yaw": looking.head_yaw,
            "head_pitch": looking.head_pitch,
            "head_roll": looking.head_yaw * 0.10,
            "twist": looking.head_yaw * 0.12,
            "gaze_yaw": looking.eye_yaw,
            "gaze_pitch": looking.eye_pitch,
            "lid_left": looking.lid,
            "lid_right": looking.lid,
        }

    def _speaking(self, time: float) -> dict[str, float]:
        playing = [track for track in self._tracks if not track.over(time)]
        shares = [track.share(time) for track in playing]
        free = max(0.0, 1 - sum(share.presence for share in shares))
        mouth = mixed(blended(shares), self._heard.shape(time), free)
        accent = max((track.accent(time) for track in playing), default=0.0)
        return {
            "mouth.jaw": mouth.jaw,
            "mouth.wide": mouth.wide,
            "mouth.round": mouth.round,
            "mouth.upper": mouth.upper,
            "mouth.lower": mouth.lower,
            "mouth.press": mouth.press,
            "mouth.bite": mouth.bite,
            "mouth.tongue": mouth.tongue,
            # A rounded or closed mouth cannot smile as much.
            "mouth.smile": -0.20 * max(mouth.round, mouth.press, mouth.bite),
            "head_pitch": -0.055 * accent,
            "head_yaw": 0.02 * accent,
            "brow_left": 0.30 * accent,
            "brow_right": 0.30 * accent,
        }

    def _reacting(self, time: float) -> dict[str, float]:
        return {} if self._playing is None else self._playing.reaction.at(time - self._playing.start)

    def _interrupt(self, time: float) -> None:
        """End the reaction, and let its offsets and speeds come to rest, so that nothing jumps."""
        if self._playing is None:
            return
        now, next_ = self._reacting(time), self._reacting(time + _INSTANT)
        offsets, speeds = self._residue.at(time), self._residue.speeds(time)
        for name, value in now.items():
            offsets[name] = offsets.get(name, 0.0) + value
            speeds[name] = speeds.get(name, 0.0) + (next_[name] - value) / _INSTANT
        self._residue = _Residue(time, {name: (offset, speeds[name]) for name, offset in offsets.items()})
        self._outcomes.append(Outcome(self._playing.id, "ABORT"))
        self._playing = None


def _with_busy_arms(walking: Mapping[str, float], *gestures: Mapping[str, float]) -> dict[str, float]:
    """Return the offsets of steps without the swing of an arm that a gesture uses; empty while it stands."""
    if not walking:
        return {}
    free = {}
    for side in ("left.", "right."):
        busy = sum(abs(gesture.get(f"{side}{axis}", 0.0)) for gesture in gestures for axis in ("out", "y", "z"))
        free[side] = 1 - smooth(busy)
    return {name: value * free.get(f"{name.partition('.')[0]}.", 1.0) for name, value in walking.items()}
