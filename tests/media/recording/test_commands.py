"""`openrois record` and `openrois snapshot` as users run them: processes of their own."""

import asyncio
import io
import re
import signal
import sys
import time
from collections.abc import AsyncIterator
from pathlib import Path

import av
import pytest
from openrois_media.recording import record_command, snapshot_command

from tests.support.loopback import PATIENCE
from tests.support.media_body import CAMERA, MICROPHONE, Body, body
from tests.support.recordings import onsets, read_back

pytestmark = pytest.mark.media

RUN = "import sys; from openrois_media.recording.{0}_command import main; sys.exit(main(sys.argv[1:]))"


@pytest.fixture
async def robot() -> AsyncIterator[Body]:
    async with body() as one:
        yield one


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


async def begin(command: str, *arguments: str | Path) -> asyncio.subprocess.Process:
    pipe = asyncio.subprocess.PIPE
    return await asyncio.create_subprocess_exec(
        sys.executable, "-c", RUN.format(command), *map(str, arguments), stderr=pipe, stdout=pipe
    )


async def finish(process: asyncio.subprocess.Process) -> tuple[int, str]:
    """Return the exit status of a command, and what it said."""
    async with asyncio.timeout(PATIENCE):
        out, said = await process.communicate()
    assert out == b""
    assert process.returncode is not None
    return process.returncode, said.decode()


@pytest.mark.parametrize("ending", ["mp4", pytest.param("webm", marks=pytest.mark.long)])
async def test_a_film_is_in_sync(robot: Body, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"film.{ending}"
    status, said = await finish(await begin("record", path, "--gateway", robot.url, "--seconds", "3.5"))
    assert status == 0, said
    assert f"{path} has " in said
    assert names(tmp_path) == [path.name]
    recorded = read_back(path)
    assert recorded.seconds == pytest.approx(3.5, abs=1)
    assert len(recorded.pictures) > 30
    # A picture bears the time of day at which it was captured, and the tone has a marker at each whole second of it.
    shown_at, _, shown = recorded.pictures[-1]
    assert shown is not None
    now = time.time()
    began = now - shown.age(now) - shown_at
    clicks = onsets(recorded.sound)
    assert clicks
    for click in clicks:
        assert (began + click + 0.5) % 1 - 0.5 == pytest.approx(0, abs=0.06)


async def test_sound_alone_until_ctrl_c(robot: Body, tmp_path: Path) -> None:
    path = tmp_path / "sound.wav"
    path.write_bytes(b"old")
    process = await begin("record", path, "--gateway", robot.url, "--component", MICROPHONE, "--force")
    assert process.stderr is not None
    while b"recording" not in await process.stderr.readline():
        assert process.returncode is None
    process.send_signal(signal.SIGINT)
    assert (await finish(process))[0] == 0
    recorded = read_back(path)
    assert recorded.codecs == {"audio": "pcm_s16le"}
    assert len(recorded.sound)


async def test_a_picture(robot: Body, tmp_path: Path) -> None:
    path = tmp_path / "picture.jpg"
    status, said = await finish(await begin("snapshot", path, "--gateway", robot.url, "--body", "robot"))
    assert status == 0, said
    assert said == f"openrois snapshot: {CAMERA} into {path}\n"
    with av.open(io.BytesIO(path.read_bytes()), "r", format="mjpeg") as opened:
        assert [frame.width for frame in opened.decode(video=0)] == [320]


async def test_what_is_not_there_is_said(robot: Body, tmp_path: Path) -> None:
    for command, file in (("record", "film.mp4"), ("snapshot", "picture.jpg")):
        status, said = await finish(await begin(command, tmp_path / file, "--gateway", robot.url, "--body", "other"))
        assert status == 1
        assert "no component of other has" in said
    status, said = await finish(
        await begin("record", tmp_path / "a.wav", "--gateway", robot.url, "--component", "robot/arm")
    )
    assert (status, said) == (1, "openrois record: robot/arm is no component with sound\n")
    assert names(tmp_path) == []


@pytest.mark.parametrize(
    ("command", "arguments", "said"),
    [
        ("record", ["film.avi"], r"'\.avi' is no ending of a recording: use one of \.mp4, \.webm, \.wav"),
        ("record", ["there.mp4"], r"there\.mp4 is there already: choose another name, or overwrite it with --force"),
        ("record", ["no/film.mp4"], "there is no folder .*no: make it"),
        ("record", ["folder.mp4"], r"folder\.mp4 is a folder"),
        ("record", ["film.mp4", "--gateway", "nonsense"], "--gateway: 'nonsense' is no address"),
        ("record", ["film.mp4", "--seconds", "-1"], "must be more than 0 seconds, not -1"),
        ("record", ["film.mp4", "--seconds", "long"], "must be more than 0 seconds, not long"),
        ("snapshot", ["picture.png"], r"'picture\.png' has no ending of a snapshot: use one of \.jpg, \.jpeg"),
    ],
)
def test_mistakes(
    command: str,
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("there.mp4").touch()
    Path("folder.mp4").mkdir()
    main = {"record": record_command.main, "snapshot": snapshot_command.main}[command]
    with pytest.raises(SystemExit, match="2"):
        main(arguments)
    shown = capsys.readouterr().err
    assert re.search(said, shown)
