"""The operator's sound on its way to an engine: what an engine reads too slowly is lost, the oldest first."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Final

from openrois_streaming.source.source import RawAudio

from openrois_avatar.link.protocol import Audio

MAX_UNHEARD: Final = 25
"""Blocks of sound that wait for an engine which reads slowly."""


class Unheard:
    """The blocks that wait, in mono and numbered; `send` is called with each when its turn has come."""

    def __init__(self, send: Callable[[Audio], None]) -> None:
        self._send = send
        self._congested = False
        self._blocks: deque[Audio] = deque(maxlen=MAX_UNHEARD)
        self._number = 0

    def add(self, sound: RawAudio) -> None:
        """Take a block in."""
        mono = sound.samples.mean(axis=1).astype("<i2")
        self._blocks.append(Audio(self._number, round(max(0.0, sound.captured_at) * 1e9), 1, mono.tobytes()))
        self._number += 1
        self._flow()

    def pause(self) -> None:
        """There is no room for more."""
        self._congested = True

    def go_on(self) -> None:
        """There is room again."""
        self._congested = False
        self._flow()

    def _flow(self) -> None:
        while self._blocks and not self._congested:
            self._send(self._blocks.popleft())
