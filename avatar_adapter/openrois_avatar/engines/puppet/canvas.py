"""The canvas of the figure: polygons, soft light and shade, and drawing within an outline."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache

import cv2
import numpy as np
import pygame

from openrois_avatar.engines.puppet.curves import Array
from openrois_avatar.engines.settings import Pixels

Colour = tuple[int, int, int]


def colour(code: str) -> Colour:
    """`#rrggbb` as red, green and blue."""
    red, green, blue = bytes.fromhex(code[1:])
    return red, green, blue


@lru_cache(maxsize=4096)
def mixed(one: str | Colour, other: str | Colour, share: float) -> Colour:
    """A colour with so much of another in it."""
    a, b = (colour(part) if isinstance(part, str) else part for part in (one, other))
    red, green, blue = (round(x + (y - x) * share) for x, y in zip(a, b, strict=True))
    return red, green, blue


class Canvas:
    """A drawing on a surface. Coordinates are pixels, (n, 2) arrays for outlines."""

    def __init__(self, surface: pygame.Surface) -> None:
        self._surface = surface
        self._scratch: tuple[pygame.Surface, pygame.Surface] | None = None

    def fill(self, outline: Array, paint: Colour) -> None:
        """Fill an outline."""
        pygame.draw.polygon(self._surface, paint, outline.tolist())

    def disc(self, centre: Sequence[float] | Array, radius: float, paint: Colour) -> None:
        """Fill a circle."""
        pygame.draw.circle(self._surface, paint, (centre[0], centre[1]), radius)

    def limb(self, start: Array, start_radius: float, end: Array, end_radius: float, paint: Colour) -> None:
        """Fill two circles and what is between them."""
        along = end - start
        length = max(float(np.hypot(*along)), 1e-6)
        across = np.asarray((-along[1], along[0])) / length
        sides = (
            start + across * start_radius,
            end + across * end_radius,
            end - across * end_radius,
            start - across * start_radius,
        )
        pygame.draw.polygon(self._surface, paint, [side.tolist() for side in sides])
        self.disc(start, start_radius, paint)
        self.disc(end, end_radius, paint)

    def shade(
        self, outline: Array, focus: Array, edge: Colour, middle: Colour, steps: int = 8, reach: float = 0.75
    ) -> None:
        """Fill an outline with one colour at its edge that softly turns into another towards a focus.

        `reach` says how far from the edge to the focus the change is complete.
        """
        for step in range(steps):
            share = step / (steps - 1)
            self.fill(focus + (outline - focus) * (1 - reach * share), mixed(edge, middle, share))

    def shadow(self, outline: Array, paint: Colour, strength: int) -> None:
        """Darken an outline; `strength` 0..255 is how much of the colour covers what is there."""
        left, top = np.floor(outline.min(axis=0)).astype(int).tolist()
        right, bottom = np.ceil(outline.max(axis=0)).astype(int).tolist()
        veil = pygame.Surface((right - left + 1, bottom - top + 1), pygame.SRCALPHA, 32)
        pygame.draw.polygon(veil, (*paint, strength), (outline - (left, top)).tolist())
        self._surface.blit(veil, (left, top))

    def stamp(self, sprite: pygame.Surface, centre: Sequence[float] | Array) -> None:
        """Put a soft spot somewhere."""
        width, height = sprite.get_size()
        self._surface.blit(sprite, (round(centre[0] - width / 2), round(centre[1] - height / 2)))

    @contextmanager
    def within(self, outline: Array) -> Iterator["Canvas"]:
        """A drawing that will be seen only inside an outline, at the same coordinates; it may not be nested."""
        if self._scratch is None:
            size = self._surface.get_size()
            self._scratch = pygame.Surface(size, pygame.SRCALPHA, 32), pygame.Surface(size, pygame.SRCALPHA, 32)
        drawing, mask = self._scratch
        left, top = np.floor(outline.min(axis=0)).astype(int).tolist()
        right, bottom = np.ceil(outline.max(axis=0)).astype(int).tolist()
        area = pygame.Rect(left, top, right - left + 1, bottom - top + 1).clip(self._surface.get_rect())
        for surface in (drawing, mask):
            surface.set_clip(area)
            surface.fill((0, 0, 0, 0))
        yield Canvas(drawing)
        pygame.draw.polygon(mask, (255, 255, 255, 255), outline.tolist())
        drawing.blit(mask, area, area, pygame.BLEND_RGBA_MULT)
        self._surface.blit(drawing, area, area)


def shared(pixels: Pixels) -> pygame.Surface:
    """A surface that draws into a BGRA array."""
    height, width, _ = pixels.shape
    return pygame.image.frombuffer(pixels.reshape(-1).data, (width, height), "BGRA")


def spot(radii: tuple[float, float], paint: Colour, strength: float) -> pygame.Surface:
    """A soft elliptic spot; `strength` 0..1 is how much it covers in its middle."""
    width, height = (2 * max(1, round(radius)) + 1 for radius in radii)
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    pixels = np.empty((height, width, 4), np.uint8)
    pixels[:, :, :3] = paint
    pixels[:, :, 3] = np.round(255 * strength * np.clip(1 - x**2 - y**2, 0, 1) ** 2)
    return pygame.image.frombytes(pixels.tobytes(), (width, height), "RGBA")


def hull(points: Array) -> Array:
    """The outline of what spans the points (n, 2)."""
    return np.asarray(cv2.convexHull(points.astype(np.float32))[:, 0], float)
