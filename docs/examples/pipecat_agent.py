"""Repeats what a visitor of a body says, as a pipeline without any model: `pipecat_agent.py [BODY [URL]]`."""

import sys

import numpy as np
from openrois_agents.pipecat import embodied, run_agent
from openrois_media import Media, Purpose
from pipecat.frames.frames import Frame, TTSAudioRawFrame, TTSStoppedFrame, UserAudioRawFrame
from pipecat.pipeline.pipeline import Pipeline
from pipecat.pipeline.worker import PipelineWorker
from pipecat.processors.frame_processor import FrameDirection, FrameProcessor
from pipecat.workers.runner import WorkerRunner

from openrois.client import Client


class Parrot(FrameProcessor):
    """Says what it heard, after half a second of silence; services that hear, think and speak would stand here."""

    def __init__(self) -> None:
        super().__init__()
        self._heard: list[bytes] = []
        self._quiet = 0.0

    async def process_frame(self, frame: Frame, direction: FrameDirection) -> None:
        """Keep the sound of the visitor, and pass everything else on."""
        await super().process_frame(frame, direction)
        if not isinstance(frame, UserAudioRawFrame):
            await self.push_frame(frame, direction)
            return
        loud = np.abs(np.frombuffer(frame.audio, np.int16).astype(int)).max() > 500
        self._quiet = 0.0 if loud else self._quiet + frame.num_frames / frame.sample_rate
        if self._heard or loud:
            self._heard = [*self._heard[-500:], frame.audio]
        if self._heard and self._quiet >= 0.5:
            sound, self._heard = b"".join(self._heard), []
            print(f"{len(sound) / 2 / frame.sample_rate - self._quiet:.1f} s of sound", flush=True)
            await self.push_frame(TTSAudioRawFrame(sound, frame.sample_rate, 1))
            await self.push_frame(TTSStoppedFrame())


async def main(body: str = "avatar", url: str = "ws://127.0.0.1:8765/") -> None:
    """Put the pipeline into the body until Ctrl-C."""
    async with (
        Client(url) as app,
        Media(app) as media,
        embodied(app, media, body, purposes=[Purpose.AGENT]) as transport,
    ):
        pipeline = Pipeline([transport.input(), Parrot(), transport.output()])
        runner = WorkerRunner(handle_sigint=False)
        await runner.add_workers(PipelineWorker(pipeline, idle_timeout_secs=None))
        await runner.run()


if __name__ == "__main__":
    run_agent(main(*sys.argv[1:]))
