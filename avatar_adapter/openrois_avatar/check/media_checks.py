"""Checks of an engine's pictures and sound: shape, rate, order and timestamps."""

import math
import statistics
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from openrois_avatar.check.finding import Finding, failed, judged, not_tried, passed
from openrois_avatar.check.record import Block, Picture
from openrois_avatar.link.messages import Hello

__all__ = ["check_pictures", "check_ring", "check_sound"]

FRAMES: Final = "Frames"
TIMES: Final = "Timestamps: sound and pictures together"
RING: Final = "The ring"

_TOO_FEW: Final = 0.5
_TOO_MANY: Final = 1.5
"""Limits of the rate, as shares of the announced one: a busy machine draws fewer, and no clock runs so fast."""
_BEFORE: Final = 2
"""Pictures that may have been drawn before the connection was noticed."""
_OLD: Final = 1.0
"""Seconds; an older timestamp is not believed."""
_AHEAD: Final = 0.5
"""Seconds by which the timestamp of sound may be ahead."""
_LATE: Final = 0.25
"""Seconds by which sound may be late."""
_JUMP: Final = 0.03
"""Seconds by which a block may be off the end of the one before."""
_MOST: Final = 0.1
"""Share that may be wrong: a machine that is busy for a moment is no fault."""


def check_pictures(hello: Hello, seen: Sequence[Picture], paused: bool, opened: float) -> list[Finding]:
    """Check rate, sequence numbers, size and timestamps of pictures.

    `opened` is when the connection was opened, in seconds of CLOCK_MONOTONIC.
    """
    if not seen:
        if paused:
            return [not_tried("pictures", "the engine says that it pauses them", FRAMES)]
        return [failed("pictures", "none has come", FRAMES)]
    return [_rate(hello, seen, paused), _count(hello, seen, opened), _shape(hello, seen), _moments(seen)]


def _rate(hello: Hello, seen: Sequence[Picture], paused: bool) -> Finding:
    announced = hello.video.fps
    span = seen[-1].at - seen[0].at
    if paused or len(seen) < 2 or span <= 0:
        return passed("pictures", f"{len(seen)} came", FRAMES)
    rate = (len(seen) - 1) / span
    most = _TOO_MANY * announced
    if rate > most:
        # A check that is late, on a busy machine, finds pictures at once that were drawn over time.
        drawn = _drawn(seen)
        rate = drawn if drawn <= most else rate
    told = f"{rate:.1f} a second, {announced:g} announced"
    return judged("pictures", [] if _TOO_FEW * announced <= rate <= most else [told], told, FRAMES)


def _drawn(seen: Sequence[Picture]) -> float:
    """Return the rate of drawing, from the first to the last picture with a believed timestamp."""
    believed = [number for number, picture in enumerate(seen) if _is_believed(picture)]
    if len(believed) < 2:
        return math.inf
    first, last = seen[believed[0]], seen[believed[-1]]
    span = max(last.at - first.at, last.claimed - first.claimed)
    return (believed[-1] - believed[0]) / span if span > 0 else math.inf


def _count(hello: Hello, seen: Sequence[Picture], opened: float) -> Finding:
    numbers, passed_by = [picture.sequence for picture in seen], seen[0].at - opened
    faults = []
    # An engine that sends the newest picture only may have left out the first ones, but none that it has not drawn.
    if numbers[0] > _BEFORE + _TOO_MANY * hello.video.fps * passed_by:
        told = f"the first is number {numbers[0]}, {passed_by:.2f} s after the connection"
        faults.append(f"{told}: every connection counts from 0")
    back = next(((one, other) for one, other in pairwise(numbers) if other <= one), None)
    if back:
        faults.append(f"number {back[1]} follows {back[0]}: they must grow")
    gaps = numbers[-1] + 1 - len(numbers)
    return judged("sequence", faults, f"{len(numbers)} in order, {gaps} left out", FRAMES)


def _shape(hello: Hello, seen: Sequence[Picture]) -> Finding:
    shape = hello.video
    announced = f"{shape.width}x{shape.height} {shape.format}"
    found = dict.fromkeys(f"{width}x{height} {p.format}" for p in seen for width, height in (p.size,))
    others = [each for each in found if each != announced]
    return judged(
        "size", [f"HELLO announced {announced}, and {', '.join(others)} came"] if others else [], announced, FRAMES
    )


