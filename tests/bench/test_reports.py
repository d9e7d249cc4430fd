from openrois_bench.faults.stop_report import Load, StopReport
from openrois_bench.streams.fanout.report import FanoutReport
from openrois_bench.streams.latency.report import LatencyReport

from tests.support.bench import fanout, latency, observation, stop, stop_run


def test_latency_as_text_has_a_line_for_each_measure() -> None:
    told = str(latency(observation("sink", connect=(90.0, 80.0), decoded=(41.0, 42.0, 43.0)))).splitlines()
    assert told[0] == "gateway, adapter and viewers as processes of their own; 0.5 s and 2 runs each"
    assert told[4:7] == [
        "viewer      pictures  milliseconds                     median   p95  of",
        "sink    640x360 H264  capture -> decoded                 42.0  43.0   3",
        "sink    640x360 H264  connect_stream -> first picture    80.0  90.0   2",
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
    assert told["observations"][0]["milliseconds"] == {"decoded": {"count": 2, "p50": 41.0, "p95": 42.0, "p99": 42.0}}


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


def test_fanout_reports_other_load_where_known() -> None:
    assert "other programs" not in str(fanout(delivered=True))
    told = str(fanout(delivered=True, others=0.254)).splitlines()
    assert told[-1] == "Meanwhile other programs used 0.25 cores, 0.25 at most."


def test_fanout_as_json_is_the_whole_report() -> None:
    report = fanout(delivered=False)
    assert FanoutReport.model_validate_json(report.model_dump_json()) == report
    told = report.model_dump(mode="json")
    assert told["comparisons"][0]["ratio"] is None
    assert [run["delivered"] for run in told["runs"]] == [True, False]


IDLE = Load(name="idle")
FLOOD = Load(name="flood", reports=5_000, strangers=20_000, viewers=64)


def test_stop_as_text_has_a_line_for_each_load() -> None:
    told = str(stop(stop_run(IDLE), stop_run(FLOOD, p99=70.0, dead_man=(399.6, 430.2)))).splitlines()
    assert told[4:7] == [
        "load   STOPs  p50   p99  unconfirmed  dead man  RTCP/s  strangers/s  joined  adapter CPU  pictures/s",
        "idle     300  4.0  20.0            0                 0            0     0/0         0.20        30.0",
        "flood    300  4.0  70.0            0  430        5,000       20,000   64/64         0.20        30.0",
    ]
    assert told[-1] == "all goals reached by the runs that count"


def test_stop_says_which_goals_were_missed() -> None:
    run = stop_run(FLOOD, p99=71.0, unconfirmed=2, dead_man=(400.0, 501.0), viewer_ended="the viewer is gone")
    assert stop(stop_run(IDLE), run).findings() == (
        "flood: p99 is 51 ms above idle, more than 50 ms",
        "flood: the honest viewer's peer connection ended: the viewer is gone",
        "flood: 2 STOPs were not confirmed",
        "flood: a dead man's switch took 501 ms",
    )


def test_a_run_that_does_not_reach_its_rates_does_not_count_for_its_p99() -> None:
    run = stop_run(FLOOD, p99=500.0, reports=4_400, strangers=18_000, joined=57)
    report = stop(stop_run(IDLE), run)
    assert "flood: does not count, only 4,400 of 5,000 RTCP/s, 57 of 64 joining viewers" in str(report)
    assert report.findings() == ("all goals reached by the runs that count",)


def test_stop_as_json_is_the_whole_report() -> None:
    report = stop(stop_run(IDLE), stop_run(FLOOD))
    assert StopReport.model_validate_json(report.model_dump_json()) == report
