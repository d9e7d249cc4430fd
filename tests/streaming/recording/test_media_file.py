"""Files of pictures and sound."""

from pathlib import Path

import numpy as np
import pytest
from openrois_streaming.recording.media_file import CONTAINERS, MediaFile, UnknownEnding, has_pictures
from openrois_streaming.source import stamp
from openrois_streaming.source.source import RawAudio, RawVideo

from tests.support.recordings import onsets, read_back

START = 500.0
CODECS = {
    ".mp4": {"video": "h264", "audio": "aac"},
    ".webm": {"video": "vp8", "audio": "opus"},
    ".wav": {"audio": "pcm_s16le"},
}


def picture(number: int, at: float, width: int = 320, height: int = 180) -> RawVideo:
    data = np.full((height * 3 // 2, width), 128, np.uint8)
    stamp.write(data[:height], number, at)
    return RawVideo(data, "i420", width, height, number, START + at)


def block(at: float, *, loud: bool = False, samples: int = 480) -> RawAudio:
    wave = 12_000 * np.sin(2 * np.pi * 1000 / 48_000 * np.arange(samples)) if loud else np.zeros(samples)
    return RawAudio(np.repeat(wave.astype(np.int16)[:, np.newaxis], 2, axis=1), START + at)


@pytest.mark.parametrize("ending", CONTAINERS)
def test_pictures_and_sound_stand_where_they_were_captured(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"file{ending}"
    video = has_pictures(path)
    with MediaFile(path, video=video, audio=True) as file:
        for number in range(60 if video else 0):
            file.add_picture(picture(number, number / 30))
        for hundredth in range(200):
            file.add_sound(block(hundredth / 100, loud=100 <= hundredth < 110))
        assert not path.exists()
    recorded = read_back(path)
    assert recorded.codecs == CODECS[ending]
    assert recorded.seconds == pytest.approx(2, abs=0.1)
    assert list(tmp_path.iterdir()) == [path]
    assert onsets(recorded.sound) == [pytest.approx(1.0, abs=0.02)]
    assert len(recorded.pictures) == (60 if video else 0)
    for shown_at, size, shown in recorded.pictures:
        assert size == (320, 180)
        assert shown is not None
        assert shown.number / 30 == pytest.approx(shown_at, abs=0.002)


def test_missing_pictures_and_sound_leave_a_gap(tmp_path: Path) -> None:
    path = tmp_path / "file.mp4"
    with MediaFile(path, video=True, audio=True) as file:
        file.add_sound(block(-0.01, loud=True))  # before the first picture
        for number in (0, 1, 2, 60, 61, 61, 30):
            file.add_picture(picture(number, number / 30))
        for hundredth in (*range(10), *range(100, 120)):
            file.add_sound(block(hundredth / 100, loud=hundredth >= 100))
        assert file.seconds == pytest.approx(61 / 30, abs=0.01)
    recorded = read_back(path)
    numbers = [shown.number for _, _, shown in recorded.pictures if shown is not None]
    assert numbers == [0, 1, 2, 60, 61]
    assert onsets(recorded.sound) == [pytest.approx(1.0, abs=0.02)]


def test_sound_that_comes_twice_is_there_once(tmp_path: Path) -> None:
    path = tmp_path / "file.wav"
    with MediaFile(path, video=False, audio=True) as file:
        for at in (0.0, 0.1, 0.05, 0.2):
            file.add_sound(block(at, samples=4800))
    assert read_back(path).seconds == pytest.approx(0.3, abs=0.001)


def test_later_pictures_are_scaled_to_the_first(tmp_path: Path) -> None:
    path = tmp_path / "file.webm"
    with MediaFile(path, video=True, audio=False) as file:
        file.add_picture(picture(0, 0.0))
        file.add_picture(picture(1, 0.1, 640, 360))
    assert [size for _, size, _ in read_back(path).pictures] == [(320, 180)] * 2


def test_a_file_that_got_nothing_is_not_there(tmp_path: Path) -> None:
    with MediaFile(tmp_path / "file.mp4", video=True, audio=True) as file:
        file.add_sound(block(0.0))
    file.add_picture(picture(0, 0.0))
    file.add_sound(block(0.0))
    assert list(tmp_path.iterdir()) == []


def test_a_file_of_a_failed_recording_holds_what_came(tmp_path: Path) -> None:
    path = tmp_path / "file.wav"
    failure = OSError("the cable is out")

    def record() -> None:
        with MediaFile(path, video=False, audio=True) as file:
            file.add_sound(block(0.0, samples=48_000))
            raise failure

    with pytest.raises(OSError, match="the cable is out"):
        record()
    assert read_back(path).seconds == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["film.avi", "film", "film.mp3"])
def test_other_endings_are_refused_by_name(name: str) -> None:
    with pytest.raises(UnknownEnding, match=r"use one of \.mp4, \.webm, \.wav"):
        has_pictures(Path(name))


def test_what_a_file_cannot_hold(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"a \.wav file holds sound alone"):
        MediaFile(tmp_path / "file.wav", video=True, audio=True)
    with pytest.raises(ValueError, match="nothing to record"):
        MediaFile(tmp_path / "file.mp4", video=False, audio=False)
