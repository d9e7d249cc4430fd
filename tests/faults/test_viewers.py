"""F37 to F40: viewers whose network changes, without a relay, with blocked UDP, and that die."""

import signal
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any

import pytest
from openrois_streaming.network.settings import NetworkSettings

from tests.support.demo import free_port
from tests.support.ground import Child, program
from tests.support.namespaces import Namespace, namespace
from tests.support.seeds import lasting
from tests.support.spectator import AUDIO, VIDEO
from tests.support.stage import Stage, stage
from tests.support.turn import coturn

pytestmark = pytest.mark.media


@pytest.mark.parametrize("seed", lasting(0))
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
        # On a busy machine the start of the viewer's process may hold it up for a second; its streams never end.
        for stream_id in (video, audio):
            await app.is_now(stream_id, "RUNNING")
            assert "NOT_CONNECTED" not in app.told[stream_id]
        assert app.byes == app.errors == []


@pytest.mark.parametrize("seed", lasting(0))
async def test_f37_a_network_that_changes_under_a_viewer(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with stage(seed, tmp_path, caplog) as on:
        app = await on.spectator()
        app.path = first = await on.path()
        video, audio = await app.play(VIDEO), await app.play(AUDIO)
        await app.sees(video, on.place.chance.randrange(1, 10))
        for way in (first.down, first.up):
            way.change(loss=1.0)
        app.path = await on.path()
        (peer_id,) = app.connections
        assert await app.code("signaling.restart", peer_id=peer_id) == "OK"
        await app.sees(video)
        await app.sees(audio)
        for stream_id in (video, audio):
            await app.is_now(stream_id, "RUNNING")
            assert "NOT_CONNECTED" not in app.told[stream_id]
        await app.until(lambda: app.byes == ["it was replaced"])
        assert await app.becomes(VIDEO, "READY") == "READY"


def away(on: Stage, home: Namespace, path: Path, log: Path) -> AbstractAsyncContextManager[Child]:
    """Watch from a network namespace, in which the gateway is reached in another way than media."""
    arguments = ("-m", "tests.support.spectator", on.place.gateway.url, "H264", str(path))
    return program(*arguments, log=log / "viewer.log", prints=True, prefix=home.prefix)


@pytest.mark.usefixtures("namespaces")
@pytest.mark.parametrize("seed", lasting(0))
async def test_f37_a_viewer_that_gets_another_address(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with namespace() as home:
        network = NetworkSettings(interfaces=(home.here,))
        async with (
            stage(seed, tmp_path, caplog, network=network) as on,
            on.doorway() as path,
            away(on, home, path, tmp_path) as viewer,
        ):
            assert viewer.first == "picture", viewer.log()
            home.move()
            while (said := await viewer.line()) == "picture":
                pass
            # Until there is another way the old one may be given up; the stream goes on.
            assert said in ("it was replaced", "the viewer is gone")
            while (said := await viewer.line()) != "picture":
                assert said == "it was replaced"
            viewer.signal(signal.SIGKILL)


@pytest.mark.usefixtures("turnserver")
@pytest.mark.parametrize("seed", lasting(1))
async def test_f38_a_relay_that_is_not_there_and_one_that_dies(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    transport = ("udp", "tcp")[seed % 2]
    async with coturn(tmp_path) as turn:
        relays = (f"turn:127.0.0.1:{free_port()}?transport={transport}", turn.url(transport))
        network = NetworkSettings(relay_only=True)
        async with stage(seed, tmp_path, caplog, network=network, turn=relays, turn_secret=turn.secret) as on:
            app = await on.spectator()
            video = await app.play(VIDEO)
            await app.sees(video, on.place.chance.randrange(1, 20))
            turn.process.kill()
            await app.is_now(video, "NOT_CONNECTED")
            gone = {"udp": "the viewer is gone", "tcp": "the media path to the application was lost"}
            assert app.byes.pop() == gone[transport]
            video = await app.connect(VIDEO)
            await app.is_now(video, "NOT_CONNECTED")
            words = {"udp": "the TURN server does not answer", "tcp": "the TURN server cannot be reached"}
            assert app.byes == [f"the engine is set to relays only and got none: {words[transport]}"]


@pytest.mark.usefixtures("namespaces", "turnserver")
@pytest.mark.parametrize("seed", lasting(1))
async def test_f39_a_viewer_without_udp(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with namespace() as home:
        home.block_udp()
        network = NetworkSettings(interfaces=(home.here,))
        async with coturn(tmp_path, address=home.here) as turn:
            relays: dict[str, Any] = {"turn": (turn.url("tcp"),), "turn_secret": turn.secret} if seed % 2 else {}
            async with (
                stage(seed, tmp_path, caplog, network=network, **relays) as on,
                on.doorway() as path,
                away(on, home, path, tmp_path) as viewer,
            ):
                if relays:
                    assert viewer.first == "picture", viewer.log()
                else:
                    assert viewer.first == "no media path to the application was found", viewer.log()
                viewer.signal(signal.SIGKILL)