def _moments(seen: Sequence[Picture]) -> Finding:
    behind = statistics.median(picture.at - picture.claimed for picture in seen)
    wrong = [picture for picture in seen if not _is_believed(picture)]
    stuck = sum(other.claimed <= one.claimed for one, other in pairwise(seen))
    faults = []
    if len(wrong) > _MOST * len(seen):
        faults.append(_disbelief(wrong[0]))
    if stuck > _MOST * len(seen):
        faults.append(f"{stuck} of {len(seen)} do not show a later moment than the one before")
    return judged("moments", faults, f"they arrive {1000 * behind:.0f} ms after the moment that they show", TIMES)


def _is_believed(picture: Picture) -> bool:
    return 0 <= picture.at - picture.claimed <= _OLD


def _disbelief(picture: Picture) -> str:
    if picture.claimed == 0:
        return "the timestamp is 0: it is the moment that the picture shows"
    off = picture.claimed - picture.at
    if abs(off) > 3600:
        return f"the timestamp is {abs(off):.0f} s off: it is CLOCK_MONOTONIC in nanoseconds, no other clock"
    return f"the timestamp is {abs(off):.3f} s {'later than now' if off > 0 else 'ago'}, which is not believed"


def check_sound(hello: Hello, seen: Sequence[Block]) -> list[Finding]:
    """Check that sound is as announced, continuous, and in time."""
    if hello.audio_channels is None:
        if seen:
            return [failed("sound", "HELLO has no `audio`, and sound came", "JSON messages")]
        return [not_tried("sound", "the engine has none", FRAMES)]
    if not seen:
        return [not_tried("sound", "none came: let the engine make some to have it checked", FRAMES)]
    faults = []
    channels = sorted({block.channels for block in seen} - {hello.audio_channels})
    if channels:
        faults.append(f"{hello.audio_channels} channels were announced, and blocks have {channels[0]}")
    numbers = [block.sequence for block in seen]
    if numbers[0] or any(other <= one for one, other in pairwise(numbers)):
        faults.append("the blocks are not counted from 0 on, each higher than the one before")
    seconds = sum(block.seconds for block in seen)
    return [judged("sound", faults, f"{len(seen)} blocks, {seconds:.1f} s", FRAMES), _sound_moments(seen)]


def _sound_moments(seen: Sequence[Block]) -> Finding:
    wrong = [block for block in seen if not block.at - _OLD <= block.claimed <= block.at + _AHEAD]
    jumps = sum(abs(other.claimed - one.claimed - one.seconds) > _JUMP for one, other in pairwise(seen))
    ahead = statistics.median(block.claimed - block.at for block in seen)
    faults = []
    if len(wrong) > _MOST * len(seen):
        off = wrong[0].claimed - wrong[0].at
        faults.append(f"a block claims to be heard {off:+.3f} s from its arrival: from -1 to 0.5 s is believed")
    elif ahead < -_LATE:
        faults.append(f"it comes {-ahead:.3f} s too late: the adapter waits for 0.25 s at most")
    if jumps > _MOST * len(seen):
        faults.append(
            f"{jumps} of {len(seen)} blocks do not begin within 30 ms of where the one before ended: count by samples"
        )
    told = f"{1000 * abs(ahead):.0f} ms {'ahead of' if ahead >= 0 else 'after'} its time, without jumps"
    return judged("sound moments", faults, told, TIMES)


def check_ring(hello: Hello, seen: Sequence[Picture], given: bool) -> Finding:
    """Check that an engine that asks for a ring uses it."""
    if not hello.ring:
        return not_tried("ring", "HELLO does not say `ring`", RING)
    if not given:
        return not_tried("ring", "this machine cannot provide one", RING)
    through = sum(picture.in_ring for picture in seen)
    if not through:
        return failed("ring", "HELLO asks for a ring, and no picture came through it", RING)
    return passed("ring", f"{through} of {len(seen)} pictures came through it, every lock word was right", RING)
