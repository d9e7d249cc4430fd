"""A sender without a network: the test writes its input, and keeps its packets and events."""

from collections.abc import Callable, Sequence

from aiortc.rtp import RtpPacket
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.send.pacer import Outlet
from openrois_streaming.send.sender import Negotiated, RtpSender

from tests.support.streaming import VirtualClock

NEGOTIATED = Negotiated(
    ssrc=0xCAFE,
    payload_type=97,
    rtx_ssrc=0xBEEF,
    rtx_payload_type=98,
    cname="name",
    mid="0",
    mid_id=1,
    abs_send_time_id=3,
)


class Wires:
    """A `Wire` that keeps what is sent."""

    def __init__(self) -> None:
        self.packets: list[bytes] = []
        self.reports: list[bytes] = []
        self.failure: Exception | None = None

    def send(self, packets: Sequence[bytes]) -> None:
        if self.failure is not None:
            raise self.failure
        self.packets += packets

    def send_report(self, packet: bytes) -> None:
        self.reports.append(packet)


OFFSET = 1_800_000_000.0 - 1000.0


def picture(sequence: int, *payloads: bytes, keyframe: bool = False, clock_rate: int = 90_000) -> EncodedFrame:
    """A picture of these payloads; 30 of them are a second."""
    moment, payloads = 1000.0 + sequence / 30, payloads or (b"p",)
    return EncodedFrame(
        b"".join(payloads), payloads, round(moment * clock_rate), clock_rate, keyframe, sequence, moment
    )


class Alarm:
    """A call that is to come."""

    def __init__(self, at: float, call: Callable[[], None]) -> None:
        self.at = at
        self.call = call
        self.cancelled = False

    def cancel(self) -> None:
        self.cancelled = True


class Alarms:
    """The calls that are to come on a clock that stands still."""

    def __init__(self, clock: VirtualClock) -> None:
        self._clock = clock
        self._set: list[Alarm] = []

    def later(self, delay: float, call: Callable[[], None]) -> Alarm:
        self._set.append(Alarm(self._clock.now() + delay, call))
        return self._set[-1]

    @property
    def pending(self) -> list[Alarm]:
        return [alarm for alarm in self._set if not alarm.cancelled]

    def advance(self, seconds: float) -> None:
        """Let time pass, with what is to be called in it."""
        end = self._clock.now() + seconds
        while due := sorted((alarm for alarm in self.pending if alarm.at <= end), key=lambda alarm: alarm.at):
            self._set.remove(due[0])
            self._clock._move(max(self._clock.now(), due[0].at))
            due[0].call()
        self._clock._move(end)


class Sending:
    """A sender, its wire, and its reports."""

    def __init__(self, kind: str = "video") -> None:
        self.clock = VirtualClock()
        self.wire = Wires()
        self.sequences: list[int] = []
        self.gaps: list[tuple[int, bool]] = []
        self.reports: list[ReceiverReport] = []
        self.estimates: list[int] = []
        self.requests = 0
        self.alarms = Alarms(self.clock)
        self.outlet = Outlet.made(self.clock, OFFSET, self.alarms.later)
        self.sender = RtpSender(kind, self, self.outlet)

    def sent(self, frame: EncodedFrame) -> None:
        self.sequences.append(frame.sequence)

    def left_out(self, frames: int, *, repair: bool) -> None:
        self.gaps.append((frames, repair))

    def reported(self, report: ReceiverReport) -> None:
        self.reports.append(report)

    def estimated(self, bitrate: int) -> None:
        self.estimates.append(bitrate)

    def key_frame_wanted(self) -> None:
        self.requests += 1

    @property
    def packets(self) -> list[RtpPacket]:
        return [RtpPacket.parse(data) for data in self.wire.packets]
