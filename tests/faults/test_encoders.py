"""F33: encoders that fail, cannot be made, and are given pictures of another size."""

import signal
from pathlib import Path
from typing import Any

import pytest
from openrois_streaming.publish.video_encoder import VideoEncoder

from tests.support.seeds import lasting
from tests.support.spectator import AUDIO, VIDEO
from tests.support.stage import SMALL_GAME, stage

pytestmark = pytest.mark.media

CODECS = ['{"codecs": ["H264"]}', '{"codecs": ["VP8"]}']


class Broken:
    """Has encoders fail while it is on."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.encoding = self.making = False
        self.codecs = {"video/H264", "video/VP8"}
        self.failures = 0
        init, encode = VideoEncoder.__init__, VideoEncoder.encode

        def made(one: VideoEncoder, mime_type: str, **options: Any) -> None:
            self._fail(self.making and mime_type in self.codecs, "there is no memory for an encoder")
            init(one, mime_type, **options)

        def encoded(one: VideoEncoder, *arguments: Any, **options: Any) -> Any:
            self._fail(self.encoding and one._mime_type in self.codecs, "the encoder cannot go on")
            return encode(one, *arguments, **options)

        patch.setattr(VideoEncoder, "__init__", made)
        patch.setattr(VideoEncoder, "encode", encoded)

    def _fail(self, now: bool, words: str) -> None:
        if now:
            self.failures += 1
            raise MemoryError(words)


@pytest.mark.parametrize("seed", lasting(0))
async def test_f33_an_encoder_that_fails_or_cannot_be_made(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with stage(seed, tmp_path, caplog) as on:
        chance, broken = on.place.chance, Broken(monkeypatch)
        app, other = await on.spectator(), await on.spectator()
        video, audio = await app.play(VIDEO, CODECS[seed % 2]), await app.play(AUDIO)
        others = await other.play(VIDEO, chance.choice(CODECS))
        await app.sees(video, chance.randrange(1, 10))
        broken.encoding = True
        broken.making = chance.random() < 0.5
        await app.error("COMPONENT_INTERNAL_ERROR")
        assert await app.becomes(VIDEO, "READY", "ERROR") == "ERROR"
        await app.is_now(video, "NOT_RUNNING")
        # Sound has an encoder of its own.
        await app.sees(audio)
        assert app.told[audio] == ["NOT_RUNNING", "RUNNING"]
        broken.encoding = broken.making = False
        await app.sees(video)
        await other.sees(others)
        await app.is_now(video, "RUNNING")
        assert await app.becomes(VIDEO, "READY") == "READY"
        assert app.byes == other.byes == []
        assert broken.failures > 1


@pytest.mark.parametrize("seed", lasting(0))
async def test_f33_where_no_encoder_of_a_codec_can_be_made_another_codec_is_played(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with stage(seed, tmp_path, caplog) as on:
        broken = Broken(monkeypatch)
        broken.codecs = {"video/H264"}
        broken.making = seed % 2 == 0
        app = await on.spectator()
        video = await app.connect(VIDEO, '{"codecs": ["VP8", "H264"]}')
        audio = await app.play(AUDIO)
        if not broken.making:
            await app.sees(video, on.place.chance.randrange(1, 10))
            assert on.encoders() == {"video/H264", "audio/opus"}
            broken.making = broken.encoding = True
        await app.until(lambda: app.byes == ["it was replaced"])
        await app.sees(video)
        await app.is_now(video, "RUNNING")
        assert on.encoders() == {"video/VP8", "audio/opus"}
        assert "NOT_CONNECTED" not in app.told[video] + app.told[audio]
        assert await app.becomes(VIDEO, "READY") == "READY"
        # The next viewer does not wait for what fails, and does not ask for it either.
        other = await on.spectator()
        others = await other.play(VIDEO, '{"codecs": ["VP8", "H264"]}')
        await other.sees(others)
        assert other.byes == []


@pytest.mark.parametrize("seed", lasting(0))
async def test_f33_pictures_of_another_and_an_odd_size(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with stage(seed, tmp_path, caplog, game=SMALL_GAME) as on:
        app = await on.spectator()
        video = await app.play(VIDEO, CODECS[seed % 2])
        for _ in range(4):
            on.engine().send_signal(signal.SIGUSR2)
            await app.sees(video, on.place.chance.randrange(5, 15))
        assert app.told[video] == ["NOT_RUNNING", "RUNNING"]
        assert len(app.sizes[video]) > 1
        assert app.errors == []
        assert app.byes == []
