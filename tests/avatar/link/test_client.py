import socket
import subprocess
import sys
import time

import numpy as np
import pytest
from openrois_avatar.link import client
from openrois_avatar.link.client import LinkClient, connect_from_environment
from openrois_avatar.link.messages import Bye, Completed, LinkError, Log, Quit, React, Silence, Welcome
from openrois_avatar.link.outbox import MAX_EVENTS
from openrois_avatar.link.protocol import Audio, Encoded, PixelFormat, Video

from tests.support.avatar_link import HELLO, FakeAdapter, wire

pytestmark = pytest.mark.extra(name="avatar")

PIXELS = bytes(range(32))
LARGE = bytes(2048 * 2048 * 4)


def connect(adapter: FakeAdapter) -> LinkClient:
    return LinkClient.connect(adapter.address, HELLO)


def poll_to_the_end(link: LinkClient) -> str | None:
    """Poll until the link is over, and return the reason; the fake adapter ends it."""
    while link.connected:
        link.poll_commands(5)
    return link.reason


def test_an_engine_greets_and_is_welcome() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        assert link.connected
        assert link.reason is None
        assert adapter.read() == HELLO


def test_pictures_sound_and_events_arrive() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        adapter.read()
        link.send_video(PIXELS, 4, 2, 16, PixelFormat.BGRA, 11, bottom_up=True)
        assert adapter.read() == Video(0, 11, 4, 2, 16, PixelFormat.BGRA, PIXELS, bottom_up=True)
        link.send_video(PIXELS[:12], 4, 2, 4, PixelFormat.I420, 12)
        assert adapter.read() == Video(1, 12, 4, 2, 4, PixelFormat.I420, PIXELS[:12])
        link.send_audio(np.array([[1, -1], [2, -2]], np.int16), 13)
        assert adapter.read() == Audio(0, 13, 2, b"\1\0\xff\xff\2\0\xfe\xff")
        link.send_event(Completed("1", "OK"))
        assert adapter.read() == Completed("1", "OK")
        assert link.dropped_video == link.dropped_audio == 0


def test_encoded_pictures_arrive() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        adapter.read()
        assert link.send_encoded(b"\0\0\1\x65", 4, 2, 11, keyframe=True)
        read = adapter.read()
        assert isinstance(read, Encoded)
        assert (read.sequence, read.timestamp_ns, read.width, read.height, read.keyframe) == (0, 11, 4, 2, True)
        assert bytes(read.data) == b"\0\0\1\x65"
        with pytest.raises(LinkError, match="width and height"):
            link.send_encoded(b"", 1, 2, 11, keyframe=True)


def test_the_caller_may_draw_into_the_same_buffer_at_once() -> None:
    pixels = np.zeros((2, 4, 4), np.uint8)
    with FakeAdapter() as adapter, connect(adapter) as link:
        adapter.read()
        link.send_video(pixels, 4, 2, 16, PixelFormat.BGRA, 0)
        pixels[:] = 255
        assert adapter.read() == Video(0, 0, 4, 2, 16, PixelFormat.BGRA, bytes(32))


def test_a_picture_that_is_none_is_refused_at_the_call() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        with pytest.raises(LinkError, match="32 bytes of pixels expected, 31 found"):
            link.send_video(PIXELS[:-1], 4, 2, 16, PixelFormat.BGRA, 0)
        with pytest.raises(LinkError, match="channels"):
            link.send_audio(np.zeros((960, 3), np.int16), 0)
        assert link.connected


def test_commands_come_in_order_and_once() -> None:
    with FakeAdapter(wire(Welcome("x"), React("0", "bow"))) as adapter, connect(adapter) as link:
        adapter.send(React("1", "nod"), Silence())
        commands = link.poll_commands()
        while len(commands) < 3:
            commands += link.poll_commands(5)
        assert commands == [React("0", "bow"), React("1", "nod"), Silence()]
        assert link.poll_commands() == []


def test_sound_is_heard_apart_from_commands() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        adapter.send(*(Audio(number, 0, 1, bytes([number, 0])) for number in range(30)), Silence())
        commands = link.poll_commands(5)
        while not commands:
            commands = link.poll_commands(5)
        assert commands == [Silence()]
        heard = link.poll_audio()
        assert [block.tolist() for block in heard] == [[[number]] for number in range(5, 30)]
        assert link.poll_audio() == []


def test_a_command_before_the_end_is_still_given() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        adapter.send(Quit(), Bye("the adapter ends"))
        adapter.hang_up()
        commands = link.poll_commands(5)
        assert poll_to_the_end(link) == "the adapter ends"
        assert commands == [Quit()]


def test_an_adapter_that_is_gone_is_noticed() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        adapter.read()
        adapter.hang_up()
        assert poll_to_the_end(link) == "the adapter closed the connection; connect again"
        assert link.poll_commands(60) == []
        link.send_video(PIXELS, 4, 2, 16, PixelFormat.BGRA, 0)


def test_an_adapter_that_breaks_the_protocol_is_left() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        adapter.read()
        adapter.stream.sendall(b"HTTP/1.1 400 Bad Request")
        assert "bad magic" in str(poll_to_the_end(link))
        assert adapter.read() is None


def test_leaving_says_goodbye_after_the_events_that_wait() -> None:
    with FakeAdapter() as adapter:
        with connect(adapter) as link:
            link.send_event(Log("last words"))
        assert [adapter.read() for _ in range(4)] == [HELLO, Log("last words"), Bye("the engine ends"), None]
        link.close()
        assert link.reason == "the engine ends"


