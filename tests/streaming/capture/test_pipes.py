"""Output of programs as sources; the programs here are Python's, and where they are installed FFmpeg and GStreamer."""

import asyncio
import os
import select
import shlex
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openrois_streaming.capture import pipes
from openrois_streaming.capture.pipes import ProgramEnded, piped_pictures, piped_sound, piped_units
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source.source import EncodedVideo, MediaSource, RawVideo

GREY = "import sys; out = sys.stdout.buffer\nwhile True: out.write(bytes([{}]) * 64 * 32 * 3)"


def program(text: str) -> list[str]:
    return [sys.executable, "-c", text]


def is_running(note: Path) -> bool:
    """Whether the program that has noted its number runs."""
    return Path(f"/proc/{note.read_text()}").exists()


async def encoded(source: MediaSource[EncodedVideo], count: int) -> list[EncodedVideo]:
    async with asyncio.timeout(30), source.open() as frames:
        return [await anext(frames) for _ in range(count)]


async def test_a_program_gives_pictures_while_its_source_is_open(tmp_path: Path) -> None:
    note = tmp_path / "pid"
    text = f"import os; open({str(note)!r}, 'w').write(str(os.getpid()))\n" + GREY.format(90)
    source = piped_pictures(program(text), size=(64, 32))
    for opening in range(2):
        async with asyncio.timeout(30), source.open() as frames:
            first, second = await anext(frames), await anext(frames)
            assert (first.width, first.height, first.format) == (64, 32, "bgr24")
            assert np.all(first.data == 90)
            assert (first.sequence, second.sequence) == (2 * opening, 2 * opening + 1)
        assert not is_running(note)


async def test_a_program_that_does_not_let_itself_be_ended_is_killed(tmp_path: Path) -> None:
    note = tmp_path / "pid"
    text = (
        "import os, signal, sys; signal.signal(signal.SIGTERM, signal.SIG_IGN);"
        f"open({str(note)!r}, 'w').write(str(os.getpid()))\n" + GREY.format(0)
    )
    async with asyncio.timeout(30), piped_pictures(program(text), size=(64, 32)).open() as frames:
        await anext(frames)
    assert not is_running(note)


@pytest.mark.parametrize("shell", ["{}; true", "{} & exit 0"])
async def test_the_programs_of_a_program_are_ended_with_it(shell: str, tmp_path: Path) -> None:
    note = tmp_path / "pid"
    text = f"import os; open({str(note)!r}, 'w').write(str(os.getpid()))\n" + GREY.format(90)
    command = ["sh", "-c", shell.format(shlex.join(program(text)))]
    async with asyncio.timeout(30), piped_pictures(command, size=(64, 32)).open() as frames:
        await anext(frames)
        watched = os.pidfd_open(int(note.read_text()))
    try:
        assert select.select([watched], [], [], 10)[0], "it has ended"
    finally:
        os.close(watched)


async def test_a_program_that_leaves_its_session_is_not_waited_for(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipes, "_TERMINATE_TIMEOUT", 0.01)
    note = tmp_path / "pid"
    text = f"import os; os.setsid(); open({str(note)!r}, 'w').write(str(os.getpid()))\n" + GREY.format(90)
    command = ["sh", "-c", f"{shlex.join(program(text))} & exit 0"]
    async with asyncio.timeout(30), piped_pictures(command, size=(64, 32)).open() as frames:
        await anext(frames)
    assert "sh has left a program behind" in caplog.text
    with suppress(ProcessLookupError):  # its output is closed, so that it ends by itself when it writes
        os.kill(int(note.read_text()), signal.SIGKILL)


async def test_a_program_that_ends_says_so() -> None:
    source = piped_pictures(program("import sys; sys.stdout.buffer.write(bytes(6150)); sys.exit(3)"), size=(64, 32))
    async with asyncio.timeout(30), source.open() as frames:
        await anext(frames)
        with pytest.raises(ProgramEnded, match=r"has ended \(status 3\); its last words are in the log"):
            await anext(frames)


async def test_a_program_that_is_not_there_is_named() -> None:
    async with piped_sound(["no-such-program"]).open() as blocks:
        with pytest.raises(ProgramEnded, match=r"no-such-program cannot be started: .*: install it, or correct"):
            await anext(blocks)


async def test_sound_comes_in_blocks_of_ten_milliseconds() -> None:
    text = "import sys; out = sys.stdout.buffer\nwhile True: out.write((b'\\x01\\x00' + b'\\xff\\xff') * 480)"
    async with asyncio.timeout(30), piped_sound(program(text), channels=2).open() as blocks:
        block = await anext(blocks)
    assert block.samples.shape == (480, 2)
    assert block.samples[7].tolist() == [1, -1]


