"""The example of the guide, as it is written."""

import asyncio
import re
import sys
from pathlib import Path

import pytest

from tests.support.loopback import PATIENCE
from tests.support.media_body import body

EXAMPLE = Path(__file__).parents[3] / "docs/examples/watch.py"


@pytest.mark.media
async def test_it_tells_what_it_sees_and_hears() -> None:
    async with body() as robot:
        pipe = asyncio.subprocess.PIPE
        process = await asyncio.create_subprocess_exec(
            sys.executable, EXAMPLE, "2", robot.url, stdout=pipe, stderr=pipe
        )
        async with asyncio.timeout(PATIENCE):
            out, err = await process.communicate()
    assert (process.returncode, err) == (0, b"")
    lines = out.decode().splitlines()
    assert len(lines) == 2
    for line in lines:
        found = re.fullmatch(r"brightness (\d+)%, loudness (\d+)%, seen -?\d+ ms ago", line)
        assert found is not None, line
        assert all(0 < int(each) < 100 for each in found.groups())
