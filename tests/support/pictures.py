"""Pictures that move and have texture, for encoders, and what a decoder makes of them."""

import math
from typing import cast

import av
import cv2
import numpy as np
from av.video.codeccontext import VideoCodecContext
from numpy.typing import NDArray
from openrois_streaming.source.source import RawVideo

Plane = NDArray[np.uint8]


class Scene:
    """A textured background that drifts, and a finer block that moves across it: about as hard as a talking head."""

    def __init__(self, width: int = 320, height: int = 180) -> None:
        self.width, self.height = width, height
        noise = np.random.default_rng(1)
        coarse = noise.integers(40, 215, (height // 12, width // 12), dtype=np.uint8)
        fine = noise.integers(40, 215, (height // 8, width // 8), dtype=np.uint8)
        self._background = np.asarray(cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC), np.uint8)
        self._block = np.asarray(cv2.resize(fine, (width // 4, height // 3), interpolation=cv2.INTER_LINEAR), np.uint8)

    def luma(self, number: int) -> Plane:
        """The luma plane of picture `number`."""
        picture = np.roll(self._background, 2 * number, axis=1)
        left = 5 * number % (self.width * 3 // 4)
        picture[self.height // 3 : self.height // 3 * 2, left : left + self.width // 4] = self._block
        return picture

    def picture(self, number: int, captured_at: float) -> RawVideo:
        """Picture `number` in I420, without colour."""
        data = np.full((self.height * 3 // 2, self.width), 128, np.uint8)
        data[: self.height] = self.luma(number)
        return RawVideo(data, "i420", self.width, self.height, number, captured_at)


class Decoder:
    """Decodes what the encoders make; the output is luma planes."""

    def __init__(self, mime_type: str) -> None:
        self._context = cast(
            VideoCodecContext, av.CodecContext.create({"video/H264": "h264", "video/VP8": "libvpx"}[mime_type], "r")
        )
        self._context.thread_count = 1

    def decode(self, data: bytes) -> list[Plane]:
        """The luma planes of the pictures that `data` completes."""
        return [
            np.asarray(frame.to_ndarray()[: frame.height], np.uint8) for frame in self._context.decode(av.Packet(data))
        ]


def psnr(first: Plane, second: Plane) -> float:
    """Return the similarity of two planes in dB; above 30 they are hard to tell apart."""
    error = float(np.mean((first.astype(np.float64) - second) ** 2))
    return 10 * math.log10(255**2 / max(error, 1e-9))
