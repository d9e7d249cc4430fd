"""An application's unpaced camera on a narrow path, in simulated time: what stock aiortc sends."""

import random
from collections.abc import Callable

from aiortc.rate import BandwidthUsage, RemoteBitrateEstimator
from openrois_streaming.receive.assembly import VideoAssembly, VideoPacket
from openrois_streaming.receive.limit import BitrateLimit
from openrois_streaming.receive.payloads import Piece
from openrois_streaming.receive.reception import SourceReception
from openrois_streaming.testing.link import Impairments, Link

FRAME = 1 / 30
PACKET = 1200
_BEGINS = b"\x01"
_KEY = b"\x07"


def _piece(payload: bytes) -> Piece:
    return Piece(payload[1:], payload[0] & 1 > 0, payload[0] & 2 > 0, payload[0] & 4 > 0)


class SimulatedCamera:
    """Sends at the requested rate and retransmits at once, without congestion control.

    Args:
        impairments: of the way to the receiver; the way back has the same delay.
        key_frame: bytes of a key frame.
        highest: bit/s that it sends at most, key frames not included.
    """

    def __init__(
        self, impairments: Impairments, *, key_frame: int = 60_000, highest: float = 1_500_000, seed: int = 1
    ) -> None:
        self.now = 0.0
        self.link = Link(impairments, seed=seed)
        self.assembly = VideoAssembly(_piece)
        self.assembly.watched = True
        self.limit = BitrateLimit()
        self.shown: list[float] = []
        """When each picture that can be decoded was there."""
        self.repeated = self.key_frames = 0
        self._key_frame, self._highest = key_frame, highest
        self._bitrate = 500_000.0
        self._random = random.Random(seed)
        self._estimator = RemoteBitrateEstimator()
        self._reception = SourceReception(90_000)
        self._history: dict[int, VideoPacket] = {}
        self._sequence = self._number = self._octets = 0
        self._key_wanted = True
        self._next_frame, self._next_report = 0.0, 0.7
        self._back: list[tuple[float, Callable[[], None]]] = []

    def run(self, seconds: float) -> None:
        """Let time pass, a millisecond at a time."""
        end = self.now + seconds
        while self.now < end:
            self._step()
            self.now = round(self.now + 0.001, 3)

    def fps(self, since: float) -> float:
        """Pictures a second that could be decoded since then."""
        return sum(at >= since for at in self.shown) / (self.now - since)

    def _step(self) -> None:
        for due, act in [each for each in self._back if each[0] <= self.now]:
            self._back.remove((due, act))
            act()
        if self.now >= self._next_frame:
            self._next_frame += FRAME
            self._send_picture()
        for datagram in self.link.pop(self.now):
            self._arrive(datagram)
        at = self.assembly.next_at
        if at is not None and at <= self.now:
            self._attend()
        if self.now >= self._next_report:
            self._next_report = self.now + self._random.uniform(0.4, 1.1)
            self._report()

    def _send_picture(self) -> None:
        key, self._key_wanted = self._key_wanted, False
        self.key_frames += key
        size = self._key_frame if key else round(self._bitrate * FRAME / 8 * self._random.uniform(0.7, 1.3))
        first = _KEY if key else _BEGINS
        while size > 0:
            part = min(size, PACKET)
            size -= part
            packet = VideoPacket(self._sequence, 3000 * self._number, size <= 0, first.ljust(part, b"."))
            self._history[packet.sequence] = packet
            self._sequence += 1
            first = b"\x02" if key else b"\x00"
            self._send(packet, "media")
        self._number += 1

    def _send(self, packet: VideoPacket, what: str) -> None:
        head = f"{packet.sequence} {self.now} {what} ".encode()
        self.link.push(head.ljust(len(packet.payload) + 40, b"."), self.now)

    def _arrive(self, datagram: bytes) -> None:
        sequence, sent_at, what = datagram.rstrip(b".").decode().split()
        packet = self._history[int(sequence)]
        self._octets += len(datagram)
        send_time = round(float(sent_at) * (1 << 18)) & 0xFFFFFF
        told = self._estimator.add(round(self.now * 1000), send_time, len(datagram) - 40, 1)
        if what == "media":
            self._reception.add(packet.sequence, packet.timestamp, self.now)
        if told is not None:
            full = self._estimator.detector.state() is BandwidthUsage.OVERUSING
            self._tell(self.limit.estimated(told[0], self.now, full=full))
        self._show(len([each for each in self.assembly.add(packet, self.now) if each.decodable]))
        self._attend()

    def _attend(self) -> None:
        pictures, request = self.assembly.check_deadlines(self.now)
        self._show(len([each for each in pictures if each.decodable]))
        if request.packets:
            self._answer(lambda: self._repeat(request.packets))
        if request.key_frame:
            self._answer(self._want_key)

    def _show(self, pictures: int) -> None:
        self.shown += [self.now] * pictures

    def _repeat(self, sequences: tuple[int, ...]) -> None:
        for sequence in sequences:
            self.repeated += 1
            self._send(self._history[sequence], "again")

    def _want_key(self) -> None:
        self._key_wanted = True

    def _report(self) -> None:
        report = self._reception.report(self.now)
        if report is not None:
            self.limit.counted(report.highest_sequence, report.packets_lost, self._octets, self.now)

    def _tell(self, bitrate: float) -> None:
        def take() -> None:
            self._bitrate = max(250_000, min(bitrate, self._highest))

        self._answer(take)

    def _answer(self, act: Callable[[], None]) -> None:
        self._back.append((self.now + self.link.impairments.delay, act))
