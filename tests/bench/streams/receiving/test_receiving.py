"""What an application receives, as the bench tells it."""

import time

import numpy as np
import pytest
from openrois_bench.streams.receiving.__main__ import report
from openrois_bench.streams.receiving.viewer import MediaName, Seen
from openrois_bench.streams.uplink.media import FPS, FRAMES
from openrois_streaming.source import stamp


@pytest.mark.parametrize("media", ["i420", "rgb24"])
def test_a_picture_was_sent_the_last_time_that_its_number_was(media: MediaName) -> None:
    # Picture 70 bears the number 10; it was sent 0.1 s ago.
    seen = Seen(media, time.monotonic() - (2 * FRAMES + 10) / FPS - 0.1)
    if media == "i420":
        pixels = np.zeros((270, 320), np.uint8)
        stamp.write(pixels[:180], 10, 0.0)
    else:
        pixels = np.zeros((180, 320, 3), np.uint8)
        stamp.write(pixels, 10, 0.0)
    seen.add_media(pixels)
    assert seen.delays == [pytest.approx(0.1, abs=0.05)]


def test_the_report_has_ratios() -> None:
    one = {"media": "sound", "receiver": "aiortc", "p50_ms": 80, "p95_ms": 90, "per_second": 50, "cpu": 0.04, "load": 1}
    other = {**one, "receiver": "openrois", "p50_ms": 20, "p95_ms": 45, "cpu": 0.05}
    assert report([one, other]).splitlines()[-1].split() == ["sound", "ratio", "0.25", "0.50", "1.00", "1.25", "-"]
