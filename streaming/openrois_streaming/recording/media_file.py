"""Pictures and sound in one file; the ending of its name chooses the container."""

import contextlib
import os
import threading
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self, cast

import av
import numpy as np
from av.audio.stream import AudioStream
from av.container import OutputContainer
from av.video.stream import VideoStream

from openrois_streaming.source.av_frames import VIDEO_CLOCK_RATE, picture_frame, sound_frame
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio, RawVideo

_FRAME_RATE: Final = 30
"""What encoders plan with; a picture has the time at which it was captured, whatever the rate is."""

_DRIFT: Final = SAMPLE_RATE // 25
"""Samples by which sound may be early or late before it is put right: 40 ms, which lips may be off."""

_LONGEST_SILENCE: Final = 10 * SAMPLE_RATE
"""Samples of silence that are made at a time."""


class UnknownEnding(ValueError):
    """Name of a file whose ending is none of `CONTAINERS`."""


@dataclass(frozen=True, slots=True)
class _Container:
    """Container format: FFmpeg's names of it and of its encoders, with their options."""

    format: str
    video: str | None
    audio: str
    video_options: dict[str, str]
    options: dict[str, str]


CONTAINERS: Final = {
    ".mp4": _Container("mp4", "libx264", "aac", {"preset": "veryfast", "crf": "23"}, {"movflags": "+faststart"}),
    ".webm": _Container("webm", "libvpx", "libopus", {"deadline": "realtime", "cpu-used": "6", "crf": "10"}, {}),
    ".wav": _Container("wav", None, "pcm_s16le", {}, {}),
}
"""Endings of files that can be written: H.264 and AAC, VP8 and Opus, and sound alone."""


def has_pictures(path: Path) -> bool:
    """Tell whether a file with this name can hold pictures.

    Raises:
        UnknownEnding: its ending is none of `CONTAINERS`.
    """
    return _container_of(path).video is not None


def _container_of(path: Path) -> _Container:
    found = CONTAINERS.get(path.suffix.lower())
    if found is None:
        given = f"{path.suffix!r} is no ending" if path.suffix else f"{path.name!r} has no ending"
        raise UnknownEnding(f"{given} of a recording: use one of {', '.join(CONTAINERS)}")
    return found


class MediaFile:
    """Writer of a file: enter it, add what was received, leave it.

    The file is written under another name beside it, and gets its own when it is complete; one without any media is
    removed. It begins with the first picture, or the first sound where there are none to come. Pictures are scaled to
    the size of the first one. All methods may be called from any thread.

    Args:
        path: the file.
        video: whether pictures will come.
        audio: whether sound will come.

    Raises:
        UnknownEnding: the ending is none of `CONTAINERS`.
        ValueError: nothing that the container can hold will come.
    """

    def __init__(self, path: Path, *, video: bool, audio: bool) -> None:
        self._container_type = _container_of(path)
        if video and self._container_type.video is None:
            raise ValueError(f"a {path.suffix} file holds sound alone: use .mp4 or .webm")
        if not video and not audio:
            raise ValueError("there is nothing to record: choose pictures, sound or both")
        self.path = path
        self._has_video, self._has_audio = video, audio
        self._lock = threading.Lock()
        self._part: Path | None = None
        self._closed = False
        self._container: OutputContainer | None = None
        self._video: VideoStream | None = None
        self._audio: AudioStream | None = None
        self._origin = 0.0
        self._last_pts = -1
        self._samples = 0
        self._seconds = 0.0

    @property
    def seconds(self) -> float:
        """Length of what was recorded so far."""
        return self._seconds

    def __enter__(self) -> Self:
        part = self.path.with_name(f".{self.path.name}.{os.getpid()}.part")
        part.touch(exist_ok=False)
        self._part = part
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._lock:
            assert self._part is not None, "it was entered"
            self._closed = True
            try:
                if self._container is None:
                    return
                for stream in (self._video, self._audio):
                    if stream is not None:
                        self._container.mux(cast(Any, stream).encode(None))
                self._container.close()
                self._container = None
                self._part.replace(self.path)
            finally:
                if self._container is not None:
                    with contextlib.suppress(av.FFmpegError, OSError):
                        self._container.close()
                self._part.unlink(missing_ok=True)

    def add_picture(self, raw: RawVideo) -> None:
        """Add a picture at the time at which it was captured. Nothing is added to a closed file."""
        with self._lock:
            if self._closed:
                return
            if self._container is None:
                self._begin(raw.captured_at, (raw.width, raw.height))
            if self._video is None or self._container is None:
                return
            pts = round((raw.captured_at - self._origin) * VIDEO_CLOCK_RATE)
            if pts <= self._last_pts:
                return
            self._last_pts = pts
            frame = picture_frame(raw).reformat(self._video.width, self._video.height, "yuv420p")
            frame.pts, frame.time_base = pts, Fraction(1, VIDEO_CLOCK_RATE)
            self._seconds = max(self._seconds, pts / VIDEO_CLOCK_RATE)
            self._container.mux(self._video.encode(frame))

    def add_sound(self, raw: RawAudio) -> None:
        """Add a block of sound at the time at which it was captured; silence stands where some is missing.

        Nothing is added to a closed file.
        """
        with self._lock:
            if self._closed:
                return
            if self._container is None:
                if self._has_video:
                    return
                self._begin(raw.captured_at, None)
            start = round((raw.captured_at - self._origin) * SAMPLE_RATE)
            samples = raw.samples
            late = start - self._samples
            if late > _DRIFT:
                self._encode(np.zeros((min(late, _LONGEST_SILENCE), samples.shape[1]), np.int16))
            elif late < -_DRIFT:
                samples = samples[-late:]
            if len(samples):
                self._encode(samples)

    def _begin(self, origin: float, size: tuple[int, int] | None) -> None:
        chosen = self._container_type
        self._container = av.open(str(self._part), "w", format=chosen.format, options=chosen.options)
        self._origin = origin
        if size is not None and chosen.video is not None:
            video = self._video = cast(VideoStream, self._container.add_stream(chosen.video, rate=_FRAME_RATE))
            video.width, video.height, video.pix_fmt = *size, "yuv420p"
            video.codec_context.time_base = Fraction(1, VIDEO_CLOCK_RATE)
            video.bit_rate = max(2 * size[0] * size[1], 500_000)
            video.options = dict(chosen.video_options)
        if self._has_audio:
            audio = self._audio = cast(AudioStream, self._container.add_stream(chosen.audio, rate=SAMPLE_RATE))
            audio.layout = "stereo"

    def _encode(self, samples: "np.ndarray[Any, np.dtype[np.int16]]") -> None:
        if self._audio is None or self._container is None:
            return
        frame = sound_frame(RawAudio(samples, 0.0))
        frame.pts = self._samples
        self._samples += len(samples)
        self._seconds = max(self._seconds, self._samples / SAMPLE_RATE)
        self._container.mux(self._audio.encode(frame))
