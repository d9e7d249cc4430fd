"""What comes over SCTP: messages pass, and what is hostile ends the data channels alone."""

from collections.abc import AsyncIterator, Callable
from typing import Any

import pytest
from aiortc import RTCPeerConnection, RTCSctpTransport
from aiortc import rtcsctptransport as sctp
from aiortc.rtcdtlstransport import RTCDtlsTransport
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from openrois_streaming.aiortc_internals.channels import AT_ONCE, PACKETS_LIMIT, contain_channels, differences
from openrois_streaming.network.guard import GuardFigures

TEXT, BINARY, OPEN = 51, 53, 50


class Association:
    """A transport that believes that it is connected, and what comes out of it."""

    def __init__(self, connection: RTCPeerConnection, monkeypatch: pytest.MonkeyPatch) -> None:
        self.sent: list[bytes] = []
        self.came: list[tuple[int, str | bytes]] = []
        self.figures = GuardFigures()
        connection.addTransceiver("video", direction="sendonly")
        channel = connection.createDataChannel("input", negotiated=True, id=0)
        self.transport: RTCSctpTransport = channel.transport

        async def send(data: bytes) -> None:
            self.sent.append(data)

        monkeypatch.setattr(self.transport.transport, "_send_data", send)
        contain_channels(self.transport, 1024, self.figures, lambda stream, data: self.came.append((stream, data)))
        self.transport._last_received_tsn = 0
        self.transport._remote_port = 5000
        self.transport._set_state(RTCSctpTransport.State.ESTABLISHED)
        self._tsn = 0

    async def take(self, packet: bytes) -> None:
        await self.transport._handle_data(packet)

    async def receive(self, data: bytes, stream: int = 0, protocol: int = TEXT, **bent: Any) -> None:
        """Take a packet with one chunk of data, which is a whole message unless `flags` say something else."""
        chunk = sctp.DataChunk(flags=bent.get("flags", sctp.SCTP_DATA_FIRST_FRAG | sctp.SCTP_DATA_LAST_FRAG))
        self._tsn += bent.get("step", 1)
        chunk.tsn, chunk.stream_id, chunk.protocol, chunk.user_data = self._tsn, stream, protocol, data
        chunk.stream_seq = bent.get("stream_seq", 0)
        await self.take(sctp.serialize_packet(5000, 5000, self.transport._local_verification_tag, chunk))


@pytest.fixture
async def association(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Association]:
    connection = RTCPeerConnection()
    yield Association(connection, monkeypatch)
    await connection.close()


async def test_messages_pass_with_their_stream(association: Association) -> None:
    await association.receive(b"hello")
    await association.receive("grüß dich".encode(), stream=1)
    await association.receive(b"\0", protocol=56, stream=1, stream_seq=1)
    assert association.came == [(0, "hello"), (1, "grüß dich"), (1, "")]


async def test_binary_message_stays_bytes(association: Association) -> None:
    await association.receive(b"hello", protocol=BINARY)
    await association.receive(b"\xff", stream=1)
    assert association.came == [(0, b"hello"), (1, b"\xff")]


async def test_other_end_cannot_open_channels(association: Association) -> None:
    before = dict(association.transport._data_channels)
    await association.receive(bytes([3]) + bytes(11), stream=5, protocol=OPEN)
    assert association.transport._data_channels == before


async def test_a_channel_is_agreed_to_by_its_number_alone(association: Association) -> None:
    for stream, word in ((0, b"\2"), (5, b"\2"), (0, b"\2\2"), (0, b"")):
        await association.receive(word, stream=stream, protocol=OPEN)
    assert (association.came, association.figures.unreadable) == ([], 0)


async def test_exceptions_of_the_callback_are_contained_and_logged(
    association: Association, caplog: pytest.LogCaptureFixture
) -> None:
    association.came = None  # type: ignore[assignment]
    await association.receive(b"hello")
    assert "could not be handled" in caplog.text
    association.came = []
    await association.receive(b"again", stream_seq=1)
    assert association.came == [(0, "again")]


class Twice(sctp.Chunk):
    """An INIT that is not alone, which aiortc asserts that it is."""

    def __bytes__(self) -> bytes:
        return bytes(sctp.InitChunk()) * 2


async def test_parser_failures_are_contained(association: Association) -> None:
    await association.take(sctp.serialize_packet(5000, 5000, 0, Twice()))
    assert association.figures.unreadable == 1
    await association.receive(b"hello")
    assert association.came == [(0, "hello")]


async def unfinished(association: Association) -> None:
    flags = sctp.SCTP_DATA_FIRST_FRAG
    for _ in range(PACKETS_LIMIT + 1):
        await association.receive(b"x" * 200, flags=flags)
        flags = 0


async def many_streams(association: Association) -> None:
    for stream in range(9):
        await association.receive(b"x", stream=stream)


async def gaps(association: Association) -> None:
    for _ in range(PACKETS_LIMIT + 2):
        await association.receive(b"x", step=2, flags=4 | 3)


@pytest.mark.parametrize("hostile", [unfinished, many_streams, gaps])
async def test_flood_of_incomplete_data_closes_the_channels(
    association: Association, hostile: Callable[[Association], Any]
) -> None:
    await hostile(association)
    assert association.transport.state == "closed"
    assert association.figures.overflow == 1
    came = len(association.came)
    await association.receive(b"more")
    assert len(association.came) == came


async def test_more_than_the_rate_is_dropped_and_the_channels_stay(association: Association) -> None:
    for _ in range(AT_ONCE // 1000 + 20):
        await association.take(bytes(1000))
    assert association.figures.overflow > 0
    assert association.transport.state == "connected"


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(kind=st.integers(0, 255), flags=st.integers(0, 255), body=st.binary(max_size=200), whole=st.binary(max_size=200))
async def test_whatever_comes_raises_nothing(
    association: Association, kind: int, flags: int, body: bytes, whole: bytes
) -> None:
    association.transport._set_state(RTCSctpTransport.State.ESTABLISHED)  # an example may have ended it
    chunk = sctp.Chunk(flags, body)
    chunk.type = kind
    tag = 0 if kind == 1 else association.transport._local_verification_tag
    await association.take(sctp.serialize_packet(5000, 5000, tag, chunk))
    await association.take(whole)


async def test_differences_are_reported(monkeypatch: pytest.MonkeyPatch, association: Association) -> None:
    fresh = RTCSctpTransport(association.transport.transport)
    assert differences(fresh) == []

    async def elsewhere(self: object, *_arguments: object) -> None:
        pass

    monkeypatch.setattr(RTCDtlsTransport, "_recv_next", elsewhere)
    monkeypatch.setattr(RTCSctpTransport, "_receive_data_chunk", elsewhere)
    assert len(differences(fresh)) == 3
