"""The bench of visitors: one of its cases, in short, with all its processes."""

import pytest
from openrois_bench.streams.visitors.__main__ import CASES, Case, measure, told

pytestmark = pytest.mark.media


@pytest.mark.long
async def test_a_visitor_who_is_listened_to_and_recognised() -> None:
    case = Case(1, "microphone", 1, recognised=True)
    found = await measure(case, (160, 90), 5.0, 0.0, 1.0)
    assert found["cpu"] > 0
    assert found["megabytes"] > 50
    assert found["relayed_blocks"] > 0
    assert found["relayed_pictures"] == 0


def test_cases_are_a_row_each() -> None:
    figures = {"cpu": 0.01, "megabytes": 130.0, "relayed_pictures": 0.0, "relayed_blocks": 50.0, "load": 0.5}
    rows = [
        {name: getattr(case, name) for name in ("visitors", "sent", "listeners", "recognised")} | figures
        for case in CASES
    ]
    lines = told(rows).splitlines()
    assert len(lines) == 1 + len(CASES) == len({*lines})
