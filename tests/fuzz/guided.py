"""A coverage-guided fuzzer of one parser: `python tests/fuzz/guided.py TARGET FOLDER -runs=N`, a process of its own.

A target takes any bytes; it must return, in bounded words, whatever they are. libFuzzer mutates what reached new
branches, so it finds what random text does not. Seeds and a dictionary are put into FOLDER first. What it finds ends it
with 77 and stands in FOLDER.
"""

import asyncio
import ipaddress
import json
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import atheris
from aioice import stun

INSTRUMENTED = (
    "openrois",
    "openrois_agents",
    "openrois_avatar",
    "openrois_body.services",
    "openrois_body.speech.pcm",
    "openrois_streaming.peer.sdp",
    "openrois_streaming.input",
    "openrois_streaming.network",
    "openrois_streaming.receive",
    "openrois_streaming.rtp",
    "openrois_streaming.aiortc_internals",
    "openrois_streaming.send",
    "aiortc.rtp",
)

with atheris.instrument_imports(include=INSTRUMENTED):
    from aiortc import RTCPeerConnection
    from aiortc.rtcdtlstransport import RTCDtlsTransport
    from aiortc.rtp import (
        RTCP_PSFB_APP,
        RTCP_PSFB_PLI,
        RTCP_RTPFB_NACK,
        RtcpPsfbPacket,
        RtcpReceiverInfo,
        RtcpRrPacket,
        RtcpRtpfbPacket,
        pack_remb_fci,
    )
    from openrois_agents.mcp.guard import Refused, bearer_of, host_rules
    from openrois_agents.mcp.token_claims import expiry_of, rights_of
    from openrois_agents.mind.model.reply import MAX_REPLY, MAX_TOOL_CALLS, BadReply, Reply, read_delta
    from openrois_agents.mind.model.sentences import MAX_SENTENCE, Sentences
    from openrois_agents.tools.arguments import KINDS, read_arguments
    from openrois_agents.tools.names import by_name
    from openrois_agents.tools.untrusted import marked
    from openrois_avatar.link.messages import Hello, LinkError, Pause, React, VideoShape, Welcome
    from openrois_avatar.link.protocol import Audio, Message, Parser, Sender, encode
    from openrois_body.services.events import EventReader, MalformedEvents
    from openrois_body.speech.pcm import SoundReader, UnknownSound
    from openrois_streaming.aiortc_internals.ice_rehearsal import Rehearsal
    from openrois_streaming.aiortc_internals.incoming import Incoming
    from openrois_streaming.aiortc_internals.sending import DtlsWire, take_over
    from openrois_streaming.clock import SystemClock
    from openrois_streaming.encoded import EncodedFrame
    from openrois_streaming.errors import InvalidCandidate, InvalidDescription
    from openrois_streaming.input import speech as streamed
    from openrois_streaming.input.messages import InputError
    from openrois_streaming.network.guard import GuardFigures
    from openrois_streaming.network.policy import CandidatePolicy
    from openrois_streaming.peer.sdp import Answered, OfferedSection, clean_answer, read_candidate
    from openrois_streaming.receive.assembly import BYTES_LIMIT, PACKETS_LIMIT, VideoAssembly, VideoPacket
    from openrois_streaming.receive.payloads import h264_piece, vp8_piece
    from openrois_streaming.rtp.reports import ReceiverReport
    from openrois_streaming.send.pacer import Outlet
    from openrois_streaming.send.sender import Negotiated, RtpSender

    from openrois.catalog.streaming import VIDEO_STREAMING
    from openrois.cluster.flow import Receiving, Sending
    from openrois.cluster.frames import Dial, FrameFault, Kind, pack_frame, pack_texts, parse_frame, parse_said
    from openrois.cluster.wire import ServerParser, WireFault
    from openrois.engine.condition import parse_condition
    from openrois.errors import BadParameter
    from openrois.jsonrpc.protocol import Notification, Peer, Request, Violation
    from openrois.profiles.xml.parse import MalformedProfile
    from openrois.profiles.xml.read import ComponentDocument, read_profile
    from openrois.profiles.xml.write import component_xml, engine_xml
    from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
    from openrois.types.values import check_value, decode_value, encode_value

