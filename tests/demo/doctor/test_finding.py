import json

from openrois_demo.doctor.finding import Finding, Level, as_json, as_text, exit_status, summary

GOOD = Finding(Level.OK, "codecs", "H264, VP8, opus")
POOR = Finding(Level.WARN, "voice", "none", "Install one.")
BAD = Finding(Level.FAIL, "media", "no pictures", "Look at the lines above. " * 6)


def test_a_finding_is_a_line_and_its_advice_stands_under_it() -> None:
    assert as_text(GOOD, colour=False) == "ok    codecs          H264, VP8, opus"
    assert as_text(POOR, colour=False).splitlines() == ["warn  voice           none", " " * 22 + "Install one."]
    assert all(len(line) <= 100 for line in as_text(BAD, colour=False).splitlines())
    assert "\x1b[31mfail \x1b[0m" in as_text(BAD, colour=True)


def test_streams_work_unless_something_failed() -> None:
    assert exit_status([GOOD, POOR]) == 0
    assert summary([GOOD, POOR]) == "1 ok, 1 to look at, 0 failed: streams will work"
    assert exit_status([GOOD, BAD]) == 1
    assert summary([GOOD, BAD]).endswith("1 failed: streams will not work")


def test_machines_read_the_same() -> None:
    told = json.loads(as_json([GOOD, BAD]))
    assert told["works"] is False
    assert told["findings"][0] == {"level": "ok", "name": "codecs", "detail": "H264, VP8, opus", "advice": ""}
