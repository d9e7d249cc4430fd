"""Reception report of one source: losses and jitter (RFC 3550 sections 6.4.1, A.3 and A.8). Pure."""

from typing import NamedTuple

_LOST_LIMIT = (1 << 23) - 1
_DELAY_LIMIT = (1 << 32) - 1


class Reception(NamedTuple):
    """Report block, as its fields stand in the packet: `last_report` and `delay` are LSR and DLSR."""

    fraction_lost: int
    packets_lost: int
    highest_sequence: int
    jitter: int
    last_report: int
    delay: int


class SourceReception:
    """Counts of the packets of one source, whose RTP clock has `clock_rate` ticks a second.

    `received` counts all packets, repeated ones too, as the standard has it.
    """

    def __init__(self, clock_rate: int) -> None:
        self.received = 0
        self._clock_rate = clock_rate
        self._first: int | None = None
        self._highest = 0
        self._jitter = 0.0
        self._transit: float | None = None
        self._timestamp: int | None = None
        self._expected_before = self._received_before = 0
        self._report: tuple[int, float] | None = None

    def add(self, sequence: int, timestamp: int, arrival: float) -> None:
        """Count a packet that came at `arrival` (seconds), with unwrapped sequence number and timestamp."""
        self.received += 1
        if self._first is None:
            self._first = self._highest = sequence
        elif sequence <= self._highest:
            return
        self._highest = sequence
        if timestamp == self._timestamp:
            # The packets of one picture leave one after another, so their spacing is no jitter.
            return
        transit = arrival * self._clock_rate - timestamp
        if self._transit is not None:
            self._jitter += (abs(transit - self._transit) - self._jitter) / 16
        self._transit, self._timestamp = transit, timestamp

    def reported(self, ntp: int, arrival: float) -> None:
        """Note a sender report with the 64-bit NTP time `ntp`."""
        self._report = (ntp >> 16 & 0xFFFFFFFF, arrival)

    @property
    def lost(self) -> int:
        """Packets sent and not received; negative if more repeated ones came."""
        return self._expected - self.received

    @property
    def jitter_seconds(self) -> float:
        """Interarrival jitter in seconds."""
        return self._jitter / self._clock_rate

    def report(self, now: float) -> Reception | None:
        """Return the report block, with losses since the one before; None before the first packet."""
        if self._first is None:
            return None
        expected, received = self._expected - self._expected_before, self.received - self._received_before
        self._expected_before, self._received_before = self._expected, self.received
        fraction = max(expected - received, 0) * 256 // expected if expected > 0 else 0
        last_report, arrival = self._report or (0, now)
        return Reception(
            min(fraction, 255),
            max(-_LOST_LIMIT - 1, min(self.lost, _LOST_LIMIT)),
            self._highest & 0xFFFFFFFF,
            min(int(self._jitter), 0xFFFFFFFF),
            last_report,
            min(int(max(now - arrival, 0) * 65536), _DELAY_LIMIT),
        )

    @property
    def _expected(self) -> int:
        return 0 if self._first is None else self._highest - self._first + 1
