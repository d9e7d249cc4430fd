"""Estimate of the bit rate that a viewer's path carries, from its receiver's reports. Pure: the time is an argument.

A receiver's estimate (REMB) follows the arriving rate: it does not say how much more the path would carry, and it falls
when packets are delayed more and more. So its fall is what counts. Bursts measure whether the path carries more: a
packet behind a burst is late by the time that the burst needs to pass.
"""

from math import inf
from typing import Final

from openrois_streaming.adaptation.meter import LossMeter, LossReport, RateMeter

START: Final = 850_000
"""Bit/s that a path is assumed to carry before any report."""

LEAST: Final = 30_000
"""Bit/s that every path is assumed to carry at least."""

BURST: Final = 0.045
"""Least length of a burst, in seconds of the probed rate: longer than machines are usually late, shorter than queues.
On a path whose round trips vary it is longer."""

# A receiver's estimate after it noticed a queue, as a share of what then arrived (draft-ietf-rmcat-gcc-02 section 5.5).
_BACKED_OFF: Final = 0.85
_FALL: Final = 0.97

# The arriving rate is close to the sent one: the receiver may have taken a jolt for a queue. It is believed the second
# time.
_MILD: Final = 0.8
_STRIKE_APART: Final = 0.3
_STRIKE_MEMORY: Final = 2.0

# Seconds by which packets are late behind a certain queue, and without one.
_QUEUE: Final = 0.3
_NO_QUEUE: Final = 0.05
_RTT_AGE: Final = 1.5

# Loss above random loss, which is repaired, and which a lower rate would not end.
_LOSS: Final = 0.15

_CALM: Final = 1.0
"""Seconds after a step down, or a burst, in which reports are still about that."""

_DOUBT: Final = 0.1
"""Seconds, besides a round trip, in which a measured trip can disprove a complaint of delay."""

_EXCUSED: Final = 0.5
"""Seconds after a standstill of this process in which delays are its own."""

_PATIENCE: Final = 3.0
"""Seconds for which the sent rate may exceed an estimate that does not rise."""

# Share of the rate that a burst showed: single pictures are larger than others, and repetitions need room.
_SAFE: Final = 0.77
_FIRST_QUESTION: Final = 0.2
_STEP: Final = 2.0
_BACK_OFF: Final = 4.0
_LONGEST_BACK_OFF: Final = 32.0
_SOON: Final = 10.0
_SHORTEST_LATE: Final = 0.001


