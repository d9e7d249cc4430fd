"""When the playout delay is reported."""

import pytest
from openrois_media.client.playout_reports import PlayoutReports

Look = tuple[str | None, float, float, float | None]

TABLE: dict[str, list[Look]] = {
    "the first is reported": [("s", 0.04, 0.0, 0.04)],
    "nothing plays": [("s", 0.0, 0.0, None), (None, 0.04, 1.0, None)],
    "a small change is not": [("s", 0.04, 0.0, 0.04), ("s", 0.045, 5.0, None)],
    "more is reported at once": [("s", 0.04, 0.0, 0.04), ("s", 0.2, 0.5, 0.2)],
    "less when the peak is over": [("s", 0.2, 0.0, 0.2), ("s", 0.04, 1.0, None), ("s", 0.04, 4.0, 0.04)],
    "another connection begins anew": [("s", 0.04, 0.0, 0.04), ("t", 0.04, 0.5, 0.04)],
}


@pytest.mark.parametrize("looks", TABLE.values(), ids=TABLE.keys())
def test_table(looks: list[Look]) -> None:
    reports = PlayoutReports()
    for stream_id, delay, now, reported in looks:
        assert reports.due(stream_id, delay, now) == reported
