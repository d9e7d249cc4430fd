from openrois_avatar.bench.fanout_report import FanoutReport
from openrois_avatar.bench.latency_report import LatencyReport

from tests.support.bench import fanout, latency, observation


def test_latency_as_text_has_a_line_for_each_measure() -> None:
    told = str(latency(observation("sink", connect=(90.0, 80.0), decoded=(41.0, 42.0, 43.0)))).splitlines()
    assert told[0] == "gateway, adapter and viewers as processes of their own; 0.5 s and 2 runs each"
    assert told[4:7] == [
        "viewer      pictures  milliseconds                     median   p95  of",
        "sink    640x360 H264  capture -> decoded                 42.0  43.0   3",
        "sink    640x360 H264  connect_stream -> first picture    85.0  90.0   2",
    ]
    assert "sink 640x360: 3 pictures seen, 1 missed, 0 without a readable stamp." in told


def test_latency_says_what_the_viewers_are_and_when_there_is_no_browser() -> None:
    without = str(latency(observation("sink", decoded=(41.0,))))
    assert "sink: a viewer without a screen" in without
    assert without.endswith("Chromium is not installed, so there are no figures of a browser.")
    both = latency(observation("sink", decoded=(41.0,)), observation("Chromium", presented=(30.0,)))
    assert str(both).endswith("Chromium: presented is when the browser expects the picture on the screen.")


def test_latency_as_json_is_the_whole_report() -> None:
    report = latency(observation("sink", decoded=(41.0, 42.0)))
    assert LatencyReport.model_validate_json(report.model_dump_json()) == report
    told = report.model_dump(mode="json")
    assert told["bench"] == "latency"
    assert told["observations"][0]["milliseconds"] == {
        "decoded": {"count": 2, "median": 41.5, "p95": 42.0, "values": [41.0, 42.0]}
    }


def test_fanout_as_text_has_a_line_for_each_comparison() -> None:
    told = str(fanout(delivered=True)).splitlines()
    assert told[4:6] == [
        "codec  viewers  OpenRoIS CPU  aiortc CPU  ratio      fps  encoders",
        "VP8          2         0.100       0.400   0.25  30 / 30     1 / 2",
    ]
    assert "*" not in str(fanout(delivered=True))


def test_fanout_marks_what_was_not_delivered() -> None:
    told = str(fanout(delivered=False)).splitlines()
    assert told[5] == "VP8          2         0.100      0.400*      -  30 / 3     1 / 2"
    assert told[-1].startswith("* in some round")


def test_fanout_says_how_busy_others_were_where_that_can_be_told() -> None:
    assert "other programs" not in str(fanout(delivered=True))
    told = str(fanout(delivered=True, others=0.254)).splitlines()
    assert told[-1] == "Meanwhile other programs used 0.25 cores, 0.25 at most."


def test_fanout_as_json_is_the_whole_report() -> None:
    report = fanout(delivered=False)
    assert FanoutReport.model_validate_json(report.model_dump_json()) == report
    told = report.model_dump(mode="json")
    assert told["comparisons"][0]["ratio"] is None
    assert [run["delivered"] for run in told["runs"]] == [True, False]
