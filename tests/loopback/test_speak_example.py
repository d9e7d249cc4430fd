"""The example that speaks a file, and the pieces of its guide, as they are written."""

import asyncio
import sys
import wave
from pathlib import Path

import numpy as np
import pytest

from tests.support.loopback import PATIENCE
from tests.support.operated import operated_avatar

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs/examples/speak.py"


@pytest.mark.media
async def test_it_speaks_a_file_and_says_what_was_heard(tmp_path: Path) -> None:
    path = tmp_path / "beep.wav"
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(16_000)
        file.writeframes(np.rint(np.sin(np.arange(24_000) / 8) * 9_000).astype("<i2").tobytes())
    async with operated_avatar(tmp_path) as (running, _):
        pipe = asyncio.subprocess.PIPE
        process = await asyncio.create_subprocess_exec(
            sys.executable, EXAMPLE, path, running.url.replace("http", "ws"), stdout=pipe, stderr=pipe
        )
        async with asyncio.timeout(PATIENCE):
            out, err = await process.communicate()
    assert (process.returncode, err, out) == (0, b"", b"1.5 s were heard\n")


def test_the_guide_shows_it_as_it_is() -> None:
    guide = (ROOT / "docs/how-to/avatar.md").read_text(encoding="utf-8")
    assert EXAMPLE.read_text(encoding="utf-8") in guide
