"""RTP sender of one m-section to one viewer: payloads are shared, headers and retransmission its own."""

import logging
import secrets
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Protocol

from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.rtp.extensions import Extensions
from openrois_streaming.rtp.history import DEPTH, History, SentFrame, SentPacket
from openrois_streaming.rtp.ntp import ntp
from openrois_streaming.rtp.reports import ReceiverReport, RoundTrip, bye, sender_report
from openrois_streaming.send.pacer import Outlet

_EXTENDED = 0x90  # version 2, with a header extension (RFC 3550 section 5.1)
_PLAIN = 0x80
_MARKER = 0x80

# Seconds between two packets with the capture time of their frame; in between a receiver uses timestamps.
_CAPTURE_INTERVAL = 1.0

# Packets of padding at a time: 10 ms of 40 Mbit/s.
_PADDING_LIMIT = 48

_log = logging.getLogger(__name__)


class Wire(Protocol):
    """Encrypted path to one viewer, shared by its senders."""

    def send(self, packets: Sequence[bytes]) -> None:
        """Protect and send RTP packets now; they are lost if the path is closed."""
        ...

    def send_report(self, packet: bytes) -> None:
        """Protect and send one compound RTCP packet."""
        ...


class SenderListener(Protocol):
    """Listener to a sender. All calls are made in the event loop and must not block."""

    def sent(self, frame: EncodedFrame) -> None:
        """Note that the last packet of `frame` was handed to the network."""
        ...

    def left_out(self, frames: int, *, repair: bool) -> None:
        """Note that `frames` were not sent; if `repair`, a key frame is needed before anything else is sent."""
        ...

    def reported(self, report: ReceiverReport) -> None:
        """Note a receiver report of the viewer."""
        ...

    def estimated(self, bitrate: int) -> None:
        """Note the viewer's estimate of its path (REMB), in bit/s of everything sent."""
        ...

    def key_frame_wanted(self) -> None:
        """Note the viewer's request for a key frame (PLI or FIR, RFC 4585 and RFC 5104)."""
        ...


@dataclass(frozen=True, slots=True)
class Negotiated:
    """Negotiated parameters of one sender. An id or a payload type is None if the viewer does not support it."""

    ssrc: int
    payload_type: int
    rtx_ssrc: int
    rtx_payload_type: int | None
    cname: str
    mid: str
    mid_id: int | None
    abs_send_time_id: int | None
    playout_delay_id: int | None = None
    capture_time_id: int | None = None


@dataclass(slots=True)
class SenderFigures:
    """Figures of one sender."""

    packets: int = 0
    """Packets of media, without retransmissions."""
    octets: int = 0
    """Bytes of payload in them."""
    retransmitted: int = 0
    """Packets that were retransmitted."""
    refused: int = 0
    """Packets that were requested in vain, because the budget of retransmissions was spent."""
    padded: int = 0
    """Packets that were sent again as padding, to measure the path."""
    dropped: int = 0
    """Frames that were not sent."""
    round_trip_time: float | None = None
    """Seconds, smoothed; None before the first answer to a report."""


