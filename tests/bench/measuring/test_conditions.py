import os
import platform
from importlib.metadata import version
from pathlib import Path

import pytest
from openrois_bench.measuring.conditions import Conditions, busy, conditions, load, processor


def test_the_conditions_name_machine_versions_and_load(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "getloadavg", lambda: (1.234, 9.0, 9.0))
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    assert load() == 1.23
    found = conditions(0.5, {"Chromium": "156"})
    assert (found.load_before, found.load_after, found.cpus) == (0.5, 1.23, 2)
    assert found.versions["aiortc"] == version("aiortc")
    assert found.versions["Chromium"] == "156"


def test_a_machine_that_does_not_tell_has_one_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert conditions(0.5).cpus == 1


def test_the_conditions_as_text() -> None:
    told = Conditions(
        cpus=2,
        processor="Imaginary",
        system="Linux",
        python="3.11",
        versions={"openrois": "1", "av": "2"},
        load_before=0.14,
        load_after=2.0,
    )
    assert str(told) == ("2 CPUs (Imaginary), load 0.1 before and 2.0 after\nPython 3.11, openrois 1, av 2; Linux")


def test_a_machine_is_busy_with_whatever_is_not_idling(tmp_path: Path) -> None:
    stat = tmp_path / "stat"
    assert busy(stat) is None
    stat.write_text("cpu  1000 200 30 99999 88888 4 5 600 1000 0\ncpu0 1 1 1 1 1 1 1 1 0 0\n")
    assert busy(stat) == pytest.approx(1839 / os.sysconf("SC_CLK_TCK"))


def test_the_processor_is_named_as_linux_does(tmp_path: Path) -> None:
    cpuinfo = tmp_path / "cpuinfo"
    assert processor(cpuinfo) == platform.machine()
    cpuinfo.write_text("processor\t: 0\n")
    assert processor(cpuinfo) == platform.machine()
    cpuinfo.write_text("processor\t: 0\nmodel name\t: Two: Cores\n")
    assert processor(cpuinfo) == "Two: Cores"
