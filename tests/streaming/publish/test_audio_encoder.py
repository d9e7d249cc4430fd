import av
import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_streaming.publish.audio_encoder import SAMPLES_PER_PACKET, OpusEncoder
from openrois_streaming.publish.encoder import Chunk
from openrois_streaming.source.source import RawAudio

pytestmark = pytest.mark.extra(name="streaming")

START = 1_000_000.0
FIRST = round(START * 48_000)
LOOK_AHEAD = 312 / 48_000
"""What libopus needs to know of the future (RFC 7845 section 4.2: 6.5 ms at 48 kHz)."""


def sine(hertz: float, seconds: float, channels: int = 1) -> NDArray[np.int16]:
    wave = 8000 * np.sin(2 * np.pi * hertz * np.arange(round(seconds * 48_000)) / 48_000)
    return np.repeat(wave.astype(np.int16)[:, np.newaxis], channels, axis=1)


def encode(encoder: OpusEncoder, samples: NDArray[np.int16], block: int, start: float = START) -> list[Chunk]:
    """Encode `samples` in blocks of that many, captured without a gap from `start` on."""
    return [
        chunk
        for first in range(0, len(samples), block)
        for chunk in encoder.encode(RawAudio(samples[first : first + block], start + first / 48_000), key_frame=False)
    ]


def decode(packets: list[bytes]) -> NDArray[np.int16]:
    context = av.CodecContext.create("libopus", "r")
    context.sample_rate, context.format, context.layout = 48_000, "s16", "stereo"
    frames = [frame.to_ndarray() for packet in packets for frame in context.decode(av.Packet(packet))]
    return np.concatenate(frames, axis=1).astype(np.int16).reshape(-1, 2)


def loudest(samples: NDArray[np.int16]) -> float:
    """The frequency in Hz that sounds the loudest."""
    spectrum = np.abs(np.fft.rfft(samples.astype(np.float64)))
    return float(np.argmax(spectrum[1:]) + 1) * 48_000 / len(samples)


@pytest.mark.parametrize("channels", [1, 2])
def test_a_block_of_20_ms_gives_one_packet_at_once(channels: int) -> None:
    encoder = OpusEncoder(bitrate=64_000)
    for number in range(5):
        moment = START + number / 50
        [chunk] = encoder.encode(RawAudio(sine(440, 0.02, channels), moment), key_frame=False)
        assert chunk.pts == FIRST + number * SAMPLES_PER_PACKET
        assert chunk.captured_at == pytest.approx(moment - LOOK_AHEAD, abs=1e-6)
        assert chunk.keyframe


def test_a_click_is_decoded_when_its_packet_says_that_it_was_captured() -> None:
    samples = np.zeros((24_000, 1), np.int16)
    samples[9600:9624] = 20_000
    chunks = encode(OpusEncoder(bitrate=128_000), samples, 960)
    heard = int(np.argmax(np.abs(decode([chunk.data for chunk in chunks])[:, 0].astype(int))))
    captured_at = chunks[0].captured_at + heard / 48_000
    assert captured_at == pytest.approx(START + 9612 / 48_000, abs=0.001)


@pytest.mark.parametrize("channels", [1, 2])
def test_its_payloads_are_the_sound_that_went_in(channels: int) -> None:
    chunks = encode(OpusEncoder(bitrate=64_000), sine(1000, 0.5, channels), 960)
    decoded = decode([payload for chunk in chunks for payload in chunk.payloads])
    assert len(decoded) == 24_000
    for channel in range(2):
        assert loudest(decoded[4800:, channel]) == pytest.approx(1000, abs=5)
        assert np.abs(decoded[4800:, channel]).max() == pytest.approx(8000, rel=0.1)


def test_the_two_channels_stay_apart() -> None:
    samples = np.concatenate((sine(500, 0.5), sine(2000, 0.5)), axis=1)
    decoded = decode([chunk.data for chunk in encode(OpusEncoder(bitrate=128_000), samples, 960)])
    assert loudest(decoded[4800:, 0]) == pytest.approx(500, abs=5)
    assert loudest(decoded[4800:, 1]) == pytest.approx(2000, abs=5)


