"""Cameras of this machine as sources."""

from collections.abc import Iterator
from typing import Any, Final

import av
import numpy as np
from numpy.typing import NDArray

from openrois_streaming.capture.video import VideoSource

_MISSED: Final = 30
"""Pictures in a row that a camera may fail to give before it has failed."""


class CameraFailed(RuntimeError):
    """Failure of a camera; the text says which one, and what to try."""


def opencv_camera(
    camera: int | str = 0, *, size: tuple[int, int] = (640, 480), frame_rate: float = 30.0
) -> VideoSource:
    """Return a camera that OpenCV reads. It has to come at the pace of a camera, as with `ffmpeg_input`.

    Args:
        camera: its number, or a path or URL that `cv2.VideoCapture` opens.
        size: width and height that are asked of it; it may give others.
        frame_rate: pictures per second, likewise.
    """

    def pictures() -> Iterator[NDArray[np.uint8]]:
        import cv2  # what needs no camera of OpenCV needs no OpenCV

        capture = cv2.VideoCapture(camera)
        try:
            if not capture.isOpened():
                raise CameraFailed(f"OpenCV cannot open the camera {camera!r}: is it connected, and used by no other?")
            for setting, value in (
                (cv2.CAP_PROP_FRAME_WIDTH, size[0]),
                (cv2.CAP_PROP_FRAME_HEIGHT, size[1]),
                (cv2.CAP_PROP_FPS, frame_rate),
                (cv2.CAP_PROP_BUFFERSIZE, 1),
            ):
                capture.set(setting, value)
            missed = 0
            while missed < _MISSED:
                is_there, picture = capture.read()
                missed = 0 if is_there else missed + 1
                if is_there:
                    yield np.asarray(picture, np.uint8)
            raise CameraFailed(f"the camera {camera!r} gives no pictures any more: connect it again")
        finally:
            capture.release()

    return VideoSource(pictures, size=size, frame_rate=frame_rate, name=f"camera {camera}")


def v4l2_camera(
    device: str = "/dev/video0", *, size: tuple[int, int] = (640, 480), frame_rate: float = 30.0, **options: str
) -> VideoSource:
    """Return a camera that Video4Linux knows, read without OpenCV.

    Args:
        device: its path.
        size: width and height that are asked of it; it gives the nearest that it has.
        frame_rate: pictures per second, likewise.
        **options: of FFmpeg's input device, such as `input_format="mjpeg"`.
    """
    wanted = {"video_size": f"{size[0]}x{size[1]}", "framerate": f"{frame_rate:g}", **options}
    return ffmpeg_input(device, format="v4l2", options=wanted, size=size, frame_rate=frame_rate)


def ffmpeg_input(
    url: str,
    *,
    format: str | None = None,
    options: dict[str, str] | None = None,
    size: tuple[int, int] = (1280, 720),
    frame_rate: float = 30.0,
) -> VideoSource:
    """Return the pictures of what FFmpeg's libraries open: a device, or the URL of a camera in the network.

    It has to come at the pace of a camera; a file would be read as fast as it can be.

    Args:
        url: as FFmpeg takes it, such as "rtsp://camera.local/stream".
        format: of a device; None: it is found out.
        options: of the input.
        size: width and height that are expected.
        frame_rate: pictures per second that are expected.
    """

    def pictures() -> Iterator[NDArray[np.uint8]]:
        try:
            container: Any = av.open(url, format=format, options=options or {}, timeout=(10.0, 5.0))
        except (av.FFmpegError, OSError, ValueError) as error:
            raise CameraFailed(f"{url} cannot be opened: {error}") from error
        with container:
            if not container.streams.video:
                raise CameraFailed(f"{url} has no pictures: name a camera")
            container.streams.video[0].thread_type = "NONE"  # threads of a decoder hold pictures back
            try:
                for frame in container.decode(video=0):
                    # The encoder takes even sizes, and the sizes of I420 are even.
                    even = frame.reformat(frame.width & ~1, frame.height & ~1, "yuv420p", dst_color_range="MPEG")
                    yield even.to_ndarray()
            except av.FFmpegError as error:
                raise CameraFailed(f"{url} gives no pictures any more: {error}") from error
            raise CameraFailed(f"{url} has ended")

    return VideoSource(pictures, size=size, frame_rate=frame_rate, format="i420", name=url)
