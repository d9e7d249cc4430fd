"""Charts say what was measured, and those of the pages are of the results that are kept."""

import json
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.charts import congestion, fanout, latency
from benchmarks.charts.__main__ import CHARTS, ROOT
from benchmarks.charts.svg import Drawing, spread, ticks

CONDITIONS = {"cpus": 2, "processor": "A & B", "load_before": 0.3, "load_after": 0.8}


def texts(svg: str) -> list[str]:
    return [element.text or "" for element in ET.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]


@given(st.floats(1e-3, 1e6))
def test_ticks_reach_far_enough_and_are_few(highest: float) -> None:
    found = ticks(highest)
    assert found[0] == 0
    assert found[-1] >= highest * (1 - 1e-6)
    assert len(found) <= 7
    assert found[-1] <= 2.6 * highest


def test_labels_make_room_for_each_other() -> None:
    assert spread([10, 12, 100], 20) == [10, 30, 100]
    assert spread([], 20) == []


def test_a_drawing_is_xml_whatever_is_in_it() -> None:
    drawing = Drawing(10, 10, 'a "label" <of> & such')
    drawing.text(1, 2, "<b> & c")
    assert texts(str(drawing)) == ["<b> & c"]


def test_the_fan_out() -> None:
    runs = [{"kind": kind, "viewers": n, "cpu": 0.01 * n} for kind in ("ours", "aiortc") for n in (1, 16)]
    told: dict[str, Any] = {"conditions": CONDITIONS, "runs": runs, "marginal": {"ours": 10.0, "aiortc": 10.0}}
    words = texts(fanout.draw(told))
    assert "OpenRoIS" in words
    assert "10.0 thousandths of a core each" in words
    assert "Janus" not in words
    assert "2 CPUs (A & B), load 0.3 before and 0.8 after" in words


def test_latency() -> None:
    row = {
        "height": 720,
        "fps": 60,
        "viewer": "sink",
        "measure": "decoded",
        "way": "openrois",
        "median": 6,
        "p95": 12.34,
    }
    words = texts(latency.draw({"conditions": CONDITIONS, "summary": [row]}))
    assert "OpenRoIS, 720p60" in words
    assert "6.0 / 12.3" in words
    assert not any("Chromium" in line for line in words)


def test_congestion() -> None:
    seen = {
        "slow": {"fps": 29.5, "delay": {"p50": 0.06, "p95": 0.11}},
        "fast 0": {"fps": 30.0, "delay": {"p50": 0.01, "p95": 0.02}},
    }
    nothing = {"slow": {"fps": 0.0, "delay": None}}
    results = [
        {"loss": 0.05, "way": "openrois", "seen": seen},
        {"loss": 0.05, "way": "aiortc", "seen": nothing},
    ]
    words = texts(congestion.draw({"conditions": CONDITIONS, "results": results}))
    assert words.count("OpenRoIS, the slow one, 5% loss") == 2
    assert words.count("aiortc, the slow one alone, 5% loss") == 1, "without pictures there is no delay"
    assert "29.5" in words
    assert "60.0 / 110" in words
    assert not any("fast ones alone" in line for line in words)


@pytest.mark.parametrize("chart", CHARTS)
def test_a_chart_of_the_pages_is_of_the_result_that_is_kept(chart: str) -> None:
    result, draw = CHARTS[chart]
    assert (ROOT / chart).is_file() == (ROOT / result).is_file()
    if (ROOT / result).is_file():
        assert (ROOT / chart).read_text() == draw(json.loads((ROOT / result).read_text()))