PROPERTIES = frozenset({"component_ref", "component_type"})
TYPES = ("int", "double", "bool", "string", "DateTime", "Component_Status", "int[]", "double[][]", "string[]", "bool[]")


def protocol(data: bytes) -> None:
    """One message: what was understood can be answered, and an answer is never longer than it should be."""
    text = data.decode("utf-8", "replace")
    peer = Peer()
    peer.request("asked", {})
    match peer.receive(text):
        case Request() as request:
            peer.response(request.id, request.params)
        case Notification(name, params):
            peer.notification(name, params)
        case Violation(reason, answer):
            assert len(reason) < 300
            if answer is not None:
                answer.encode()


def nats(data: bytes) -> None:
    """What a NATS server sends, cut in two: frames of a stream, and gateways that dial."""
    receiving = Receiving(window=4096, max_message=8192)

    def read(sid: int, _subject: bytes, _headers: bytes, payload: bytes) -> None:
        with suppress(FrameFault, OverflowError):
            if sid == 1:
                parse_said(Dial, payload)
            frame = parse_frame(payload)
            receiving.count(frame.number)
            receiving.put(frame)
        assert receiving.held <= 4096 + 8192
        if len(receiving):
            receiving.pop()
            receiving.next_grant()

    at = data[0] if data else 0
    parser = ServerParser(read, lambda _line: None, 65536)
    with suppress(WireFault):
        parser.feed(data[1:at])
        parser.feed(data[max(1, at) :])


def condition(data: bytes) -> None:
    """One condition and a text to match it with."""
    text, _, value = data.decode("utf-8", "replace").partition("\x00")
    with suppress(BadParameter):
        parsed = parse_condition(text, PROPERTIES)
        parsed.matches({"component_ref": value, "component_type": text})
        assert len(parsed.comparisons) <= len(text)


def values(data: bytes) -> None:
    """One value of one type: what fits is read, and what was read is written so that it fits again."""
    if not data:
        return
    code, text = TYPES[data[0] % len(TYPES)], data[1:].decode("utf-8", "replace")
    with suppress(ValueError):
        check_value(code, text)
        read = decode_value(code, text)
        again = encode_value(code, read)
        check_value(code, again)
        assert decode_value(code, again) == read


def profile_xml(data: bytes) -> None:
    """One profile document: what is read can be written, and is then read as the same."""
    with suppress(MalformedProfile):
        document = read_profile(data)
        if isinstance(document, ComponentDocument):
            again = read_profile(component_xml(document.profile, document.component_ref))
        else:
            again = read_profile(engine_xml(document.profile))
        assert again.profile == document.profile


def link(data: bytes) -> None:
    """One side of the engine link, cut in two: what is understood can be said again, in the same words."""
    parser, cut = Parser((Sender.ENGINE, Sender.ADAPTER)[data[:1] > b"e"]), len(data) // 2
    understood: list[Message] = []
    with suppress(LinkError):
        for part in (data[1:cut], data[cut:]):
            understood += parser.feed(part)
    for message in understood:
        encode(message)


def speech(data: bytes) -> None:
    """One frame or message of the channel `speech`: what is read can be written, and is then read as the same."""
    text = data.decode("utf-8", "replace")
    with suppress(InputError):
        frame = streamed.parse_frame(data)
        assert streamed.pack_frame(frame) == data
    for read in (streamed.read_speech, streamed.read_clear, streamed.read_told):
        with suppress(InputError):
            message = read(text)
            if message is not None:
                assert read(json.dumps(message.to_json(), ensure_ascii=False)) == message


def sound(data: bytes) -> None:
    """Sound of a server, in pieces: it becomes as much sound as its bytes can be, or is refused."""
    reader, piece, made = SoundReader(24_000), 1 + (data[0] if data else 0), 0
    with suppress(UnknownSound):
        for first in range(1, len(data), piece):
            made += len(reader.add(data[first : first + piece]))
        made += len(reader.finish())
    # 8,000 Hz are the least, and a sample has two bytes.
    assert made <= len(data) // 2 * 6 + 6


