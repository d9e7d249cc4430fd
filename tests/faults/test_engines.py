"""F30 to F32: game engines that say nonsense, stand still, and die."""

import signal
from pathlib import Path

import pytest

from tests.support.seeds import lasting
from tests.support.spectator import AUDIO, VIDEO, Spectator
from tests.support.stage import SMALL_GAME, Stage, stage

pytestmark = [pytest.mark.media, pytest.mark.timeout(400)]


async def watching(on: Stage) -> tuple[Spectator, str, str]:
    """Let one application watch and listen, until the engine has run for a moment."""
    app = await on.spectator()
    video, audio = await app.play(VIDEO), await app.play(AUDIO)
    await app.sees(video, on.place.chance.randrange(1, 10))
    return app, video, audio


async def back(on: Stage, app: Spectator, *streams: str) -> None:
    """Check that it works again, over the peer connection that there was, and under the ids that there were."""
    assert await app.becomes(VIDEO, "READY", within=60) == "READY"
    for stream_id in streams:
        await app.sees(stream_id)
        await app.is_now(stream_id, "RUNNING")
        assert "NOT_CONNECTED" not in app.told[stream_id]
    assert app.byes == []
    assert len(app.connections) == 1


@pytest.mark.parametrize("seed", lasting(0))
@pytest.mark.parametrize("harm", [signal.SIGUSR1, signal.SIGKILL], ids=["f30_nonsense", "f32_death"])
async def test_f30_f32_an_engine_that_is_lost_is_started_again(
    harm: signal.Signals, seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with stage(seed, tmp_path, caplog, game=SMALL_GAME) as on:
        app, *streams = await watching(on)
        first = on.engine()
        first.send_signal(harm)
        await app.error("COMPONENT_INTERNAL_ERROR")
        await back(on, app, *streams)
        assert on.engine().pid != first.pid


@pytest.mark.parametrize("seed", lasting(0))
async def test_f31_an_engine_that_stands_still(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with stage(seed, tmp_path, caplog, game=SMALL_GAME) as on:
        app, video, audio = await watching(on)
        first = on.engine()
        if on.place.chance.random() < 0.5:
            first.send_signal(signal.SIGSTOP)
            await app.is_now(video, "NOT_RUNNING")
            assert await app.becomes(VIDEO, "WARNING", "ERROR") == "WARNING"
            first.send_signal(signal.SIGCONT)
            await back(on, app, video, audio)
            assert app.errors == []
            assert on.engine().pid == first.pid
        first.send_signal(signal.SIGSTOP)
        await app.is_now(video, "NOT_RUNNING")
        # Speech has a voice of its own: silence is sent where the engine's sound would be.
        await app.sees(audio)
        await app.error("COMPONENT_NOT_RESPONDING", within=30)
        await back(on, app, video, audio)
        assert on.engine().pid != first.pid
