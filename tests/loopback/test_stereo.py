"""Two channels of a microphone, from a browser to where their bearing is found."""

import asyncio
import math
from pathlib import Path
from statistics import median

import numpy as np
import pytest
from openrois_body.hearing.bearing import SOUND_SPEED, WINDOW, BearingFinder, is_stereo
from openrois_streaming.source.shared_inlet import SharedInlet
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio

from tests.support import loopback
from tests.support.chromium import browser_at, tab

pytestmark = pytest.mark.browser

DISTANCE, LATE = 0.15, 10
"""Metres between the microphones, and the samples by which the left one hears later."""

# Noise as a voice has it, low rather than high, in place of a microphone.
SEND_STEREO = """
const context = new AudioContext({sampleRate: 48000}), count = 96000;
const buffer = context.createBuffer(2, count, 48000);
const [left, right] = [0, 1].map(channel => buffer.getChannelData(channel));
let seed = 1, value = 0;
for (let at = 0; at < count; at++) {
  seed = seed * 16807 % 2147483647;
  value = value * 0.8 + (seed / 2147483647 - 0.5) * 0.2;
  right[at] = left[(at + LATE) % count] = value;
}
const source = new AudioBufferSourceNode(context, {buffer, loop: true});
const microphone = context.createMediaStreamDestination();
source.connect(microphone);
source.start();
const [transceiver] = pc.getTransceivers();
transceiver.sender.replaceTrack(microphone.stream.getAudioTracks()[0]);
transceiver.direction = 'sendonly';
""".replace("LATE", str(LATE))


@pytest.mark.long
async def test_a_browser_sends_two_channels_when_it_is_asked_to_and_their_bearing_is_right(chromium: Path) -> None:
    microphone: SharedInlet[RawAudio] = SharedInlet("microphone")
    heard: list[np.ndarray[tuple[int, ...], np.dtype[np.int16]]] = []
    async with browser_at(chromium) as browser, loopback.engine() as engine, tab(engine, browser) as page:
        page.bend = SEND_STEREO
        engine.session.connect(
            "mic", "engine/Audio", None, "audio", direction="sendonly", inlet=microphone, stereo=True
        )
        async with asyncio.timeout(loopback.PATIENCE), microphone.subscribe(100) as blocks:
            while sum(len(each) for each in heard) < 1.5 * SAMPLE_RATE:
                heard.append((await blocks.get()).samples)
    sound = np.concatenate(heard)[SAMPLE_RATE // 2 :]
    assert is_stereo(sound)
    finder = BearingFinder(DISTANCE)
    found = [finder.find(sound[start : start + WINDOW]) for start in range(0, len(sound) - WINDOW, WINDOW)]
    bearings = [math.degrees(each) for each in found if each is not None]
    expected = math.degrees(math.asin(LATE / SAMPLE_RATE * SOUND_SPEED / DISTANCE))
    assert len(bearings) > len(found) / 2
    assert median(bearings) == pytest.approx(expected, abs=4)