@pytest.mark.parametrize("block", [441, 480, 1024, 4800])
def test_blocks_of_any_length_become_packets_of_20_ms(block: int) -> None:
    chunks = encode(OpusEncoder(bitrate=64_000), sine(440, 0.5), block)
    assert len(chunks) == 25
    assert [chunk.pts for chunk in chunks] == [FIRST + number * 960 for number in range(25)]
    assert chunks[-1].captured_at == pytest.approx(START + 0.48 - LOOK_AHEAD)


def test_the_jitter_of_capture_times_is_not_passed_on() -> None:
    encoder = OpusEncoder(bitrate=64_000)
    jitter = [0.0, 0.012, -0.009, 0.014, -0.014, 0.0]
    chunks = [
        encoder.encode(RawAudio(sine(440, 0.02), START + number / 50 + late), key_frame=False)[0]
        for number, late in enumerate(jitter)
    ]
    assert [chunk.pts for chunk in chunks] == [FIRST + number * 960 for number in range(6)]


def test_missing_sound_leaves_a_gap_in_time() -> None:
    encoder = OpusEncoder(bitrate=64_000)
    before = encode(encoder, sine(440, 0.11), 480)
    after = encode(encoder, sine(440, 0.1), 480, start=START + 2)
    assert [chunk.pts for chunk in before] == [FIRST + number * 960 for number in range(5)]
    assert [chunk.pts for chunk in after] == [FIRST + 96_000 + number * 960 for number in range(5)]


@pytest.mark.parametrize("lost", [1, 2, 3])
def test_the_sound_after_lost_blocks_keeps_its_time(lost: int) -> None:
    encoder = OpusEncoder(bitrate=64_000)
    numbers = [0, 1, 2, *range(3 + lost, 10)]
    chunks = [encoder.encode(RawAudio(sine(440, 0.02), START + number / 50), key_frame=False)[0] for number in numbers]
    assert [chunk.pts for chunk in chunks] == [FIRST + number * 960 for number in numbers]


def test_a_sample_clock_that_is_too_fast_does_not_run_away() -> None:
    encoder = OpusEncoder(bitrate=64_000)
    chunks = [
        chunk
        for number in range(500)
        for chunk in encoder.encode(RawAudio(sine(440, 0.02), START + number * 0.0195), key_frame=False)
    ]
    gaps = np.diff([chunk.pts for chunk in chunks])
    assert np.all(gaps == 960), "what comes too early is left out, without a jump in time"
    assert chunks[-1].captured_at - (START + 499 * 0.0195) < 0.05
    assert 480 < len(chunks) < 495


def test_stereo_after_mono_goes_on_in_time() -> None:
    encoder = OpusEncoder(bitrate=64_000)
    chunks = encode(encoder, sine(440, 0.05), 480)
    chunks += encode(encoder, sine(440, 0.1, channels=2), 480, start=START + 0.05)
    pts = [chunk.pts for chunk in chunks]
    assert len(pts) == 7
    assert np.all(np.diff(pts) >= 960)
    assert len(decode([chunk.data for chunk in chunks])) == 7 * 960


@pytest.mark.parametrize(("bitrate", "met"), [(24_000, 24_000), (128_000, 128_000), (1, 6_000)])
def test_the_bit_rate_is_met_and_can_be_changed(bitrate: int, met: int) -> None:
    noise = np.random.default_rng(2).integers(-8000, 8000, (48_000, 1)).astype(np.int16)
    encoder = OpusEncoder(bitrate=64_000)
    encode(encoder, noise[:9600], 960)
    encoder.set_bitrate(bitrate)
    chunks = encode(encoder, noise, 960, start=START + 0.2)
    assert chunks[0].pts == FIRST + 9600
    assert sum(len(chunk.data) for chunk in chunks) * 8 == pytest.approx(met, rel=0.3)
