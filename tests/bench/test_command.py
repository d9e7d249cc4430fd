import asyncio
import json
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from openrois_bench import command
from openrois_bench.errors import BenchFailed
from openrois_bench.faults.stop import StopSettings
from openrois_bench.faults.stop_report import Load, StopReport
from openrois_bench.options import INTERRUPTED
from openrois_bench.streams.fanout.bench import FanoutSettings
from openrois_bench.streams.fanout.report import FanoutReport
from openrois_bench.streams.latency.bench import LatencySettings
from openrois_bench.streams.latency.report import LatencyReport

from tests.support.bench import fanout, latency, observation, stop, stop_run

Progress = Callable[[str], None]


class Benches:
    """Benches that take no time, and the settings they were run with."""

    def __init__(self) -> None:
        self.asked: list[LatencySettings | FanoutSettings | StopSettings] = []

    async def latency(self, settings: LatencySettings, progress: Progress) -> LatencyReport:
        progress("640x360: sink")
        self.asked.append(settings)
        return latency(observation("sink", decoded=(41.0,)))

    async def fanout(self, settings: FanoutSettings, progress: Progress) -> FanoutReport:
        self.asked.append(settings)
        return fanout(delivered=True)

    async def stop(self, settings: StopSettings, progress: Progress) -> StopReport:
        self.asked.append(settings)
        return stop(stop_run(Load(name="idle")))


@pytest.fixture
def benches(monkeypatch: pytest.MonkeyPatch) -> Benches:
    benches = Benches()
    monkeypatch.setattr(command, "run_latency", benches.latency)
    monkeypatch.setattr(command, "run_fanout", benches.fanout)
    monkeypatch.setattr(command, "run_stop", benches.stop)
    monkeypatch.setattr(command, "find_chromium", lambda: "/the/browser")
    return benches


def test_the_report_is_printed_and_progress_stands_beside_it(
    benches: Benches, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command.main(["latency"]) == 0
    printed = capsys.readouterr()
    assert "capture -> decoded" in printed.out
    assert printed.err == "openrois bench: 640x360: sink\n"
    assert benches.asked == [LatencySettings(chromium="/the/browser")]


def test_options_say_how_long_and_how_often(benches: Benches) -> None:
    assert command.main(["latency", "--seconds", "1.5", "--runs", "2"]) == 0
    assert command.main(["fanout", "--seconds", "0.5", "--rounds", "4"]) == 0
    assert command.main(["stop", "--engine", "synthetic", "--seconds", "2", "--dead-man", "1"]) == 0
    assert benches.asked == [
        LatencySettings(seconds=1.5, runs=2, chromium="/the/browser"),
        FanoutSettings(seconds=0.5, rounds=4),
        StopSettings(seconds=2, dead_man=1),
    ]


@pytest.mark.parametrize("bench", ["latency", "fanout", "stop"])
def test_everything_is_written_as_json(benches: Benches, tmp_path: Path, bench: str) -> None:
    file = tmp_path / "figures.json"
    assert command.main([bench, "--json", str(file)]) == 0
    assert json.loads(file.read_text())["bench"] == bench
    assert len(benches.asked) == 1


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["unknown"],
        ["latency", "--seconds", "0"],
        ["latency", "--runs", "1.5"],
        ["latency", "--runs", "1001"],
        ["fanout", "--rounds", "-1"],
        ["stop", "--dead-man", "0"],
        ["fanout", "--seconds", "nan"],
        ["fanout", "--json", "/nowhere/at/all"],
        ["fanout", "--json", "/"],
    ],
)
def test_wrong_usage_measures_nothing(benches: Benches, arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        command.main(arguments)
    assert ended.value.code == 2
    assert benches.asked == []


def test_a_bench_that_fails_says_why_and_leaves_no_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    async def fail(_settings: FanoutSettings, _progress: Progress) -> FanoutReport:
        raise BenchFailed("the gateway does not start")

    monkeypatch.setattr(command, "run_fanout", fail)
    assert command.main(["fanout", "--json", str(tmp_path / "figures.json")]) == 1
    assert capsys.readouterr().err == "openrois bench: the gateway does not start\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_it_in_good_order(monkeypatch: pytest.MonkeyPatch, number: signal.Signals) -> None:
    ended = []

    async def wait(_settings: FanoutSettings, _progress: Progress) -> FanoutReport:
        os.kill(os.getpid(), number)
        try:
            await asyncio.Event().wait()
        finally:
            ended.append("cleaned up")
        raise AssertionError("an interrupted bench has no figures")

    monkeypatch.setattr(command, "run_fanout", wait)
    assert command.main(["fanout"]) == INTERRUPTED
    assert ended == ["cleaned up"]