def events(data: bytes) -> None:
    """Events of a server: pieces make no difference."""
    piece, read = 1 + (data[0] if data else 0), list[list[str]]()
    for size in (piece, len(data) + 1):
        reader, found = EventReader(), list[str]()
        with suppress(MalformedEvents):
            for first in range(1, len(data), size):
                found += reader.add(data[first : first + size])
            read.append(found)
    assert len(read) < 2 or read[0] == read[1]


def agent(data: bytes) -> None:
    """What reaches the tools of agents: a request's headers, a token, arguments, and what a visitor says."""
    text = data.decode("utf-8", "replace")
    rules, (name, _, value) = host_rules("127.0.0.1", (), ()), text.partition(":")
    headers = [(b"host", b"127.0.0.1:80"), (name.lower().encode(), value.encode()[:9000])]
    with suppress(Refused):
        rules.check(headers)
        assert name.lower() not in ("host", "origin")
        assert bearer_of(headers).isprintable()
    expires = expiry_of(text)
    assert expires is None or expires >= 0
    assert rights_of(text) == "" or "sub" in json.loads(rights_of(text))
    with suppress(ValueError, RecursionError):
        given = json.loads(text)
        for kind in KINDS:
            with suppress(BadParameter):
                read_arguments("tool", kind, given)
        assert "\n" not in marked(given)
    said = marked({"heard": text})
    assert said.isprintable()
    assert len(said) < 6 * 2_000 + 200
    assert all(len(each) <= 48 and each.isascii() for each in by_name(text.splitlines()))


def model(data: bytes) -> None:
    """What a language model's server sends: events become a reply or are refused, and its text sentences."""
    reader, reply, sentences = EventReader(), Reply(), Sentences()
    text, found = "", list[str]()
    with suppress(MalformedEvents, BadReply):
        for event in reader.add(data):
            added = reply.add(read_delta(event))
            text += added
            found += sentences.add(added)
            if len(event) % 3 == 0:
                found += sentences.settle()
    found += sentences.finish()
    assert len(text) <= MAX_REPLY
    assert len(reply.calls) <= MAX_TOOL_CALLS
    assert all(call.call_id and call.name.isascii() for call in reply.calls)
    assert all(0 < len(each) <= MAX_SENTENCE and each.isprintable() for each in found)
    assert [each for each in "".join(found) if each.isalnum()] == [each for each in text if each.isalnum()]
    for call in reply.calls:
        assert call.arguments() is None or json.dumps(call.arguments())


DIRECTIONS: tuple[Answered, ...] = ("recvonly", "sendonly", "sendrecv", "inactive")


