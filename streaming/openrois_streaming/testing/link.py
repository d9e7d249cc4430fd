"""One direction of a bad network: the fate of each datagram, and its arrival. Pure: the time is an argument.

A datagram waits at the bottleneck until those before it have gone, and takes `size / rate` to go itself; where too much
waits already it is dropped (tail drop). Behind the bottleneck it may be lost, doubled or held back, and travels for
`delay` and up to `jitter`.
"""

import heapq
import itertools
from collections import deque
from dataclasses import dataclass, replace
from random import Random

OVERHEAD = 28
"""Bytes of the IPv4 and UDP headers, which a datagram needs on the wire beside its own."""

FLIGHT_LIMIT = 20_000
"""Datagrams that may travel at once; further ones are dropped."""

_PROBABILITIES = ("loss", "reorder", "duplicate")


@dataclass(frozen=True, slots=True, kw_only=True)
class Impairments:
    """Impairments of one direction; without arguments there are none.

    Attributes:
        rate: bit/s that the bottleneck passes on, headers of IPv4 and UDP included; None: it is never in the way.
        queue: seconds that the datagrams which wait at the bottleneck may take at its rate; more are dropped.
        queue_bytes: bytes that may wait there, instead of `queue`.
        delay: seconds that each datagram travels.
        jitter: seconds that it may travel longer, evenly distributed; it does not overtake.
        loss: the share of the datagrams that are lost, 0..1.
        burst: how many are lost in a row on average, at least 1 (Gilbert's model); None: each by itself.
        reorder: the share of the datagrams that are held back, so that later ones overtake them, 0..1.
        reorder_by: seconds for which they are held back.
        duplicate: the share of the datagrams that arrive twice, 0..1.

    Raises:
        ValueError: a value is out of range.
    """

    rate: float | None = None
    queue: float = 0.2
    queue_bytes: int | None = None
    delay: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    burst: float | None = None
    reorder: float = 0.0
    reorder_by: float = 0.02
    duplicate: float = 0.0

    def __post_init__(self) -> None:
        for name in _PROBABILITIES:
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} is a share of 0..1, not {getattr(self, name)}")
        for name in ("queue", "queue_bytes", "delay", "jitter", "reorder_by"):
            value = getattr(self, name)
            # Not a number is refused too.
            if value is not None and not 0 <= value < float("inf"):
                raise ValueError(f"{name} cannot be {value}")
        if self.rate is not None and not 0 < self.rate < float("inf"):
            raise ValueError(f"a rate of {self.rate} bit/s cannot be; to lose everything, set loss to 1")
        if self.burst is not None and not 1 <= self.burst < float("inf"):
            raise ValueError(f"a burst of {self.burst} datagrams cannot be")

    @property
    def room(self) -> float:
        """Bytes that may wait at the bottleneck."""
        if self.queue_bytes is not None:
            return self.queue_bytes
        return float("inf") if self.rate is None else self.queue * self.rate / 8


@dataclass(slots=True)
class LinkFigures:
    """Counts of one direction.

    Attributes:
        entered: datagrams that came.
        entered_bytes: their bytes, without headers.
        delivered: datagrams that have arrived, copies included.
        delivered_bytes: their bytes, without headers.
        dropped: datagrams for which there was no room.
        lost: datagrams that were lost on the way.
        held_back: datagrams that later ones could overtake.
        duplicated: datagrams that were doubled.
        most_waiting: the most bytes that waited at the bottleneck, headers included.
    """

    entered: int = 0
    entered_bytes: int = 0
    delivered: int = 0
    delivered_bytes: int = 0
    dropped: int = 0
    lost: int = 0
    held_back: int = 0
    duplicated: int = 0
    most_waiting: int = 0


