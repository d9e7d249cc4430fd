import math

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_streaming.codecs import H264, VP8
from openrois_streaming.publish.audio_encoder import OpusEncoder
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.receive import decoders
from openrois_streaming.receive.decoders import OpusDecoder, UndecodablePicture, VideoDecoder, planes_of
from openrois_streaming.receive.playout import UndecodableSound
from openrois_streaming.source.source import RawAudio, RawVideo

pytestmark = pytest.mark.extra(name="streaming")

CODECS = [H264, VP8]


def encoded(codec: str, count: int, *, width: int = 64, height: int = 48) -> list[bytes]:
    encoder = VideoEncoder(codec, bitrate=500_000, frame_rate=30)
    pictures = []
    for number in range(count):
        data = np.full((height * 3 // 2, width), 60 + 10 * number, np.uint8)
        (chunk,) = encoder.encode(RawVideo(data, "i420", width, height, number, number / 30), key_frame=number == 0)
        pictures.append(bytes(chunk.data))
    return pictures


@pytest.mark.parametrize("codec", CODECS)
class TestVideo:
    def test_a_picture_comes_out_for_each_that_goes_in(self, codec: str) -> None:
        decoder = VideoDecoder(codec)
        for number, data in enumerate(encoded(codec, 5)):
            (picture,) = decoder.decode(data)
            assert (picture.width, picture.height) == (64, 48)
            assert abs(int(planes_of(picture)[20, 30]) - 60 - 10 * number) < 6

    def test_another_size_needs_no_other_decoder(self, codec: str) -> None:
        decoder = VideoDecoder(codec)
        decoder.decode(encoded(codec, 1)[0])
        (picture,) = decoder.decode(encoded(codec, 1, width=160, height=90)[0])
        assert (picture.width, picture.height) == (160, 90)

    def test_after_an_error_it_goes_on_with_a_key_frame(self, codec: str) -> None:
        decoder = VideoDecoder(codec)
        with pytest.raises(UndecodablePicture):
            decoder.decode(b"\x00\x00\x00\x01\x65nonsense")
        assert len(decoder.decode(encoded(codec, 1)[0])) == 1

    def test_a_picture_that_is_too_large_is_refused(self, codec: str, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(decoders, "PIXELS_LIMIT", 64 * 48)
        with pytest.raises(UndecodablePicture):
            VideoDecoder(codec).decode(encoded(codec, 1, width=160, height=90)[0])

    def test_any_bytes_are_survived(self, codec: str) -> None:
        (key,) = encoded(codec, 1)
        decoder = VideoDecoder(codec)

        @settings(max_examples=40)
        @given(st.lists(st.tuples(st.integers(0, len(key) - 1), st.integers(0, 255)), max_size=8))
        def bent(changes: list[tuple[int, int]]) -> None:
            data = bytearray(key)
            for position, value in changes:
                data[position] = value
            try:
                pictures = decoder.decode(bytes(data))
            except UndecodablePicture:
                return
            assert all(planes_of(each).dtype == np.uint8 for each in pictures)

        bent()


class TestPlanes:
    def test_an_odd_size_loses_its_last_row_and_column(self) -> None:
        frame = av.VideoFrame(65, 49, "yuv420p")
        assert planes_of(frame).shape == (72, 64)

    @pytest.mark.parametrize("layout", ["yuv444p", "rgb24"])
    def test_another_layout_becomes_i420(self, layout: str) -> None:
        assert planes_of(av.VideoFrame(64, 48, layout)).shape == (72, 64)

    def test_full_range_becomes_limited(self) -> None:
        frame = av.VideoFrame.from_ndarray(np.full((72, 64), 255, np.uint8), format="yuvj420p")
        assert planes_of(frame)[0, 0] == 235


def spoken(count: int, channels: int = 1) -> list[bytes]:
    encoder = OpusEncoder(bitrate=64_000)
    time = np.arange(960 * count) / 48_000
    wave = (8000 * np.sin(2 * math.pi * 400 * time)).astype(np.int16)
    samples = np.repeat(wave[:, np.newaxis], channels, axis=1)
    return [bytes(each.data) for each in encoder.encode(RawAudio(samples, 0.0), key_frame=False)]


class TestAudio:
    @pytest.mark.parametrize("channels", [1, 2])
    def test_sound_is_always_stereo(self, channels: int) -> None:
        decoder = OpusDecoder()
        for packet in spoken(10, channels):
            samples = decoder.decode(packet)
            assert samples.shape == (960, 2)
            assert samples.dtype == np.int16
        assert 7000 < np.abs(samples.astype(int)).max() < 9000

    def test_concealed_sound_continues_and_fades(self) -> None:
        decoder = OpusDecoder()
        for packet in spoken(10):
            decoder.decode(packet)
        blocks = [decoder.conceal() for _ in range(30)]
        loudness = [float(np.abs(block.astype(int)).max()) for block in blocks]
        assert {block.shape for block in blocks} == {(480, 2)}
        assert loudness[0] > 6000
        assert loudness[-1] < loudness[0] / 2

    def test_concealment_before_any_sound_is_silence(self) -> None:
        assert not OpusDecoder().conceal().any()

    @given(st.binary(max_size=100))
    def test_any_bytes_are_survived(self, payload: bytes) -> None:
        try:
            samples = OpusDecoder().decode(payload)
        except UndecodableSound:
            return
        assert samples.shape[1] == 2
        assert 0 < len(samples) <= 5760