def leave_by_failing(adapter: FakeAdapter) -> None:
    with connect(adapter):
        raise ZeroDivisionError


def test_an_engine_that_fails_says_so() -> None:
    with FakeAdapter() as adapter:
        with pytest.raises(ZeroDivisionError):
            leave_by_failing(adapter)
        assert [adapter.read() for _ in range(3)] == [HELLO, Bye("the engine failed"), None]


@pytest.mark.parametrize(
    ("answer", "named"),
    [
        (wire(Bye("wrong secret")), "refused: wrong secret"),
        (b"", "the adapter closed the connection; connect again"),
        (b"SSH-2.0-OpenSSH_", "bad magic"),
        (wire(Welcome("x")) + b"SSH-2.0-OpenSSH_", "bad magic"),
    ],
)
def test_refused_engine_gets_the_reason(answer: bytes, named: str) -> None:
    with FakeAdapter(answer) as adapter, pytest.raises(LinkError, match=named):
        connect(adapter)


def test_engine_refused_before_its_greeting_is_sent_gets_the_reason() -> None:
    ours, theirs = socket.socketpair()
    theirs.sendall(wire(Bye("wrong secret")))
    theirs.close()
    client = LinkClient(ours)
    with pytest.raises(LinkError, match="refused: wrong secret"):
        client._greet(HELLO, time.monotonic() + 5)
    client._release()


def test_an_adapter_that_says_nothing_is_not_waited_for() -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as silent,
        pytest.raises(LinkError, match=r"has not answered HELLO within 0.01 s; check that an adapter listens there"),
    ):
        LinkClient.connect(f"tcp:127.0.0.1:{silent.getsockname()[1]}", HELLO, timeout=0.01)


def stuff(link: LinkClient) -> None:
    """More than all buffers between here and there hold."""
    link.send_video(LARGE, 2048, 2048, 8192, PixelFormat.BGRA, 0)


def test_a_picture_that_the_socket_had_no_room_for_is_drawn_over_without_harm() -> None:
    pixels = np.arange(2048 * 2048, dtype="<u4").view(np.uint8)
    with FakeAdapter() as adapter, connect(adapter) as link:
        first = pixels.tobytes()
        for _ in range(2):
            link.send_video(pixels, 2048, 2048, 8192, PixelFormat.BGRA, 0)
            pixels += 1
        link.send_event(Log("behind what has begun"))
        adapter.read()
        found = adapter.read()
        assert isinstance(found, Video)
        assert found.pixels == first
        assert adapter.read() == Log("behind what has begun")
        found = adapter.read()
        assert isinstance(found, Video)
        assert found.sequence == 1
        assert found.pixels[:4] == b"\1\1\1\1"


def test_a_slow_adapter_costs_pictures_and_sound_but_no_time() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        pictures = blocks = 0
        while link.dropped_video < 3:
            stuff(link)
            pictures += 1
        while link.dropped_audio < 3:
            link.send_audio(np.zeros((960, 1), np.int16), 0)
            blocks += 1
        seen_pictures, seen_blocks = list[int](), list[int]()
        while pictures - 1 not in seen_pictures or blocks - 1 not in seen_blocks:
            match adapter.read():
                case Video(sequence=sequence):
                    seen_pictures.append(sequence)
                case Audio(sequence=sequence):
                    seen_blocks.append(sequence)
        assert len(seen_pictures) == pictures - link.dropped_video
        assert len(seen_blocks) == blocks - link.dropped_audio
        assert seen_pictures == sorted(seen_pictures)
        assert seen_blocks == sorted(seen_blocks)


def test_events_that_pile_up_end_the_link() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        stuff(link)
        while link.dropped_video < 1:
            stuff(link)
        for number in range(MAX_EVENTS + 1):
            link.send_event(Completed(str(number), "OK"))
        assert poll_to_the_end(link) == "the adapter reads too slowly: 256 events wait; send fewer, and connect again"


def test_an_adapter_that_stops_reading_counts_as_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "STALL_TIMEOUT", 0.01)
    with FakeAdapter() as adapter, connect(adapter) as link:
        stuff(link)
        assert (
            poll_to_the_end(link)
            == "the adapter does not read: a write timed out; check that it runs, and connect again"
        )


def test_a_message_too_long_for_the_link_ends_it() -> None:
    with FakeAdapter() as adapter, connect(adapter) as link:
        link.send_event(Completed("x" * 70_000, "OK"))
        assert "over the limit" in str(poll_to_the_end(link))


def test_the_adapter_that_started_us_says_where_it_is() -> None:
    with FakeAdapter() as adapter:
        environment = {"OPENROIS_LINK_ADDRESS": adapter.address, "OPENROIS_LINK_SECRET": "handed over"}
        with connect_from_environment(HELLO, environ=environment):
            hello = adapter.read()
    assert getattr(hello, "secret", None) == "handed over"


def test_an_engine_started_by_hand_is_told_what_is_missing() -> None:
    with pytest.raises(LinkError, match="OPENROIS_LINK_ADDRESS is not set; start the engine from the adapter"):
        connect_from_environment(HELLO, environ={})


@pytest.mark.engine
def test_client_needs_only_the_standard_library_and_numpy() -> None:
    program = "import sys, openrois_avatar.link.client; print(*{name.partition('.')[0] for name in sys.modules})"
    loaded = set(
        subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    )
    assert "numpy" in loaded
    assert not loaded & {"asyncio", "pydantic", "openrois", "openrois_streaming", "openrois_signaling", "av", "cv2"}
