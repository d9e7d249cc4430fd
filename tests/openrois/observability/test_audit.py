"""The audit trail: one JSON object a line whatever is in it, in order, and complete or it says so."""

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from openrois.auth.principal import LOCAL, Principal, Role
from openrois.errors import ComponentFailed
from openrois.observability import audit as audit_module
from openrois.observability import correlation
from openrois.observability.audit import Audit
from tests.support.clock import Clock

NASTY = ["\r\n{}", "\x1b[31m", "\x7f", '"}\n{"kind": "acted"', "\ud800"]
ANNA = Principal("anna", frozenset({Role.OPERATOR}), ("*",), token_id="t1")


def told(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_actions_and_refusals_are_recorded_with_their_principal(tmp_path: Path) -> None:
    path = tmp_path / "audit"
    with Audit(path, clock=Clock(1000.5)) as audit, correlation.connection("abcd"):
        audit.acted(ANNA, "rois.command.bind", "robot/arm", "kind")
        correlation.request.set(7)
        audit.refused(None, "/adapter", "", "no token")
        correlation.request.set(None)
        audit.acted(LOCAL, "rois.command.release", "robot/arm")
        assert audit.is_kept
        audit.require()
    assert told(path) == [
        {
            "time": 1000.5,
            "kind": "acted",
            "who": "anna",
            "method": "rois.command.bind",
            "subject": "robot/arm",
            "detail": "kind",
            "token_id": "t1",
            "correlation": "abcd",
        },
        {"time": 1000.5, "kind": "refused", "method": "/adapter", "reason": "no token", "correlation": "abcd/7"},
        {
            "time": 1000.5,
            "kind": "acted",
            "who": "local",
            "method": "rois.command.release",
            "subject": "robot/arm",
            "correlation": "abcd",
        },
    ]
    assert (audit.actions, audit.refusals, audit.waiting, audit.lost, audit.failures) == (2, 1, 0, 0, 0)


@given(st.lists(st.text(max_size=400) | st.sampled_from(NASTY)))
@example(["x" * 301, "Bearer abcdefgh12345", "\x7f"])
def test_a_record_is_one_line_whatever_is_in_it(texts: list[str]) -> None:
    for text in texts:
        line = Audit()._line((1.0, "acted", text, "", text, text, text, text))
        assert line.isascii()
        assert line.isprintable()
        record = json.loads(line)
        assert record["kind"] == "acted"
        shown = audit_module._NO_SECRETS(text)
        assert record.get("who", "") == (shown if len(shown) <= 300 else shown[:300] + "…")


def test_without_a_file_records_are_counted_and_nothing_is_refused() -> None:
    with Audit() as audit:
        audit.acted(ANNA, "rois.command.bind", "robot/arm")
        audit.refused(ANNA, "rois.command.bind", "robot/arm", "held")
        audit.require()
    assert (audit.actions, audit.refusals, audit.waiting, audit.lost, audit.failures) == (1, 1, 0, 0, 0)


def test_administrators_do_nothing_without_a_record_and_others_go_on(tmp_path: Path) -> None:
    audit = Audit(tmp_path / "audit", limit=2)  # not entered: nothing is written
    audit.refused(None, "m", "s", "r")
    audit.refused(None, "m", "s", "r")
    assert (audit.waiting, audit.lost) == (1, 1)
    audit.require()
    audit.acted(ANNA, "m", "s")
    with pytest.raises(ComponentFailed, match="audit"):
        audit.require()
    audit.acted(ANNA, "m", "s")
    assert (audit.waiting, audit.lost, audit.is_kept) == (2, 2, False)
    with audit:
        pass
    assert [record["kind"] for record in told(tmp_path / "audit")] == ["refused", "acted", "lost"]
    assert told(tmp_path / "audit")[-1]["count"] == 2
    audit.require()
