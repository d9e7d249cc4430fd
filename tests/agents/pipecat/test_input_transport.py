"""The input of a pipeline, without a body: what comes of visitors and of silence."""

import asyncio

import numpy as np
import pytest
from openrois_agents.pipecat.input_transport import VisitorInputTransport
from openrois_agents.voice.visitor_sound import VisitorBlock, VisitorSound
from openrois_media import Media
from pipecat.frames.frames import EndFrame, UserAudioRawFrame
from pipecat.pipeline.pipeline import Pipeline
from pipecat.pipeline.worker import PipelineWorker
from pipecat.transports.base_transport import TransportParams
from pipecat.workers.runner import WorkerRunner

from openrois.client import Client
from openrois.types.codes import Purpose
from tests.support.pipecat_services import Downstream

pytestmark = [pytest.mark.agents, pytest.mark.extra(name="pipecat")]


async def test_sound_comes_with_its_visitor_and_each_change_is_told() -> None:
    client = Client("ws://127.0.0.1:9/")
    sound = VisitorSound(client, Media(client), "avatar", purposes=[Purpose.AGENT])
    visitors = ["vito", "vito", "", "", "ann"]
    sound._blocks.extend(VisitorBlock(each, np.full(320, len(each), np.int16)) for each in visitors)
    changes: list[str] = []

    async def note_change(visitor_ref: str) -> None:
        changes.append(visitor_ref)

    params = TransportParams(audio_in_enabled=True, audio_in_sample_rate=sound.rate)
    transport = VisitorInputTransport(sound, params, note_change)
    told = Downstream(transport)
    worker = PipelineWorker(Pipeline([transport]), enable_rtvi=False, observers=[told])
    runner = WorkerRunner(handle_sigint=False)
    await runner.add_workers(worker)
    running = asyncio.create_task(runner.run())

    def heard() -> list[UserAudioRawFrame]:
        return [each for each in told.frames if isinstance(each, UserAudioRawFrame)]

    await told.until(lambda: len(heard()) == len(visitors))
    assert [each.user_id for each in heard()] == visitors
    assert {(each.sample_rate, each.num_channels, each.num_frames) for each in heard()} == {(16_000, 1, 320)}
    assert [set(np.frombuffer(each.audio, np.int16)) for each in heard()] == [{len(each)} for each in visitors]
    assert changes == ["vito", "", "ann"]
    await worker.queue_frame(EndFrame())
    await running
    # Nothing is read any more.
    sound._blocks.append(VisitorBlock("late", np.zeros(320, np.int16)))
    assert len(sound._blocks) == 1
