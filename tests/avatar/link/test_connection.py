import numpy as np
from openrois_avatar.link.connection import MAX_QUEUED_SOUND, SoundQueue
from openrois_avatar.link.protocol import Audio
from openrois_streaming.source.source import RawAudio


def test_blocks_leave_in_mono_at_once_and_the_newest_after_a_pause() -> None:
    sent: list[Audio] = []
    queue = SoundQueue(sent.append)
    queue.add(RawAudio(np.array([[10, 20]], np.int16), 2.0))
    assert sent == [Audio(0, 2_000_000_000, 1, b"\x0f\x00")]
    queue.pause()
    for number in range(MAX_QUEUED_SOUND + 5):
        queue.add(RawAudio(np.array([[number]], np.int16), -1.0))
    assert len(sent) == 1
    queue.resume()
    assert [block.sequence for block in sent[1:]] == list(range(6, MAX_QUEUED_SOUND + 6))
    assert sent[-1].timestamp_ns == 0
    queue.resume()
    assert len(sent) == 1 + MAX_QUEUED_SOUND
