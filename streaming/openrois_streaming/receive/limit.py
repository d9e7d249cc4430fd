"""The bit rate that a sender of pictures is told to keep to (REMB), so that its path does not fill up. Pure."""

START = 1_500_000
"""Bit/s that are told before anything is known; browsers begin with 300,000 by themselves and take long to rise."""

LEAST, MOST = 100_000, 4_000_000
"""Bounds of what is told, in bit/s."""

# Per second, while nothing speaks against it.
_RISE = 0.08
_LONGEST_STEP = 1.0

# More than random loss, which is repaired and which sending less would not end; and of how many packets.
_HEAVY_LOSS = 0.15
_LEAST_PACKETS = 60
_BELOW = 0.85


class BitrateLimit:
    """Follows estimates of what a path carries.

    An estimate made of a path that is not full says no more than how much was sent, and a camera that sees little
    sends little: only where the path is full the limit follows it; else it rises by 8 % a second. A queue that is full
    all the time delays all packets alike, which no estimate notices: there the losses say it
    (draft-ietf-rmcat-gcc-02 section 6).
    """

    def __init__(self) -> None:
        self.bitrate = START
        self._estimated_at: float | None = None
        self._counted: tuple[int, int, int, float] | None = None

    def estimated(self, bitrate: int, now: float, *, full: bool) -> int:
        """The path carries `bitrate` (bit/s) as far as it was used, and is `full` or not; returns the limit."""
        since = 0.0 if self._estimated_at is None else min(now - self._estimated_at, _LONGEST_STEP)
        self._estimated_at = now
        wanted = min(self.bitrate, bitrate) if full else round(self.bitrate * (1 + _RISE * since))
        self.bitrate = max(LEAST, min(wanted, MOST))
        return self.bitrate

    def counted(self, highest: int, lost: int, octets: int, now: float) -> int:
        """So many packets have been sent and lost so far, and bytes arrived, repetitions too; returns the limit."""
        before = self._counted
        if before is None or highest < before[0] or now <= before[3]:
            self._counted = (highest, lost, octets, now)
            return self.bitrate
        expected = highest - before[0]
        if expected >= _LEAST_PACKETS:
            self._counted = (highest, lost, octets, now)
            share = (lost - before[1]) / expected
            if share > _HEAVY_LOSS:
                carried = (octets - before[2]) * 8 / (now - before[3])
                wanted = max(_BELOW * carried, (1 - share / 2) * self.bitrate)
                self.bitrate = max(LEAST, min(self.bitrate, round(wanted)))
        return self.bitrate
