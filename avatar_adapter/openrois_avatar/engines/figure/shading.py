"""Light on a surface, per vertex: key, fill, sky and two rim lights, with finishes for skin, hair, cloth and eyes.

The renderer draws plain vertex colours, so everything that makes the picture soft happens here: light that wraps
around (redder on skin, as light does that has been under it), openness baked into the clay, a glow at the silhouette.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from openrois_avatar.engines.figure.mesh import Array

Floats = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]


def _unit(direction: Sequence[float] | Floats) -> Floats:
    vector = np.asarray(direction, np.float32)
    return np.asarray(vector / np.linalg.norm(vector))


_VIEWER = _unit((0.0, -1.0, 0.0))
_TO_KEY = _unit((-0.52, -0.72, 0.60))
HALFWAY = _unit(_TO_KEY + _VIEWER)
"""Between the key light and the viewer: surfaces that face this way shine."""
# Columns: key, fill, zenith, viewer, rim from the right, rim from the left, halfway.
_DIRECTIONS = np.stack(
    [
        _TO_KEY,
        _unit((0.85, -0.55, 0.05)),
        _unit((0, 0, 1)),
        _VIEWER,
        _unit((0.75, 0.55, 0.45)),
        _unit((-0.85, 0.5, 0.3)),
        HALFWAY,
    ],
    axis=1,
)
_KEY = np.asarray((0.90, 0.845, 0.785), np.float32)
_FILL = np.asarray((0.19, 0.22, 0.27), np.float32)
_GROUND = np.asarray((0.25, 0.20, 0.19), np.float32)
_SKY_OVER_GROUND = np.asarray((0.37, 0.395, 0.44), np.float32) - _GROUND
_RIM = np.asarray((0.80, 0.88, 1.00), np.float32)
_RIM_LEFT = np.asarray((0.45, 0.39, 0.33), np.float32)


# The software renderer overshoots a little between vertices and wraps at 255: dots of the opposite colour.
_BRIGHTEST = np.float32(249)


@dataclass(frozen=True)
class Finish:
    """Reflection of light by a surface: wrap and fold colour per channel, highlight sharpness, rim strength."""

    wrap: tuple[float, float, float] = (0.35, 0.35, 0.35)
    fold: tuple[float, float, float] = (1.0, 1.0, 1.0)
    sharpness: float = 16.0
    rim: float = 0.22


SKIN = Finish(wrap=(0.55, 0.34, 0.28), fold=(0.80, 1.0, 1.06), sharpness=20.0, rim=0.30)
CLOTH = Finish()
HAIR = Finish(wrap=(0.30, 0.28, 0.26), sharpness=12.0, rim=0.32)
PLAIN = Finish(wrap=(0.5, 0.5, 0.5), rim=0.0)
FINISHES: Final = {"skin": SKIN, "cloth": CLOTH, "hair": HAIR, "plain": PLAIN}
"""By the names that baked figures have for them."""


@dataclass(frozen=True)
class Surface:
    """A mesh's colour before light, all linear: albedo (n, 3), openness (n,) 0..1 or one for all, gloss likewise."""

    albedo: Array
    openness: npt.ArrayLike = 1.0
    finish: Finish = Finish()
    gloss: npt.ArrayLike = 0.0

    def spread(self, value: npt.ArrayLike) -> Floats:
        """A value per vertex, or one for all, as a column (n, 1)."""
        return np.broadcast_to(np.asarray(value, np.float32), self.albedo.shape[:1])[:, None]


class Lighting:
    """The light on several surfaces at once, one after the other in the same arrays."""

    def __init__(self, surfaces: Sequence[Surface]) -> None:
        self._albedo = np.concatenate([surface.albedo for surface in surfaces]).astype(np.float32)
        self._wrap = _rows(surfaces, lambda surface: surface.finish.wrap)
        self._narrow = 1 / (1 + self._wrap)
        self._fold = _rows(surfaces, lambda surface: surface.finish.fold)
        self._rim = _rows(surfaces, lambda surface: (surface.finish.rim,))
        self._sharpness = _rows(surfaces, lambda surface: (surface.finish.sharpness,))
        self._gloss = np.concatenate([surface.spread(surface.gloss) for surface in surfaces])
        self._free, self._edge = np.empty_like(self._gloss), np.empty_like(self._gloss)
        self._keyed, self._filled, self._ground, self._sky = (np.empty_like(self._albedo) for _ in range(4))
        self.set_openness(slice(None), np.concatenate([surface.spread(surface.openness) for surface in surfaces])[:, 0])

    def set_openness(self, part: slice, openness: npt.ArrayLike) -> None:
        """Say how open a part of the surfaces is, (n,) 0..1; folds take the finish's fold colour."""
        free = np.asarray(openness, np.float32)[:, None]
        veil = free ** self._fold[part]
        albedo = self._albedo[part]
        self._free[part] = free
        self._edge[part] = free * self._rim[part]
        self._keyed[part] = albedo * (_KEY * (0.35 + 0.65 * veil))
        self._filled[part] = albedo * (_FILL * veil)
        self._ground[part] = albedo * (_GROUND * veil)
        self._sky[part] = albedo * (_SKY_OVER_GROUND * veil)

    def colours(self, part: slice, normals: Floats, rotation: Floats) -> Bytes:
        """RGB bytes (n, 3) of a part for its unit normals (n, 3); `rotation` (3, 3) takes them to the world."""
        facing: Floats = normals @ (rotation.T @ _DIRECTIONS)
        turned = (facing[:, 0:1] + self._wrap[part]) * self._narrow[part]
        light: Floats = self._keyed[part] * _held(turned)
        light += self._filled[part] * _held(facing[:, 1:2] * 0.6 + 0.4)
        light += self._ground[part]
        light += self._sky[part] * (facing[:, 2:3] * 0.5 + 0.5)
        away = 1 - _held(facing[:, 3:4])
        edge = away * away * away * self._edge[part]
        light += (edge * _held(facing[:, 4:5] + 0.25)) * _RIM
        light += (edge * _held(facing[:, 5:6] + 0.15)) * _RIM_LEFT
        light += _held(facing[:, 6:7]) ** self._sharpness[part] * (self._gloss[part] * self._free[part])
        np.sqrt(np.minimum(light, 1, out=light), out=light)
        light *= _BRIGHTEST
        return light.astype(np.uint8)


def _rows(surfaces: Sequence[Surface], value: Callable[[Surface], tuple[float, ...]]) -> Floats:
    return np.concatenate(
        [np.tile(np.asarray(value(surface), np.float32), (len(surface.albedo), 1)) for surface in surfaces]
    )


def _held(value: npt.NDArray[np.floating]) -> Floats:
    """The value within 0..1, in place."""
    return np.asarray(np.minimum(np.maximum(value, 0, out=value), 1, out=value), np.float32)


def linear(colour: str) -> Array:
    """A `#rrggbb` colour as the linear albedo that `colours` turns back into it under full light."""
    parts = [int(colour[start : start + 2], 16) / 255 for start in (1, 3, 5)]
    return np.asarray(parts) ** 2
