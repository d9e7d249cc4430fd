"""Charts say what was measured, and those of the pages are of the results that are kept."""

import json
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_bench.charts import congestion, latency
from openrois_bench.charts.__main__ import CHARTS
from openrois_bench.charts.svg import Drawing, ticks

from tests.support.packages import ROOT

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


def test_a_drawing_is_xml_whatever_is_in_it() -> None:
    drawing = Drawing(10, 10, 'a "label" <of> & such')
    drawing.text(1, 2, "<b> & c")
    assert texts(str(drawing)) == ["<b> & c"]


def test_latency() -> None:
    row = {
        "height": 720,
        "fps": 60,
        "viewer": "sink",
        "measure": "decoded",
        "way": "openrois",
        "p50": 6,
        "p95": 12.34,
    }
    words = texts(latency.draw({"conditions": CONDITIONS, "summary": [row]}))
    assert "OpenRoIS, 720p60" in words
    assert "6.0 / 12.3" in words
    assert not any("Chromium" in line for line in words)


def test_congestion() -> None:
    def row(way: str, viewers: str, fps: float, p50: float, p95: float) -> dict[str, Any]:
        return {"loss": 0.05, "way": way, "viewers": viewers, "fps": fps, "p50_ms": p50, "p95_ms": p95}

    summary = [
        row("openrois", "slow", 29.5, 60.0, 110.0),
        row("openrois", "fast", 30.0, 10.0, 20.0),
        row("aiortc", "slow", 0.0, 10_000.0, 10_000.0),
    ]
    words = texts(congestion.draw({"conditions": CONDITIONS, "summary": summary}))
    assert words.count("OpenRoIS, the slow one, 5% loss") == 2
    assert words.count("aiortc, the slow one alone, 5% loss") == 1, "without pictures there is no delay"
    assert "29.5" in words
    assert "60.0 / 110" in words
    assert not any("fast ones alone" in line for line in words)


@pytest.mark.parametrize("chart", CHARTS)
def test_a_chart_of_the_pages_is_of_the_result_that_is_kept(chart: str) -> None:
    result, draw = CHARTS[chart]
    assert (ROOT / chart).read_text() == draw(json.loads((ROOT / result).read_text()))