@pytest.mark.parametrize("mime_type", ["video/H264", "video/VP8"])
async def test_encoded_pictures_are_cut_out_of_a_stream(mime_type: str, tmp_path: Path) -> None:
    encoder = VideoEncoder(mime_type, bitrate=300_000, frame_rate=30)
    grey = np.full((48, 64), 100, np.uint8)
    units = [
        chunk.data
        for number in range(6)
        for chunk in encoder.encode(RawVideo(grey, "i420", 64, 32, number, number / 30), key_frame=number % 3 == 0)
    ]
    stream = b"".join(units)
    if mime_type == "video/VP8":
        head = b"DKIF\0\0\x20\0VP80" + bytes(20)
        stream = head + b"".join(len(unit).to_bytes(4, "little") + bytes(8) + unit for unit in units)
    (tmp_path / "stream").write_bytes(stream)
    text = f"import sys; sys.stdout.buffer.write(open({str(tmp_path / 'stream')!r}, 'rb').read())"
    frames = await encoded(piped_units(program(text), size=(64, 32), mime_type=mime_type), 6)
    assert [frame.data for frame in frames] == units
    assert [frame.keyframe for frame in frames] == [True, False, False] * 2


@pytest.mark.parametrize(
    ("stream", "error", "text"),
    [
        (b"RIFF" + bytes(40), ValueError, "writes no VP8 in IVF"),
        (b"DKIF\0\0\x20\0VP80" + bytes(20) + b"\xff\xff\xff\xff" + bytes(8), ValueError, "is too large"),
        (b"DKIF", ProgramEnded, "has ended"),
    ],
)
async def test_what_is_no_ivf_file_is_refused(stream: bytes, error: type[Exception], text: str) -> None:
    source = piped_units(
        program(f"import sys; sys.stdout.buffer.write({stream!r})"), size=(64, 32), mime_type="video/VP8"
    )
    with pytest.raises(error, match=text):
        await encoded(source, 1)


def test_a_picture_that_cannot_be_is_refused_at_once() -> None:
    with pytest.raises(ValueError, match="i420 needs an even width and height"):
        piped_pictures(["cat"], size=(63, 32), format="i420")


@pytest.mark.parametrize("command", ["cat film", [], ["cat", 7]])
def test_what_is_no_command_is_refused_at_once(command: Any) -> None:
    with pytest.raises(TypeError, match="a command must be a list of the program and its arguments"):
        piped_pictures(command, size=(64, 32))
    with pytest.raises(TypeError, match="a command must be"):
        piped_units(command, size=(64, 32))
    with pytest.raises(TypeError, match="a command must be"):
        piped_sound(command)


def test_sound_in_more_channels_than_two_is_refused_at_once() -> None:
    with pytest.raises(ValueError, match="channels of cat must be 1 or 2, not 6"):
        piped_sound(["cat"], channels=6)


_FFMPEG = ["ffmpeg", "-loglevel", "error", "-re", "-f", "lavfi", "-i", "testsrc=size=160x120:rate=30"]


async def shows_pictures(command: list[str]) -> None:
    async with asyncio.timeout(30), piped_pictures(command, size=(160, 120)).open() as frames:
        pictures = [await anext(frames) for _ in range(5)]
    assert all(picture.data.std() > 20 for picture in pictures)


@pytest.mark.usefixtures("gstreamer")
async def test_a_command_of_gstreamer_gives_pictures() -> None:
    shape = "video/x-raw,format=BGR,width=160,height=120,framerate=30/1"
    await shows_pictures(["gst-launch-1.0", "-q", "videotestsrc", "is-live=true", "!", shape, "!", "fdsink"])


@pytest.mark.long
@pytest.mark.usefixtures("ffmpeg")
async def test_a_command_of_ffmpeg_gives_pictures() -> None:
    await shows_pictures([*_FFMPEG, "-f", "rawvideo", "-pix_fmt", "bgr24", "-"])


@pytest.mark.long
@pytest.mark.usefixtures("ffmpeg")
@pytest.mark.parametrize("mime_type", ["video/H264", "video/VP8"])
async def test_a_command_of_ffmpeg_gives_encoded_pictures(mime_type: str) -> None:
    encoder = {
        "video/H264": ["-c:v", "libx264", "-profile:v", "baseline", "-tune", "zerolatency", "-g", "30", "-f", "h264"],
        "video/VP8": ["-c:v", "libvpx", "-deadline", "realtime", "-g", "30", "-f", "ivf"],
    }[mime_type]
    command = [*_FFMPEG, "-pix_fmt", "yuv420p", *encoder, "-"]
    frames = await encoded(piped_units(command, size=(160, 120), mime_type=mime_type), 40)
    assert [number for number, frame in enumerate(frames) if frame.keyframe] == [0, 30]
    assert {(frame.width, frame.height) for frame in frames} == {(160, 120)}
