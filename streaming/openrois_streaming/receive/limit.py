"""Bit rate limit for a sender of pictures (REMB), so that its path does not fill up. Pure."""

START = 1_500_000
"""Initial limit in bit/s; browsers begin with 300,000 by themselves and rise slowly."""

LEAST, MOST = 100_000, 4_000_000
"""Bounds of the limit, in bit/s."""

# Relative rise per second, unless losses or delays limit it.
_RISE = 0.08
_LONGEST_STEP = 1.0

# Loss above random loss, which is repaired and which a lower rate would not end; and its least sample of packets.
_HEAVY_LOSS = 0.15
_LEAST_PACKETS = 60
_BELOW = 0.85


class BitrateLimit:
    """Limit by estimates of a path's bit rate.

    An estimate of a path that is not full only measures the sent rate, and a camera with little motion sends little:
    the limit follows the estimate only on a full path; else it rises by 8 % a second. A queue that stays full delays
    all packets alike, which no estimate notices: then losses lower the limit (draft-ietf-rmcat-gcc-02 section 6).
    """

    def __init__(self) -> None:
        self.bitrate = START
        self._estimated_at: float | None = None
        self._counted: tuple[int, int, int, float] | None = None

    def estimated(self, bitrate: int, now: float, *, full: bool) -> int:
        """Apply an estimate of `bitrate` (bit/s) for a path that is `full` or not; returns the limit."""
        since = 0.0 if self._estimated_at is None else min(now - self._estimated_at, _LONGEST_STEP)
        self._estimated_at = now
        wanted = min(self.bitrate, bitrate) if full else round(self.bitrate * (1 + _RISE * since))
        self.bitrate = max(LEAST, min(wanted, MOST))
        return self.bitrate

    def counted(self, highest: int, lost: int, octets: int, now: float) -> int:
        """Apply total counts of packets sent and lost, and of bytes received with repetitions; returns the limit."""
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
