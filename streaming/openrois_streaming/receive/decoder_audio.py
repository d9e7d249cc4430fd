"""Opus from the network: the sound of a packet, and what takes the place of one that is missing."""

from typing import cast

import av
import numpy as np
from av.audio.codeccontext import AudioCodecContext

from openrois_streaming.codecs import LIBRARIES, OPUS
from openrois_streaming.receive.playout import BLOCK, UndecodableSound
from openrois_streaming.receive.stretch import Samples
from openrois_streaming.source.source import SAMPLE_RATE

# A frame of 10 ms (RFC 6716 section 3.1) that has nothing in it is one that the decoder is to conceal.
_TEN_MILLISECONDS, _STEREO = 0xF0, 0x04


class OpusDecoder:
    """Decodes the packets of one source, in stereo. All calls come from one thread."""

    def __init__(self) -> None:
        self._context = self._open()
        self._stereo = 0

    def decode(self, payload: bytes) -> Samples:
        """The sound of a packet, 2.5 to 120 ms.

        Raises:
            UndecodableSound: it cannot be decoded.
        """
        if not payload:
            raise UndecodableSound("an empty packet")
        samples = self._run(payload)
        self._stereo = payload[0] & _STEREO
        return samples

    def conceal(self) -> Samples:
        """10 ms that go on as the sound did, and fade away if they do so for long."""
        try:
            return self._run(bytes([_TEN_MILLISECONDS | self._stereo]))
        except UndecodableSound:
            return np.zeros((BLOCK, 2), np.int16)

    def _run(self, payload: bytes) -> Samples:
        try:
            decoded = [frame.to_ndarray() for frame in self._context.decode(av.Packet(payload))]
        except (av.FFmpegError, ValueError) as error:
            raise UndecodableSound(str(error)) from error
        if not decoded:
            raise UndecodableSound("a packet without sound")
        return np.concatenate(decoded, axis=1, dtype=np.int16).reshape(-1, 2)

    def _open(self) -> AudioCodecContext:
        context = cast(AudioCodecContext, av.CodecContext.create(LIBRARIES[OPUS], "r"))
        context.format, context.layout, context.sample_rate = "s16", "stereo", SAMPLE_RATE
        return context
