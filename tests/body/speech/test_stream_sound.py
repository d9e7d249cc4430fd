"""The sound of a stream: samples and real Opus, at each rate."""

from contextlib import suppress
from fractions import Fraction

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_body.speech.stream_sound import StreamSound
from openrois_streaming.input.messages import InputError
from openrois_streaming.publish.audio_encoder import OpusEncoder
from openrois_streaming.source.source import RawAudio

TONE = np.rint(np.sin(2 * np.pi * 440 * np.arange(48_000) / 48_000) * 12_000).astype(np.int16)


@pytest.mark.parametrize("rate", [16_000, 24_000, 48_000])
def test_samples_are_counted_at_their_rate_and_played_at_48_khz(rate: int) -> None:
    sound = StreamSound("pcm16", rate)
    samples = TONE[:: 48_000 // rate]
    read = sound.read(samples.astype("<i2").tobytes())
    assert sound.count(read) == rate
    played = np.concatenate((sound.resample(read), sound.finish()))
    assert len(played) == 48_000
    assert sound.counted(len(played)) == rate
    middle = slice(1_000, 47_000)
    assert np.abs(played[middle].astype(int) - TONE[middle]).max() < 200


@pytest.mark.parametrize("rate", [16_000, 48_000])
def test_packets_of_opus_are_decoded_and_counted_at_the_rate_that_was_named(rate: int) -> None:
    encoder, sound = OpusEncoder(bitrate=64_000), StreamSound("opus", rate)
    packets = [chunk.data for chunk in encoder.encode(RawAudio(TONE[:, np.newaxis], 0.0), key_frame=False)]
    read = [sound.read(packet) for packet in packets]
    assert [sound.count(each) for each in read] == [rate // 50] * 50
    played = np.concatenate([*(sound.resample(each) for each in read), sound.finish()])
    assert len(played) == 48_000
    spectrum = np.abs(np.fft.rfft(played[4_800:].astype(float)))
    assert np.argmax(spectrum) == pytest.approx(440 * 0.9, abs=1)


def test_opus_in_stereo_is_played_too() -> None:
    context = av.CodecContext.create("libopus", "w")
    context.sample_rate, context.layout, context.format, context.time_base = (
        48_000,
        "stereo",
        "s16",
        Fraction(1, 48_000),
    )
    frame = av.AudioFrame.from_ndarray(np.repeat(TONE[:960], 2)[np.newaxis], format="s16", layout="stereo")
    frame.sample_rate = 48_000
    (packet,) = context.encode(frame)
    assert len(StreamSound("opus", 48_000).read(bytes(packet))) == 960


@pytest.mark.parametrize(("format", "data"), [("pcm16", b"\x01"), ("opus", b"\xff" * 3)])
def test_what_is_no_sound_is_refused(format: str, data: bytes) -> None:
    with pytest.raises(InputError, match=r"whole samples|cannot be decoded"):
        StreamSound(format, 48_000).read(data)  # type: ignore[arg-type]


@given(st.lists(st.binary(min_size=1, max_size=400), max_size=5), st.sampled_from([16_000, 24_000, 48_000]))
@settings(deadline=None)
def test_whatever_comes_as_a_packet_of_opus_is_refused_or_at_most_its_120_ms(packets: list[bytes], rate: int) -> None:
    sound = StreamSound("opus", rate)
    for packet in packets:
        with suppress(InputError):
            read = sound.read(packet)
            assert len(read) <= 5_760
            assert sound.count(read) <= rate * 0.12
            assert len(sound.resample(read)) == len(read)