class Link:
    """One direction of a network. All times are seconds of any monotonic clock.

    Args:
        impairments: initial impairments.
        seed: seed of the random choices; they repeat for the same datagrams at the same times.
    """

    def __init__(self, impairments: Impairments | None = None, *, seed: int = 0) -> None:
        self._impairments = impairments or Impairments()
        self._random = Random(seed)  # noqa: S311 - nothing secret
        self._figures = LinkFigures()
        self._waiting: deque[bytes] = deque()
        self._waiting_bytes = 0
        self._gone_at = 0.0
        """Time at which the first waiting datagram has passed."""
        self._flight: list[tuple[float, int, bytes]] = []
        self._order = itertools.count()
        self._last_arrival = float("-inf")
        self._in_burst = False
        self._to_lose = 0

    @property
    def impairments(self) -> Impairments:
        """Present impairments."""
        return self._impairments

    @property
    def waiting(self) -> int:
        """Bytes that wait at the bottleneck, headers included."""
        return self._waiting_bytes

    @property
    def next_at(self) -> float | None:
        """Time of the next `pop`; None if no datagram is on the way."""
        moments = [self._flight[0][0]] if self._flight else []
        if self._waiting:
            moments.append(self._gone_at)
        return min(moments, default=None)

    def figures(self) -> LinkFigures:
        """Return a copy of the counts so far."""
        return replace(self._figures)

    def change(self, impairments: Impairments, now: float) -> None:
        """Set the impairments from now on. Waiting datagrams go on at the new rate, travelling ones are not changed.

        Datagrams that wait already stay, even beyond the new room.
        """
        self._advance(now)
        before, self._impairments = self._impairments, impairments
        if self._waiting:
            assert before.rate is not None, "without a bottleneck nothing waits"
            left = (self._gone_at - now) * before.rate
            self._gone_at = now if impairments.rate is None else now + left / impairments.rate
            self._advance(now)

    def lose_next(self, datagrams: int) -> None:
        """Lose so many datagrams in a row, beginning with the next one that leaves the bottleneck."""
        self._to_lose += datagrams

    def push(self, datagram: bytes, now: float) -> None:
        """Add a datagram that arrives at the link."""
        self._advance(now)
        self._figures.entered += 1
        self._figures.entered_bytes += len(datagram)
        if self._impairments.rate is None:
            self._launch(datagram, now)
        elif not self._waiting:
            self._queue(datagram)
            self._gone_at = now + self._seconds(datagram)
        elif self._waiting_bytes + len(datagram) + OVERHEAD <= self._impairments.room:
            self._queue(datagram)
        else:
            self._figures.dropped += 1

    def pop(self, now: float) -> list[bytes]:
        """Return the datagrams that have arrived since the last call, in the order of their arrival."""
        self._advance(now)
        arrived = []
        while self._flight and self._flight[0][0] <= now:
            arrived.append(heapq.heappop(self._flight)[2])
        self._figures.delivered += len(arrived)
        self._figures.delivered_bytes += sum(map(len, arrived))
        return arrived

    def _queue(self, datagram: bytes) -> None:
        self._waiting.append(datagram)
        self._waiting_bytes += len(datagram) + OVERHEAD
        self._figures.most_waiting = max(self._figures.most_waiting, self._waiting_bytes)

    def _seconds(self, datagram: bytes) -> float:
        """Return the seconds that a datagram takes to pass the bottleneck."""
        rate = self._impairments.rate
        return 0.0 if rate is None else (len(datagram) + OVERHEAD) * 8 / rate

    def _advance(self, now: float) -> None:
        """Let datagrams pass the bottleneck up to the time `now`."""
        while self._waiting and self._gone_at <= now:
            datagram = self._waiting.popleft()
            self._waiting_bytes -= len(datagram) + OVERHEAD
            self._launch(datagram, self._gone_at)
            if self._waiting:
                self._gone_at += self._seconds(self._waiting[0])

    def _launch(self, datagram: bytes, at: float) -> None:
        """Send a datagram on its way behind the bottleneck."""
        if self._is_lost():
            self._figures.lost += 1
            return
        copies = 2 if self._happens(self._impairments.duplicate) else 1
        self._figures.duplicated += copies - 1
        arrival = at + self._impairments.delay + self._random.random() * self._impairments.jitter
        if self._happens(self._impairments.reorder):
            self._figures.held_back += 1
            arrival += self._impairments.reorder_by
        else:
            arrival = self._last_arrival = max(arrival, self._last_arrival)
        for _ in range(copies):
            if len(self._flight) >= FLIGHT_LIMIT:
                self._figures.dropped += 1
            else:
                heapq.heappush(self._flight, (arrival, next(self._order), datagram))

    def _is_lost(self) -> bool:
        if self._to_lose:
            self._to_lose -= 1
            return True
        loss, burst = self._impairments.loss, self._impairments.burst
        if burst is None or loss in (0, 1):
            return self._happens(loss)
        # Gilbert's model: a run ends with 1 / burst, and begins as often as it takes to lose `loss` of all.
        chance = 1 - 1 / burst if self._in_burst else min(1.0, loss / (burst * (1 - loss)))
        self._in_burst = self._happens(chance)
        return self._in_burst

    def _happens(self, share: float) -> bool:
        return self._random.random() < share
