"""The plugin in another project."""

import subprocess
import sys
from pathlib import Path

import pytest
from openrois_streaming.source.source import RawAudio, RawVideo
from openrois_streaming.testing import Impairments
from openrois_streaming.testing.plugin import MakePath, MakeSink, MakeSource

pytestmark = pytest.mark.extra(name="streaming")

FAILING = """
import asyncio

def test_all_is_well(measuring_sink):
    assert str(measuring_sink())

def test_something_fails(measuring_sink, impaired_path):
    path = impaired_path()
    measuring_sink(path=path)
    asyncio.run(use(path))
    assert False, "on purpose"

async def use(path):
    async with path:
        path.down.push(b"four")
"""


def test_the_figures_stand_in_the_report_of_a_test_that_fails(tmp_path: Path) -> None:
    (tmp_path / "test_failing.py").write_text(FAILING)
    (tmp_path / "conftest.py").write_text('pytest_plugins = ["openrois_streaming.testing.plugin"]\n')
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "."],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 1, ran.stdout + ran.stderr
    assert "1 failed, 1 passed" in ran.stdout
    assert ran.stdout.count("measuring sink") == 1
    assert "entered_bytes=4" in ran.stdout


def test_it_is_light_to_import() -> None:
    heavy = "{'aiortc', 'av', 'numpy', 'cv2', 'asyncio'}"
    code = f"import sys, openrois_streaming.testing.plugin; sys.exit(bool({heavy} & (sys.modules.keys() - before)))"
    code = f"import sys, pytest; before = set(sys.modules); {code}"
    subprocess.run([sys.executable, "-c", code], check=True)


async def test_sources(synthetic_source: MakeSource) -> None:
    for source, kind in (
        (synthetic_source(), RawVideo),
        (synthetic_source("head", 160, 90, fps=60), RawVideo),
        (synthetic_source("tone", channels=2), RawAudio),
    ):
        async with source.open() as frames:
            assert isinstance(await anext(frames), kind)


async def test_a_path_does_the_same_each_time(impaired_path: MakePath) -> None:
    lost = []
    for _ in range(2):
        async with impaired_path(Impairments(loss=0.5)) as path:
            for _ in range(100):
                path.down.push(b"x")
            lost.append(path.down.figures())
    assert lost[0] == lost[1]
    assert 0 < lost[0].lost < 100


def test_unused_sink_reports_no_offer(measuring_sink: MakeSink) -> None:
    assert "no offer was answered" in str(measuring_sink())
