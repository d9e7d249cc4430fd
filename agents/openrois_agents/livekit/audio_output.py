"""The mouth of an `AgentSession`: what it says is spoken by a body."""

import time
from typing import Final

import numpy as np
from livekit.agents.voice.io import AudioOutput, AudioOutputCapabilities
from livekit.rtc import AudioFrame
from openrois_media.client.speaking import Spoken

from openrois_agents.voice.speech_writer import SpeechWriter

__all__ = ["BodyAudioOutput"]

_LABEL: Final = "OpenRoIS body"


class BodyAudioOutput(AudioOutput):
    """Speaks through a body; LiveKit Agents resamples to its rate.

    What is captured faster than it is heard waits, and `capture_frame` with it. The end of each segment is told with
    what the body says was heard of it.

    Args:
        writer: open for as long as this is used, and used by nothing else.
    """

    def __init__(self, writer: SpeechWriter) -> None:
        super().__init__(
            label=_LABEL,
            # Sound that is held in the middle of a word cannot be told from silence by a viewer.
            capabilities=AudioOutputCapabilities(pause=False),
            sample_rate=writer.rate,
        )
        self._writer = writer
        self._captures = False
        self._has_sound = False
        self._is_cleared = False
        """Whether the rest of the segment that is captured is dropped."""
        writer.started.add(self._tell_started)
        writer.finished.add(self._tell_finished)

    async def capture_frame(self, frame: AudioFrame) -> None:
        """Speak a frame, when there is room for it.

        Raises:
            ValueError: the frame is of another rate.
        """
        if frame.sample_rate != self._writer.rate:
            raise ValueError(f"frames must have {self._writer.rate} Hz, not {frame.sample_rate}: resample them first")
        await super().capture_frame(frame)
        if not self._captures:
            self._captures, self._has_sound, self._is_cleared = True, False, False
        if self._is_cleared or not frame.samples_per_channel:
            return
        self._has_sound = True
        samples = np.frombuffer(frame.data, np.int16).reshape(-1, frame.num_channels)
        await self._writer.write(samples.mean(axis=1).astype(np.int16))

    def flush(self) -> None:
        """End the segment."""
        super().flush()
        if self._captures and not self._has_sound:
            # Of a segment without sound nothing is heard, and all of it was.
            self.on_playback_finished(playback_position=0.0, interrupted=self._is_cleared)
        self._captures = False
        self._writer.end_utterance()

    def clear_buffer(self) -> None:
        """Fall silent at once."""
        self._is_cleared = True
        self._writer.clear()

    def _tell_started(self) -> None:
        self.on_playback_started(created_at=time.time())

    def _tell_finished(self, spoken: Spoken) -> None:
        self.on_playback_finished(playback_position=spoken.seconds, interrupted=spoken.interrupted)
