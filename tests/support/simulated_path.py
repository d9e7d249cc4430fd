"""A viewer behind a bad network, in simulated time: aiortc's own estimator hears what a `Link` lets through."""

import random
from collections.abc import Callable

from aiortc.rate import RemoteBitrateEstimator
from openrois_streaming.adaptation.budget import BURST, PathBudget
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.testing.link import Impairments, Link

FRAME = 1 / 30
PACKET = 1200
TICK = 0.1
VIDEO_SHARE = 0.85


class SimulatedViewer:
    """Sends what a budget allows over a link, and reports to the budget what aiortc's receiver would.

    `media` gives the bit/s of the pictures at a moment, from what the budget allows.
    """

    def __init__(
        self,
        impairments: Impairments,
        *,
        media: Callable[[float], float],
        wanted: float = 2_950_000,
        seed: int = 1,
        start: float | None = None,
    ) -> None:
        self.now = 0.0
        self.link = Link(impairments, seed=seed)
        self.budget = PathBudget(0.0, start)
        self.delays: list[tuple[float, float]] = []
        """When each picture was sent, and after how many seconds its last packet arrived."""
        self.history: list[tuple[float, float]] = []
        """Time and budget at each tick."""
        self._media = media
        self.wanted = wanted
        self._random = random.Random(seed)
        self._estimator = RemoteBitrateEstimator()
        self._sequence = self._highest = self._received = 0
        self._reported = (0, 0)
        self._back: list[tuple[float, Callable[[], None]]] = []
        self._next_frame, self._next_tick, self._next_sr, self._next_rr = 0.0, 0.0, 0.0, 0.7
        self._sr: tuple[float, float] | None = None
        self._asked: float | None = None
        """Bits of the burst that is on its way."""

    def run(self, seconds: float) -> None:
        """Let time pass, a millisecond at a time."""
        end = self.now + seconds
        while self.now < end:
            self._step()
            self.now = round(self.now + 0.001, 3)

    def change(self, impairments: Impairments) -> None:
        """Change the network from now on."""
        self.link.change(impairments, self.now)

    def median_delay(self, since: float = 0.0) -> float:
        """Of the pictures sent since then, the middle one's delay."""
        chosen = sorted(delay for at, delay in self.delays if at >= since)
        return chosen[len(chosen) // 2]

    def median_budget(self, since: float = 0.0) -> float:
        """The budget in the middle of all that there were since then."""
        chosen = sorted(budget for at, budget in self.history if at >= since)
        return chosen[len(chosen) // 2]

    def _step(self) -> None:
        now = self.now
        for due, act in [each for each in self._back if each[0] <= now]:
            self._back.remove((due, act))
            act()
        if now >= self._next_tick:
            self._next_tick += TICK
            self.budget.tick(self.wanted, now)
            self.history.append((now, self.budget.budget))
        if now >= self._next_frame:
            self._next_frame += FRAME
            self._send_picture()
        if self.budget.question is not None and self._asked is None and self.link.waiting < PACKET:
            self._ask(self.budget.question * BURST)
        if now >= self._next_sr:
            self._next_sr += 1.0
            self._send(60, f"sr {now}")
        for datagram in self.link.pop(now):
            self._arrive(datagram)
        if now >= self._next_rr:
            self._next_rr = now + self._random.uniform(0.5, 1.5)
            self._report()

    def _media_rate(self) -> float:
        return self._media(self.budget.budget * VIDEO_SHARE)

    def _send_picture(self) -> None:
        size = round(self._media_rate() * FRAME / 8 * self._random.uniform(0.7, 1.3))
        while size > 0:
            part = min(size, PACKET)
            size -= part
            self._send(part, f"picture {self.now}" if size <= 0 else "part")

    def _ask(self, bits: float) -> None:
        self._asked = bits
        self.budget.burst(self.now)
        for _ in range(round(bits / 8 / PACKET)):
            self._send(PACKET, "padding")
        self._sequence += 1
        self.link.push(f"{self._sequence} {self.now} ping ".encode().ljust(100, b"."), self.now)
        self._back.append((self.now + 0.5, self._give_up))

    def _give_up(self) -> None:
        if self._asked is not None:
            self._asked = None
            self.budget.answered(0.0, None, self.now)

    def _pong(self, sent_at: float) -> None:
        bits, self._asked = self._asked, None
        if bits is not None:
            self.budget.answered(bits, self.now - sent_at - 2 * self.link.impairments.delay, self.now)

    def _send(self, size: int, what: str) -> None:
        self._sequence += 1
        head = f"{self._sequence} {self.now} {what} ".encode()
        self.link.push(head.ljust(size + 40, b"."), self.now)
        if what != "padding":
            self.budget.sent(size + 40, self.now)

    def _arrive(self, datagram: bytes) -> None:
        sequence, sent_at, what, *more = datagram.rstrip(b".").decode().split()
        self._highest = max(self._highest, int(sequence))
        self._received += 1
        if what == "sr":
            self._sr = (float(sent_at), self.now)
            return
        if what == "check":
            late = self.now - float(sent_at) - self.link.impairments.delay
            self._answer(lambda: self.budget.checked(late, self.now))
            return
        if what == "ping":
            self._answer(lambda: self._pong(float(sent_at)))
            return
        if what == "picture":
            self.delays.append((float(more[0]), self.now - float(more[0])))
        send_time = round(float(sent_at) * (1 << 18)) & 0xFFFFFF
        told = self._estimator.add(round(self.now * 1000), send_time, len(datagram) - 40, 1)
        if told is not None:
            self._answer(lambda: self._complain(told[0]))

    def _complain(self, bitrate: float) -> None:
        self.budget.estimated(bitrate, self.now)
        if self.budget.doubtful(self.now):
            self._sequence += 1
            self.link.push(f"{self._sequence} {self.now} check ".encode().ljust(100, b"."), self.now)

    def _report(self) -> None:
        highest, lost = self._highest, self._highest - self._received
        expected, newly = highest - self._reported[0], lost - self._reported[1]
        self._reported = (highest, lost)
        report = ReceiverReport(highest, max(0.0, newly / expected) if expected else 0.0, lost, 0)
        rtt = None if self._sr is None else self._sr[1] - self._sr[0] + self.link.impairments.delay
        self._answer(lambda: self.budget.reported(report, rtt, self.now))

    def _answer(self, act: Callable[[], None]) -> None:
        self._back.append((self.now + self.link.impairments.delay, act))