class RtpSender:
    """Sender of `EncodedFrame`s as RTP to one viewer. It never blocks and never raises.

    It has no task: reports are sent with frames. Frames before `start` are dropped.

    Args:
        kind: "video", whose frames are mostly predicted, or "audio".
        outlet: shared by the senders of a viewer.
    """

    def __init__(self, kind: str, listener: SenderListener, outlet: Outlet) -> None:
        self.failed = False
        """Whether the sender has failed for good."""
        self._predicted = kind == "video"
        self._listener = listener
        self._outlet = outlet
        self._pacer = outlet.pacer
        self._clock = outlet.clock
        self._wall_offset = outlet.wall_offset
        self._figures = SenderFigures()
        self._history = History()
        self._round_trip = RoundTrip()
        # In the lower half, so that it does not wrap around before SRTP knows it (RFC 3711 section 3.3.1).
        self._sequence = secrets.randbelow(1 << 15)
        self._rtx_sequence = secrets.randbelow(1 << 15)
        self._timestamp_origin = secrets.randbelow(1 << 32)
        self._wire: Wire | None = None
        self._broken = False
        self._last: EncodedFrame | None = None
        self._next_report = self._next_capture = 0.0

    @property
    def figures(self) -> SenderFigures:
        """A copy of the figures so far."""
        return replace(self._figures, refused=self._history.refused, round_trip_time=self._round_trip.smoothed)

    @property
    def ssrc(self) -> int | None:
        """SSRC of the sender (RFC 3550 section 3); None before it was started."""
        return None if self._wire is None else self._negotiated.ssrc

    def timestamp(self, pts: int) -> int:
        """Return the RTP timestamp of an `EncodedFrame.pts`."""
        return (self._timestamp_origin + pts) & 0xFFFFFFFF

    def start(self, negotiated: Negotiated, wire: Wire) -> None:
        """Start sending over `wire`."""
        self._negotiated = negotiated
        self._extensions = Extensions(
            negotiated.mid_id,
            negotiated.mid,
            negotiated.abs_send_time_id,
            negotiated.playout_delay_id,
            negotiated.capture_time_id,
        )
        self._wire = wire
        if self._broken:
            self._listener.left_out(0, repair=True)

    def stop(self) -> None:
        """Stop sending, with an RTCP BYE."""
        wire, self._wire = self._wire, None
        if wire is not None:
            try:
                wire.send_report(self._report(self._clock.now()) + bye(self._negotiated.ssrc))
            except Exception:
                self._fail()

    def send(self, frame: EncodedFrame) -> None:
        """Send a frame as soon as the pace allows, if it can be decoded after the frames sent before."""
        if self._wire is None:
            self._figures.dropped += 1
            self._broken = self._predicted
        elif self._broken and not frame.keyframe:
            self._figures.dropped += 1
        else:
            try:
                self._pacer.send(self, frame, urgent=not self._predicted)
            except Exception:
                self._fail()
            if frame.keyframe:
                self._broken = False

    def release(self, frame: EncodedFrame, first: int, end: int) -> None:
        """Send the payloads `first` to `end` of `frame` now, called by the pacer."""
        wire = self._wire
        if wire is None:
            return
        now = self._clock.now()
        payloads = frame.payloads if end - first == len(frame.payloads) else frame.payloads[first:end]
        last = end == len(frame.payloads)
        timestamp = self.timestamp(frame.pts)
        if not self._predicted:
            self._outlet.sound_at = now
        record = SentFrame(self._sequence, timestamp, last and self._predicted, payloads)
        octets = sum(map(len, payloads))
        if frame.keyframe and first == 0 and self._predicted:
            self._history.key_frame(self._sequence, len(frame.data))
        captured = None
        if first == 0 and now >= self._next_capture:
            captured, self._next_capture = frame.captured_at + self._wall_offset, now + _CAPTURE_INTERVAL
        wire.send(self._written(record, now, captured))
        self._history.add(record, octets)
        self._sequence = (self._sequence + len(payloads)) & 0xFFFF
        self._figures.packets += len(payloads)
        self._figures.octets += octets
        self._last = frame
        if last:
            self._listener.sent(frame)
            if now >= self._next_report:
                # The interval varies (RFC 3550 section 6.3.1), so that reports of many senders do not come together.
                self._next_report = now + 0.5 + secrets.randbelow(1000) / 1000
                wire.send_report(self._report(now))

    def discard(self, frames: int, *, repair: bool) -> None:
        """Note frames that the pacer has dropped."""
        self._figures.dropped += frames
        self._broken = True
        self._listener.left_out(frames, repair=repair)

    def reported(self, report: ReceiverReport, last_report: int, delay: int) -> None:
        """Apply a receiver report, which names our last report and its age (1/65536 s)."""
        self._round_trip.answered(last_report, delay, self._clock.now())
        if self._wire is not None:
            self._extensions.acknowledged()
        trip = self._round_trip
        self._listener.reported(replace(report, round_trip_time=trip.smoothed, latest_round_trip=trip.latest))

    def missed(self, sequences: Sequence[int]) -> None:
        """Retransmit the kept ones of the packets that a generic NACK names (RFC 4585 section 6.2.1)."""
        now = self._clock.now()
        found = [self._history.again(sequence, now, self._round_trip.smoothed) for sequence in sequences[:DEPTH]]
        self._figures.retransmitted += self._repeat([packet for packet in found if packet is not None], now)
        if self._history.exhausted and self._predicted and not self._broken:
            # Later frames would be of no use to the viewer, and would delay the key frame.
            self._broken = True
            self._listener.left_out(0, repair=True)

    def pad(self, octets: int) -> int:
        """Send about so many bytes of media again over RTX, as padding; returns how many."""
        if self._wire is None or self._negotiated.rtx_payload_type is None:
            return 0
        chosen: list[SentPacket] = []
        sequence, sent = self._sequence, 0
        while sent < octets and len(chosen) < _PADDING_LIMIT:
            sequence = (sequence - 1) & 0xFFFF
            packet = self._history.find(sequence)
            if packet is None:
                break
            chosen.append(packet)
            sent += len(packet.payload)
        self._figures.padded += self._repeat(chosen, self._clock.now())
        return sent

    def estimated(self, bitrate: int) -> None:
        """Apply the viewer's estimate of its path, in bit/s."""
        self._pacer.estimated(bitrate)
        self._listener.estimated(bitrate)

    def undecodable(self) -> None:
        """Note the viewer's request for a key frame."""
        self._listener.key_frame_wanted()

    def _written(self, frame: SentFrame, now: float, captured: float | None) -> list[bytes]:
        """Return the packets of a frame; the first has its capture time (epoch seconds), if that is given."""
        negotiated = self._negotiated
        extensions = self._block(now)
        first, kind = _EXTENDED if extensions else _PLAIN, negotiated.payload_type
        timestamp, ssrc, sequence = frame.timestamp, negotiated.ssrc, frame.sequence
        pack = _packing(len(extensions))
        packets = [
            pack(first, kind, number & 0xFFFF, timestamp, ssrc, extensions) + payload
            for number, payload in enumerate(frame.payloads, sequence)
        ]
        if frame.marked:
            last = (sequence + len(packets) - 1) & 0xFFFF
            packets[-1] = pack(first, _MARKER | kind, last, timestamp, ssrc, extensions) + frame.payloads[-1]
        if captured is not None and negotiated.capture_time_id is not None:
            block = self._block(now, captured)
            header, payload = packets[0][1:12], packets[0][12 + len(extensions) :]
            packets[0] = bytes((_EXTENDED,)) + header + block + payload
        return packets

    def _block(self, now: float, captured: float | None = None) -> bytes:
        """Return the header extensions of packets that leave now. Pictures without sound are shown at once."""
        return self._extensions.block(now + self._wall_offset, at_once=not self._outlet.sounds(now), captured=captured)

    def _report(self, now: float) -> bytes:
        """Return a report that pairs the time of day with the RTP clock, by the capture time of the last frame."""
        moment, timestamp = now + self._wall_offset, 0
        if self._last is not None:
            passed = round((now - self._last.captured_at) * self._last.clock_rate)
            timestamp = self.timestamp(self._last.pts + passed)
        self._round_trip.sent(ntp(moment), now)
        figures, negotiated = self._figures, self._negotiated
        return sender_report(negotiated.ssrc, moment, timestamp, figures.packets, figures.octets, negotiated.cname)

    def _repeat(self, packets: Sequence[SentPacket], now: float) -> int:
        """Send `packets` again, as retransmissions (RFC 4588 section 4) or unchanged; returns their number."""
        wire = self._wire
        if wire is None or not packets:
            return 0
        negotiated = self._negotiated
        extensions = self._block(now)
        pack = _packing(len(extensions))
        first = _EXTENDED if extensions else _PLAIN
        written: list[bytes] = []
        for packet in packets:
            if negotiated.rtx_payload_type is None:
                kind, sequence, ssrc, original = negotiated.payload_type, packet.sequence, negotiated.ssrc, b""
            else:
                kind, sequence, ssrc = negotiated.rtx_payload_type, self._rtx_sequence, negotiated.rtx_ssrc
                original = packet.sequence.to_bytes(2, "big")
                self._rtx_sequence = (sequence + 1) & 0xFFFF
            marker = _MARKER if packet.marked else 0
            header = pack(first, marker | kind, sequence, packet.timestamp, ssrc, extensions)
            written.append(header + original + packet.payload)
        self._pacer.spend(sum(len(packet.payload) for packet in packets))
        try:
            wire.send(written)
        except Exception:
            self._fail()
        return len(packets)

    def _fail(self) -> None:
        """Note the failure in `failed`; it must not reach the caller that brought the frame."""
        if not self.failed:
            _log.exception("a sender has failed")
        self.failed = True


@cache
def _packing(extensions: int) -> Callable[..., bytes]:
    """Return a packer of RTP headers with so many bytes of extensions (RFC 3550 section 5.1)."""
    return struct.Struct(f"!BBHLL{extensions}s").pack
