"""F37 to F40: viewers whose network changes, who reach no relay, whose UDP is blocked, and who die."""

import signal
from pathlib import Path

import pytest

from tests.support.ground import program
from tests.support.seeds import SOME
from tests.support.spectator import AUDIO, VIDEO
from tests.support.stage import stage

pytestmark = pytest.mark.media


@pytest.mark.parametrize("seed", SOME)
async def test_f40_a_viewer_that_dies_or_stands_still(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with stage(seed, tmp_path, caplog) as on:
        app = await on.spectator()
        video, audio = await app.play(VIDEO, '{"codecs": ["H264"]}'), await app.play(AUDIO)
        watch = program(
            "-m", "tests.support.spectator", on.place.gateway.url, "VP8", log=tmp_path / "viewer.log", prints=True
        )
        async with watch as viewer:
            assert viewer.first == "picture", viewer.log()
            assert on.encoders() == {"video/H264", "video/VP8", "audio/opus"}
            viewer.signal((signal.SIGKILL, signal.SIGSTOP)[seed % 2])
            await on.until(lambda: on.encoders() == {"video/H264", "audio/opus"})
            assert await on.sessions() == 1
            await app.sees(video)
        assert app.told == {stream_id: ["NOT_RUNNING", "RUNNING"] for stream_id in (video, audio)}
        assert app.byes == app.errors == []


@pytest.mark.parametrize("seed", SOME)
async def test_f37_a_network_that_changes_under_a_viewer(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with stage(seed, tmp_path, caplog) as on:
        app = await on.spectator()
        app.path = first = await on.path()
        assert await app.bind("avatar/Operator") in ("OK", "UNSUPPORTED", "BAD_PARAMETER")
        video, audio = await app.play(VIDEO), await app.play(AUDIO)
        for way in (first.down, first.up):
            way.change(loss=1.0)
        app.path = await on.path()
        await app.sees(video, 0)
        (peer_id,) = app.connections
        assert await app.code("signaling.restart", peer_id=peer_id) == "OK"
        await app.sees(video)
        await app.sees(audio)
        for stream_id in (video, audio):
            await app.is_now(stream_id, "RUNNING")
            assert "NOT_CONNECTED" not in app.told[stream_id]
        await app.until(lambda: app.byes == ["it was replaced"])
