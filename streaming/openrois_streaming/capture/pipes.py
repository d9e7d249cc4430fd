"""Output of other programs, such as FFmpeg and GStreamer, as sources. They run while their source is open."""

import asyncio
import logging
import os
import signal
from asyncio.subprocess import DEVNULL, PIPE, Process, SubprocessStreamProtocol
from collections.abc import AsyncGenerator, AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from typing import Any, Final

import av
import numpy as np
from numpy.typing import NDArray

from openrois_streaming.capture.audio import AudioSource
from openrois_streaming.capture.video import EncodedSource, VideoSource
from openrois_streaming.codecs import H264, VP8
from openrois_streaming.source.source import SAMPLE_RATE, PixelFormat, picture_shape

_CHUNK: Final = 65_536
_BLOCK: Final = 0.01
"""Seconds of sound in a block."""
_TERMINATE_TIMEOUT: Final = 1.0
"""Seconds that a program has to end after SIGTERM; then comes SIGKILL."""
_IVF_HEADER, _IVF_FRAME_HEADER = 32, 12
MAX_UNIT: Final = 16_000_000
"""Bytes of an encoded picture at most."""

_log = logging.getLogger(__name__)


class ProgramEnded(RuntimeError):
    """End of a program that should have gone on; the text has its command and status."""


def piped_pictures(
    command: Sequence[str], *, size: tuple[int, int], frame_rate: float = 30.0, format: PixelFormat = "bgr24"
) -> VideoSource:
    """Return the raw pictures that a program writes to its standard output, one after the other, without padding.

        piped_pictures(["gst-launch-1.0", "-q", "v4l2src", "!", "videoconvert", "!",
                        "video/x-raw,format=BGR,width=640,height=480", "!", "fdsink"], size=(640, 480))

    Args:
        command: the program and its arguments; what it writes to standard error is this process's.
        size: width and height in pixels.
        frame_rate: pictures per second that are expected.
        format: of the pixels.

    Raises:
        TypeError: the command is no list of strings.
        ValueError: there is no such picture.
    """
    _check_command(command)
    shape = picture_shape(format, *size)
    length = int(np.prod(shape))

    async def pictures() -> AsyncGenerator[NDArray[np.uint8], None]:
        async with _running(command, 2 * length) as output:
            while True:
                yield np.frombuffer(await output.readexactly(length), np.uint8).reshape(shape)

    return VideoSource(pictures, size=size, frame_rate=frame_rate, format=format, name=command[0])


def piped_units(
    command: Sequence[str], *, size: tuple[int, int], mime_type: str = H264, frame_rate: float = 30.0
) -> EncodedSource:
    """Return the encoded pictures that a program writes to its standard output.

    H.264 comes as a byte stream (ITU-T H.264 Annex B), constrained baseline, parameter sets before each key frame; a
    picture is complete when the next one begins. VP8 comes in an IVF file.

    Args:
        command: the program and its arguments.
        size: width and height in pixels.
        mime_type: "video/H264" or "video/VP8".
        frame_rate: pictures per second that are expected.

    Raises:
        TypeError: the command is no list of strings.
        ValueError: the media type is another one.
    """
    _check_command(command)

    async def units() -> AsyncGenerator[bytes, None]:
        async with _running(command, _CHUNK) as output:
            split = _split_ivf(output) if mime_type == VP8 else _split_annex_b(output)
            async for unit in split:
                yield unit
        raise ProgramEnded(f"{command[0]} has written all its pictures")

    return EncodedSource(units, size=size, mime_type=mime_type, frame_rate=frame_rate, name=command[0])


