import os
import platform
from importlib.metadata import version
from pathlib import Path

import pytest
from openrois_avatar.bench.conditions import Conditions, conditions, load, processor


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


def test_the_processor_is_named_as_linux_does(tmp_path: Path) -> None:
    cpuinfo = tmp_path / "cpuinfo"
    assert processor(cpuinfo) == platform.machine()
    cpuinfo.write_text("processor\t: 0\n")
    assert processor(cpuinfo) == platform.machine()
    cpuinfo.write_text("processor\t: 0\nmodel name\t: Two: Cores\n")
    assert processor(cpuinfo) == "Two: Cores"