def answer(data: bytes) -> None:
    """One answer to an offer of a picture and a sound: it says what the application does, or is refused."""
    number = data[0] if data else 0
    offered = [
        OfferedSection("0", "video", DIRECTIONS[number % 4]),
        OfferedSection("1", "audio", DIRECTIONS[number // 4 % 4]),
    ]
    with suppress(InvalidDescription):
        clean = clean_answer(data[1:].decode("utf-8", "replace"), offered)
        assert len(clean.directions) == 2
        assert all(
            theirs in {ours.direction, "inactive"} or ours.direction == "sendrecv"
            for ours, theirs in zip(offered, clean.directions, strict=True)
        )


def candidate(data: bytes) -> None:
    """One candidate: it is refused, of no use, or names a public address as such."""
    with suppress(InvalidCandidate):
        read = read_candidate(data.decode("utf-8", "replace"), "0", CandidatePolicy(False, False))
        if read is not None:
            assert ipaddress.ip_address(read.ip).is_global
            assert read.port >= 1024


def datagram(data: bytes) -> None:
    """One datagram at a media port, of a stranger: nothing of it passes, and nothing fails."""
    rehearsed().protocol.datagram_received(data, ("192.0.2.1", 5000))
    assert rehearsed().agent.waiting == 0
    assert not rehearsed().protocol.gate.proven


@cache
def rehearsed() -> Rehearsal:
    """An ICE agent without sockets and without a peer."""
    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    return Rehearsal()


def spoken(*messages: Message) -> bytes:
    """Messages of the engine link as they are on the wire."""
    return b"".join(b"".join(map(bytes, encode(message))) for message in messages)


def answered(direction: str) -> str:
    """An answer as browsers write it."""
    head = "v=0\r\no=- 1 2 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\na=group:BUNDLE 0 1\r\n"
    path = (
        "a=ice-ufrag:aBcD\r\na=ice-pwd:0123456789abcdefghijklmn\r\na=setup:active\r\na=fingerprint:sha-256 "
        + ":".join(["AB"] * 32)
    )
    video = "m=video 9 UDP/TLS/RTP/SAVPF 97 98\r\na=mid:0\r\na=rtpmap:97 VP8/90000\r\na=rtpmap:98 rtx/90000"
    audio = "m=audio 9 UDP/TLS/RTP/SAVPF 96\r\na=mid:1\r\na=rtpmap:96 opus/48000/2"
    sources = "a=ssrc-group:FID 1 2\r\na=ssrc:1 cname:x\r\na=ssrc:2 cname:x"
    return head + "\r\n".join(
        [video, path, f"a={direction}", sources, audio, path, f"a={direction}", "a=ssrc:3 cname:x", ""]
    )


def pictures(data: bytes) -> None:
    """RTP packets of a camera: nothing is decodable before a key frame, and no more is held than may be.

    The first byte is the codec. A packet is its length, its distance in sequence numbers, its picture's number with the
    marker in the highest bit, and its payload.
    """
    if not data:
        return
    assembly = VideoAssembly(h264_piece if data[0] & 1 else vp8_piece)
    assembly.watched = True
    position, sequence, now, decodable = 1, 1000, 10.0, False
    while position + 3 <= len(data):
        length, distance, picture = data[position : position + 3]
        sequence = max(sequence + distance - 100, 0)
        now += 0.01
        payload = data[position + 3 : position + 3 + length]
        found = assembly.add(VideoPacket(sequence, 3000 * (picture & 0x7F), picture > 0x7F, payload), now)
        found += assembly.check_deadlines(now)[0]
        for each in found:
            decodable |= each.key_frame
            assert decodable or not each.decodable
        assert len(assembly._packets) <= PACKETS_LIMIT
        assert 0 <= assembly._bytes <= BYTES_LIMIT + 4 * len(data)
        assert assembly._bytes == sum(len(held.piece.data) for held in assembly._packets.values() if held.piece)
        position += 3 + length


SSRC = 7


class Reported:
    """A sender whose viewer says anything at all; it hears what it says in bounded numbers."""

    def __init__(self) -> None:
        loop = asyncio.new_event_loop()
        asyncio.set_event_loop(loop)
        replaced = RTCPeerConnection().addTransceiver("video", direction="sendonly").sender
        replaced._ssrc = SSRC
        self.transport: RTCDtlsTransport = replaced.transport
        self.transport._rtp_router.register_sender(replaced, ssrc=SSRC)
        self.figures = GuardFigures()
        Incoming(self.transport, lambda: None, self.figures)
        self.sender = RtpSender("video", self, Outlet.made(SystemClock(), 0.0, loop.call_later))
        self.sender._sequence = 7
        take_over(replaced, self.sender, DtlsWire())
        self.sender.start(Negotiated(SSRC, 97, 8, 98, "name", "0", 1, 3), self)
        self.sender.send(EncodedFrame(b"picture", (b"pic", b"ture"), 0, 90_000, True, 0, 0.0))

    def hear(self, datagram: bytes) -> None:
        """A packet comes, decrypted; it is taken in at once."""
        try:
            self.transport._handle_rtcp_data(datagram).send(None)
        except StopIteration:
            return
        raise AssertionError("a report is waited for")

    def send(self, packets: Sequence[bytes]) -> None:
        assert len(packets) <= 2

    def send_report(self, packet: bytes) -> None: ...

    def sent(self, frame: EncodedFrame) -> None: ...

    def left_out(self, frames: int, *, repair: bool) -> None: ...

    def reported(self, report: ReceiverReport) -> None:
        assert 0 <= report.fraction_lost <= 1

    def estimated(self, bitrate: int) -> None:
        assert bitrate >= 0

    def key_frame_wanted(self) -> None: ...


reported_to = cache(Reported)


def reports(data: bytes) -> None:
    """One RTCP packet of a viewer: what cannot be read is counted, and nothing fails."""
    before = reported_to().figures.total()
    reported_to().hear(data)
    assert reported_to().figures.total() <= before + 1
    assert not reported_to().sender.failed


@dataclass(frozen=True)
class Target:
    """What is tried, where it begins, and the words that its language has."""

    run: Callable[[bytes], None]
    seeds: tuple[str | bytes, ...]
    words: tuple[str, ...]


SENT = Sending(4096, 1000)
FRAMES = (
    SENT.frame(Kind.TEXT, b"hello"),
    SENT.frame(Kind.TEXTS, pack_texts([b"a", b"bc"])),
    SENT.frame(Kind.PART, b"be"),
    SENT.frame(Kind.LAST, b"gun"),
    pack_frame(Kind.CREDIT, 4, bytes(8)),
)
TARGETS = {
    "agent": Target(
        agent,
        (
            "Authorization: Bearer e30.eyJzdWIiOiJhbm4iLCJleHAiOjE3fQ.x",
            "Origin: https://app.example.org",
            "e30.eyJzdWIiOiJhbm4iLCJleHAiOjE3fQ.x",
            '{"text":"Good day!","language":"en","volume":50}',
            '{"tools":["say","go_to"],"wait":5}',
            '{"component":"robot/door","kind":"command","name":"open","arguments":{"times":2}}',
            '{"place":"plant","x":1,"y":-0.5,"facing":1.5,"seconds":1e999}',
            "urn:x-rois:def:reaction:OMG::1\nurn:x-rois:def:reaction:OpenRoIS::kachaka/sound%2F1",
        ),
        ('"text"', '"tools"', '"place"', '"kind"', '"seconds"', '"events"', "null", "NaN", "true", "Bearer ", "host:"),
    ),
    "model": Target(
        model,
        (
            b'data: {"choices":[{"index":0,"delta":{"role":"assistant","content":"Hello! Dr. No is 3.5"}}]}\n\n'
            b'data: {"choices":[{"delta":{"content":" m. \xe4\xbd\xa0\xe5\xa5\xbd\xe3\x80\x82"}}]}\n\n',
            b'data: {"choices":[{"delta":{"tool_calls":[{"index":0,"id":"c","function":{"name":"where"}}]}}]}\n\n'
            b'data: {"choices":[{"delta":{"tool_calls":[{"index":0,"function":{"arguments":"{}"}}]}}]}\n\n'
            b'data: {"choices":[],"usage":{"prompt_tokens":9,"completion_tokens":1}}\n\n',
            b'data: {"error":{"message":"out of memory"}}\n\n',
        ),
        ("data: ", '"choices"', '"delta"', '"content"', '"tool_calls"', '"function"', '"arguments"', '"index"', '"id"'),
    ),
    "protocol": Target(
        protocol,
        (
            '{"jsonrpc":"2.0","id":"req-1","method":"rois.system.connect","params":{}}',
            '{"jsonrpc":"2.0","id":1,"result":{"return_code":"OK"}}',
            '{"jsonrpc":"2.0","id":1,"error":{"code":-32601,"message":"Method not found","data":[]}}',
            '{"jsonrpc":"2.0","method":"rois.command.completed","params":{"command_id":"c1","status":"OK"}}',
            '[{"jsonrpc":"2.0","id":null,"method":"x"}]',
            '{"jsonrpc":"2.0","id":1e999,"method":"\\ud800","params":[NaN,-0,1.5]}',
        ),
        ('"jsonrpc"', '"2.0"', '"id"', '"method"', '"params"', '"result"', '"error"', '"code"', '"message"', "null"),
    ),
    "speech": Target(
        speech,
        (
            streamed.pack_frame(streamed.Frame(1, 0, b"sound")),
            '{"event":"begin","utterance":1,"format":"pcm16","rate":24000,"text":"Hello"}',
            '{"event":"words","utterance":1,"words":[["Hello",0],["you",420]],"marks":[["here",9]]}',
            '{"event":"clear","utterance":1}',
            '{"event":"credit","utterance":1,"samples":50400,"played":2400}',
            '{"event":"finished","utterance":1,"position":80,"reason":"the component was released"}',
        ),
        ('"event"', '"utterance"', '"begin"', '"words"', '"end"', '"opus"', '"rate"', '"starved"', '"started"'),
    ),
    "sound": Target(
        sound,
        (
            b"\x10" + bytes(range(200)),
            b"\x07RIFF\0\0\0\0WAVEfmt \x10\0\0\0\1\0\2\0\x80\x3e\0\0\0\xfa\0\0\4\0\x10\0data\xff\xff\xff\xff"
            + bytes(64),
        ),
        ("RIFF", "WAVE", "fmt ", "data", "LIST", "\\x10\\x00\\x00\\x00"),
    ),
    "events": Target(
        events,
        (
            b'\x05data: {"type":"transcript.text.delta","delta":"a"}\n\ndata: [DONE]\r\n\r\n',
            b"\x02: c\rdata:a\rdata: b\r\r",
        ),
        ("data:", "event:", "\\x0d", "\\x0a", "\\x0d\\x0a", ":"),
    ),
    "nats": Target(
        nats,
        (
            b"\x20" + b"".join(b"MSG a 2 %d\r\n%s\r\n" % (len(each), each) for each in FRAMES),
            b"\x00" + b'PING\r\nHMSG a 1 r 12 30\r\nNATS/1.0\r\n\r\n{"link":"0123456789"}\r\n-ERR \'no\'\r\n',
        ),
        ("MSG ", "HMSG ", "PING", "\\x0d\\x0a", '"link":', '"stream":', '"window":', '"gateway":', '"hello":', "{}"),
    ),
    "condition": Target(
        condition,
        (
            "component_ref = 'avatar/reaction'\x00avatar/reaction",
            "component_ref LIKE 'a%_\\\\%' AND \"component_type\" = 'it''s'\x00abc",
            " and  = '\x00",
        ),
        ("component_ref", "component_type", " AND ", " LIKE ", " = ", "''", "'", "%", "_", "\\\\", "\\x00"),
    ),
    "values": Target(
        values,
        (
            *(f"{chr(index)}{text}" for index in range(len(TYPES)) for text in ("-12", "1.5e-3", "true", "READY")),
            *(f"{chr(index)}{text}" for index in range(6, 10) for text in ("[1,2]", "[[1.5],[]]", '["a"]', "[true]")),
        ),
        ("true", "false", "READY", "[", "]", ",", "e", "-", ".", '\\"', "null", "1e400"),
    ),
    "link": Target(
        link,
        (
            b"a" + spoken(Hello("e", "1", VideoShape(4, 2, 30), hears=True), Audio(1, 2, 1, b"abcd"), Pause(on=True)),
            b"z" + spoken(Welcome("x"), React("1", "nod"), Audio(0, 0, 2, b"abcd")),
        ),
        ("ORL1", '"hears":', '"event":', '"pause"', '"on":', "true", "false", '"command":', '"reaction":', "null"),
    ),
    "candidate": Target(
        candidate,
        (
            "candidate:1 1 udp 2113937151 203.0.114.7 50000 typ host generation 0",
            "1 1 UDP 1 2606:4700::1 9999 typ relay",
        ),
        (
            " typ ",
            "host",
            "srflx",
            "relay",
            " udp ",
            " 1 ",
            "::ffff:",
            "64:ff9b::",
            "127.0.0.1",
            "raddr",
            "rport",
            ".local",
        ),
    ),
    "datagram": Target(
        datagram,
        (
            bytes(stun.Message(stun.Method.BINDING, stun.Class.REQUEST, bytes(12), {"USERNAME": "a:b", "PRIORITY": 1})),
            bytes(stun.Message(stun.Method.BINDING, stun.Class.ERROR, bytes(12), {"ERROR-CODE": (401, "no")})),
            b"\x16\xfe\xfd" + bytes(20),
            b"\x80\x60" + bytes(20),
        ),
        ("\\x21\\x12\\xa4\\x42", "\\x00\\x01", "\\x01\\x01", "\\x00\\x06", "\\x00\\x08", "\\x00\\x20", "\\x80\\x28"),
    ),
    "answer": Target(
        answer,
        tuple(chr(number) + answered(DIRECTIONS[number % 4]) for number in (0, 5, 10, 15)),
        (
            "a=",
            "m=video ",
            "m=audio ",
            "ssrc:",
            "ssrc-group:FID ",
            "sendonly",
            "recvonly",
            "inactive",
            "mid:",
            "rtpmap:",
        ),
    ),
    "pictures": Target(
        pictures,
        (
            b"\x00" + b"\x04\x65\x01\x10\x00ab" + b"\x03\x65\x81\x00cd" + b"\x04\x66\x82\x10\x01ef",
            b"\x01" + b"\x08\x65\x01\x78\x00\x02\x67a\x00\x02\x68" + b"\x04\x65\x81\x7c\x85\x88b",
        ),
        (
            "\\x10",
            "\\x90\\x80",
            "\\x7c\\x85",
            "\\x7c\\x45",
            "\\x78\\x00",
            "\\x65\\x81",
            "\\x67",
            "\\x00\\x00\\x00\\x01",
        ),
    ),
    "reports": Target(
        reports,
        (
            bytes(RtcpRrPacket(1, [RtcpReceiverInfo(SSRC, 64, 3, 70_000, 5, 0, 0)])),
            bytes(RtcpPsfbPacket(RTCP_PSFB_PLI, 1, SSRC)),
            bytes(RtcpPsfbPacket(RTCP_PSFB_APP, 1, 0, pack_remb_fci(1_000_000, [SSRC]))),
            bytes(RtcpRtpfbPacket(RTCP_RTPFB_NACK, 1, SSRC, [0, 7, 9])),
        ),
        ("REMB", "\\x00\\x00\\x00\\x07", "\\x8f\\xce", "\\x81\\xce", "\\x81\\xcd", "\\x81\\xc9", "\\x80\\xc8"),
    ),
    "profile_xml": Target(
        profile_xml,
        (
            component_xml(VIDEO_STREAMING.profile()),
            engine_xml(
                HRIEngineProfile(
                    identifier=RoISIdentifier(code="main"),
                    sub_profiles=(HRIEngineProfile(identifier=RoISIdentifier(code="a")),),
                    component_ids=("main/b c",),
                )
            ),
        ),
        (
            "rois:",
            "gml:id=",
            "<rois:HRIComponent>",
            "</",
            "/>",
            "xsi:type=",
            "&#10;",
            "&amp;",
            "<!DOCTYPE",
            "<![CDATA[",
        ),
    ),
}


def main() -> None:
    """Fuzz the target that the command line names."""
    target, folder = TARGETS[sys.argv[1]], Path(sys.argv[2])
    corpus, words = folder / "corpus", folder / "words"
    corpus.mkdir(parents=True)
    for index, seed in enumerate(target.seeds):
        (corpus / str(index)).write_bytes(seed.encode() if isinstance(seed, str) else seed)
    words.write_text("".join('"{}"\n'.format(word.replace('"', '\\"')) for word in target.words))
    options = [f"-dict={words}", f"-artifact_prefix={folder}/", *sys.argv[3:]]
    atheris.Setup([sys.argv[0], *options, str(corpus)], target.run)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
