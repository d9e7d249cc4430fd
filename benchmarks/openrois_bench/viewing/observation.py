"""Observation of the pictures by one viewer. Pure."""

import itertools
from collections.abc import Sequence
from typing import Self

from openrois_streaming.source.stamp import NUMBER_MODULUS
from pydantic import BaseModel, ConfigDict

from openrois_bench.measuring.figures import Percentiles

__all__ = ["MEASURES", "Observation", "Order", "Sightings", "missed"]

MEASURES = {
    "received": "capture -> last packet",
    "decoded": "capture -> decoded",
    "presented": "capture -> presented",
    "connect": "connect_stream -> first picture",
    "resume": "resume_stream -> first new picture",
    "apart": "pictures behind the sound, as the browser says",
}
"""What can be measured, in the order in which it is shown. A viewer measures what it can."""


class Order(BaseModel):
    """Order to a viewer.

    It plays the stream of a component behind the gateway at `url` (`ws://host:port/`): `runs` times only until the
    first picture is there; then for `settling` seconds that do not count, and for `seconds`; then it suspends and
    resumes it `resumes` times. `fps` is what the source gives. A browser plays the sound of `sound_ref` beside it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    url: str
    component_ref: str
    codec: str
    seconds: float
    runs: int
    resumes: int
    fps: float = 30.0
    settling: float = 0.5
    sound_ref: str | None = None


class Sightings(BaseModel):
    """Sightings of a viewer: the size of the pictures, their numbers in order, and its times in milliseconds."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    width: int
    height: int
    numbers: tuple[int, ...]
    unreadable: int
    """Pictures without a stamp that could be read."""
    milliseconds: dict[str, tuple[float, ...]]
    """By the names of `MEASURES`."""
    visible: tuple[float, ...] = ()
    """When each picture of `numbers` was there, in ms since the first."""
    widths: tuple[int, ...] = ()
    """Of each picture of `numbers`, in pixels."""
    counters: dict[str, float] = {}
    """What a browser counted meanwhile (W3C webrtc-stats, `RTCInboundRtpStreamStats`)."""


class Observation(BaseModel):
    """Summary of the sightings of one viewer."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    viewer: str
    codec: str
    width: int
    height: int
    pictures: int
    missed: int
    """How many numbers were missing among theirs: a viewer that is late skips pictures."""
    unreadable: int
    milliseconds: dict[str, Percentiles]

    @classmethod
    def of(cls, viewer: str, codec: str, sightings: Sightings) -> Self:
        """Sum up what `viewer` saw of a stream in `codec`.

        Raises:
            ValueError: something was never seen.
        """
        told = sightings.milliseconds
        return cls(
            viewer=viewer,
            codec=codec,
            width=sightings.width,
            height=sightings.height,
            pictures=len(sightings.numbers),
            missed=missed(sightings.numbers),
            unreadable=sightings.unreadable,
            milliseconds={name: Percentiles.of(told[name]) for name in MEASURES if name in told},
        )


def missed(numbers: Sequence[int]) -> int:
    """Count the numbers that are missing between first and last of `numbers`, which grow modulo the stamp's modulus."""
    steps = ((after - before) % NUMBER_MODULUS for before, after in itertools.pairwise(numbers))
    return sum(step - 1 for step in steps)