def piped_sound(command: Sequence[str], *, channels: int = 1, sample_rate: int = SAMPLE_RATE) -> AudioSource:
    """Return the sound that a program writes to its standard output: 16 bit, little-endian, channels by turns.

    Args:
        command: the program and its arguments.
        channels: 1 or 2.
        sample_rate: samples per second and channel.

    Raises:
        TypeError: the command is no list of strings.
        ValueError: there are other channels, or the rate is out of range.
    """
    _check_command(command)
    if channels not in (1, 2):
        raise ValueError(f"channels of {command[0]} must be 1 or 2, not {channels}")
    count = round(sample_rate * _BLOCK)

    async def blocks() -> AsyncGenerator[NDArray[np.int16], None]:
        async with _running(command, _CHUNK) as output:
            while True:
                data = await output.readexactly(count * channels * 2)
                yield np.frombuffer(data, "<i2").astype(np.int16, copy=False).reshape(count, channels)

    return AudioSource(blocks, sample_rate=sample_rate, name=command[0])


def _check_command(command: Any) -> None:
    words = isinstance(command, list | tuple) and all(isinstance(word, str) for word in command)
    if not words or not command:
        raise TypeError(f"a command must be a list of the program and its arguments, each a string, not {command!r}")


@asynccontextmanager
async def _running(command: Sequence[str], limit: int) -> AsyncIterator[asyncio.StreamReader]:
    """Run a program and yield its output.

    Raises:
        ProgramEnded: it is not there, or its output has ended before its source was closed.
    """
    loop = asyncio.get_running_loop()
    try:
        # A session of its own: what it starts in its turn, as a shell does, is ended with it, and Ctrl-C is this
        # process's alone.
        transport, protocol = await loop.subprocess_exec(
            lambda: SubprocessStreamProtocol(limit, loop),
            *command,
            stdin=DEVNULL,
            stdout=PIPE,
            stderr=None,
            start_new_session=True,
        )
    except OSError as error:
        raise ProgramEnded(
            f"{command[0]} cannot be started: {error.strerror}: install it, or correct its name"
        ) from error
    process = Process(transport, protocol, loop)
    try:
        assert process.stdout is not None
        yield process.stdout
    except asyncio.IncompleteReadError:
        await _end(process, command[0])
        raise ProgramEnded(
            f"{' '.join(command)} has ended (status {process.returncode}); its last words are in the log"
        ) from None
    finally:
        try:
            await _end(process, command[0])
        finally:
            transport.close()


async def _end(process: Process, name: str) -> None:
    """End a program, and the programs that it has started and that hold its output."""
    assert process.stdout is not None
    for number in (signal.SIGTERM, signal.SIGKILL):
        if process.returncode is not None and process.stdout.at_eof():
            return
        with suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        with suppress(TimeoutError):
            async with asyncio.timeout(_TERMINATE_TIMEOUT):
                await _drained(process)
                return
    _log.warning("%s has left a program behind that does not end with it: let it run in the same session", name)


async def _drained(process: Process) -> None:
    """Wait for the end of a program; its output is read until then, since `wait` needs that."""
    assert process.stdout is not None
    while await process.stdout.read(_CHUNK):
        pass
    await process.wait()


async def _split_annex_b(output: asyncio.StreamReader) -> AsyncGenerator[bytes, None]:
    parser: Any = av.CodecContext.create("h264", "r")
    while chunk := await output.read(_CHUNK):
        for packet in parser.parse(chunk):
            yield bytes(packet)
    for packet in parser.parse(b""):
        yield bytes(packet)


async def _split_ivf(output: asyncio.StreamReader) -> AsyncGenerator[bytes, None]:
    header = await output.readexactly(_IVF_HEADER)
    if header[:4] != b"DKIF" or header[8:12] != b"VP80":
        raise ValueError("the program writes no VP8 in IVF: let it write to an IVF file on its standard output")
    while True:
        length = int.from_bytes((await output.readexactly(_IVF_FRAME_HEADER))[:4], "little")
        if length > MAX_UNIT:
            raise ValueError(f"a picture of {length} bytes is too large: {MAX_UNIT} bytes are the limit")
        yield await output.readexactly(length)
