"""Judgement of a media path by what arrives."""

import pytest
from openrois_media.client.path_watch import Flow, PathWatch, Verdict

FINE, WAITING, RESTART = Verdict.FINE, Verdict.WAITING, Verdict.RESTART


def flow(count: int, *, expected: bool = True) -> list[Flow]:
    return [Flow("s", expected, count)]


Look = tuple[float, str, list[Flow], Verdict]

TABLE: dict[str, list[Look]] = {
    "media arrives": [
        (0, "connected", flow(1), FINE),
        (1, "connected", flow(2), FINE),
        (9, "connected", flow(3), FINE),
    ],
    "a first frame has ten seconds": [
        (0, "new", flow(0), FINE),
        (5, "connecting", flow(0), WAITING),
        (9.9, "connected", flow(0), WAITING),
        (10, "connected", flow(0), RESTART),
    ],
    "later ones have two": [
        (0, "connected", flow(5), FINE),
        (0.5, "connected", flow(5), FINE),
        (1.5, "connected", flow(5), WAITING),
        (2, "connected", flow(5), RESTART),
    ],
    "what is not expected is not missed": [
        (0, "connected", flow(5), FINE),
        (9, "connected", flow(5, expected=False), FINE),
        (9.9, "connected", flow(5), FINE),
    ],
    "a stream that left and came back begins anew": [
        (0, "connected", flow(5), FINE),
        (5, "connected", [], FINE),
        (6, "connected", flow(5), FINE),
    ],
    "ICE has a second to recover": [
        (0, "disconnected", [], WAITING),
        (0.5, "connected", [], FINE),
        (1, "disconnected", [], WAITING),
        (2, "disconnected", [], RESTART),
    ],
    "failed is failed": [(0, "failed", [], RESTART)],
    "closed too": [(0, "closed", [], RESTART)],
    "a restart is asked for again, later each time": [
        (0, "failed", [], RESTART),
        (4.9, "failed", [], WAITING),
        (5, "failed", [], RESTART),
        (12.4, "failed", [], WAITING),
        (12.5, "failed", [], RESTART),
        (20, "connected", [], FINE),
        (60, "failed", [], RESTART),
        (65, "failed", [], RESTART),
    ],
}


@pytest.mark.parametrize("looks", TABLE.values(), ids=TABLE.keys())
def test_table(looks: list[Look]) -> None:
    watch = PathWatch()
    for now, state, flows, verdict in looks:
        assert watch.observe(now, state, flows) is verdict, now