class PathBudget:
    """Bit rate that may be sent to one viewer, everything included.

    `budget` begins with `start`, if an earlier path was measured. It falls as soon as the receiver complains. It rises
    to the rate that a burst has shown; while bursts show no more, they are sent after longer and longer pauses.
    """

    def __init__(self, now: float, start: float | None = None) -> None:
        self.budget: float = max(LEAST, START if start is None else start)
        self.question: float | None = None
        """The bit/s to probe by a burst, which is then `answered`; None if there is nothing to probe."""
        self.round_trip_time: float | None = None
        self._sent = RateMeter(now)
        self._loss_meter = LossMeter()
        self._known = start is not None
        self._back_off = _BACK_OFF
        self._next_question = now + _FIRST_QUESTION
        self._remb: float | None = None
        self._rose_at = now
        self._struck_at: float | None = None
        self._raised_at = self._lowered_at = self._burst_at = float("-inf")
        self._least_rtt = inf
        self._before: tuple[float, float] | None = None
        """The budget and when it was lowered last, before a complaint that may be revoked."""
        self._stalled_at = float("-inf")
        self._rtt_at = float("-inf")

    @property
    def estimate(self) -> float | None:
        """The receiver's newest estimate (REMB), in bit/s; None before the first."""
        return self._remb

    @property
    def queue(self) -> float:
        """Delay of packets by the newest report, in seconds above the least on this path."""
        return 0.0 if self.round_trip_time is None else self.round_trip_time - self._least_rtt

    def sent(self, size: int, now: float) -> None:
        """Count `size` bytes of media sent to the viewer."""
        self._sent.count(size, now)

    def estimated(self, bitrate: float, now: float) -> None:
        """Apply the receiver's estimate (REMB, draft-alvestrand-rmcat-remb) of the bit rate it can receive."""
        before, self._remb = self._remb, bitrate
        if before is None:
            if bitrate < _BACKED_OFF * self._sent.rate(now):
                self._complained(bitrate, now)
        elif bitrate < before * _FALL:
            self._complained(bitrate, now)
        elif bitrate > before:
            self._rose_at = now

    def reported(self, report: LossReport, rtt: float | None, now: float) -> None:
        """Apply a receiver report; `rtt` is the round-trip time in seconds, if it is known."""
        if rtt is not None and not self._excused(now):
            self.round_trip_time, self._rtt_at = rtt, now
            self._least_rtt = min(self._least_rtt, rtt)
        loss = self._loss_meter.add_report(report)
        if now - max(self._lowered_at, self._burst_at) <= _CALM:
            return
        if loss is not None and loss > _LOSS:
            self._lower(self._carried(now) * (1 - loss) * _BACKED_OFF, now)
        elif rtt is not None and self.queue > _QUEUE:
            self._suspect(self._carried(now) * _BACKED_OFF, now)

    def stalled(self, now: float) -> None:
        """Note that this process stood still until now: delays of that time say nothing about the path."""
        self._stalled_at = now

    def doubtful(self, now: float) -> bool:
        """Tell whether the budget was lowered just now for a delay alone, so that a round trip is to be `checked`."""
        trip = 0.0 if self._least_rtt == inf else self._least_rtt
        return self._before is not None and now - self._lowered_at <= _DOUBT + trip

    def checked(self, late: float, now: float) -> None:
        """Apply a round trip after the complaint that was `late` by so many seconds.

        If no queue delayed it, there is none: the receiver, or its machine, was busy.
        """
        if self._before is not None and self.doubtful(now) and late < _NO_QUEUE:
            self.budget, self._lowered_at = self._before
            self._before = None

    def burst(self, now: float) -> None:
        """Note that the burst is sent now."""
        self._burst_at = now

    def answered(self, bits: float, late: float | None, now: float) -> None:
        """Apply the delay of a packet right behind a burst of so many bits: `late` seconds.

        `late` is None if the packet or its answer was lost.
        """
        goal, self.question = self.question, None
        safe = 0.0 if late is None else _SAFE * bits / max(late, _SHORTEST_LATE)
        if goal is not None and safe > self.budget:
            self.budget = min(safe, goal)
            self._raised_at = now
        elif not self._known and late is not None:
            # This is the first measurement, but a late machine is no slow path: the budget at most halves.
            self.budget = max(LEAST, safe, self.budget / 2)
        if goal is not None and safe >= goal:
            self._back_off, self._next_question = _BACK_OFF, now
        else:
            self._postpone(now)
        self._known = self._known or late is not None

    def tick(self, wanted: float, now: float) -> None:
        """Let time pass. `wanted` is the most that is of use to this viewer, in bit/s."""
        if self._overdrawn(now):
            assert self._remb is not None
            self._lower(self._remb, now)
        if self.question is None and self.budget < wanted and now >= self._next_question:
            self.question = min(wanted, self.budget * _STEP) if self._known else wanted

    def _carried(self, now: float) -> float:
        return min(self.budget, self._sent.rate(now))

    def _overdrawn(self, now: float) -> bool:
        """Tell whether the sent rate exceeds the receiver's estimate, which has had time to rise and has not."""
        return (
            self._remb is not None
            and self._remb < _BACKED_OFF * self._carried(now)
            and now - max(self._rose_at, self._lowered_at, self._raised_at) > _PATIENCE
        )

    def _complained(self, bitrate: float, now: float) -> None:
        """Apply a complaint: the receiver noticed a queue, and lowered its estimate to `bitrate`."""
        if self._excused(now):
            self._struck_at = None
        elif now - self._lowered_at <= _CALM:
            if bitrate < self.budget:
                self._settle(bitrate, self._lowered_at if self.doubtful(now) else now)
        elif now - self._burst_at <= _CALM:
            # The receiver noticed the burst.
            self._struck_at = None
        elif bitrate < _MILD * self._sent.rate(now) or self._struck_again(now):
            self._suspect(bitrate, now)

    def _struck_again(self, now: float) -> bool:
        struck_at = self._struck_at
        if struck_at is None or now - struck_at > _STRIKE_MEMORY:
            self._struck_at = now
            return False
        if now - struck_at < _STRIKE_APART:
            return False
        cleared = self._rtt_at > struck_at and now - self._rtt_at < _RTT_AGE and self.queue < _NO_QUEUE
        if cleared:
            self._struck_at = now
        return not cleared

    def _excused(self, now: float) -> bool:
        return now - self._stalled_at <= _EXCUSED

    def _suspect(self, budget: float, now: float) -> None:
        """Lower the budget because of a delay; a round trip right after that may revoke this."""
        before = (self.budget, self._lowered_at)
        self._lower(budget, now)
        self._before = before

    def _lower(self, budget: float, now: float) -> None:
        self._before = None
        self._settle(min(budget, self.budget), now)
        self._struck_at = None
        self._known = True
        if now - self._raised_at <= _SOON:
            # The rate that a burst has shown did not last.
            self._postpone(now)
        else:
            self._next_question = now + _BACK_OFF

    def _settle(self, budget: float, now: float) -> None:
        self.budget = max(LEAST, budget)
        self._lowered_at = now
        self._loss_meter.reset()

    def _postpone(self, now: float) -> None:
        self._next_question = now + self._back_off
        self._back_off = min(2 * self._back_off, _LONGEST_BACK_OFF)
