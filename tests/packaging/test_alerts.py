"""The alerts for Prometheus: they ask for figures that are served, and operators are told what to do."""

import re
from collections.abc import Iterator
from itertools import chain
from typing import Any

import yaml

from openrois.federation.counts import Counts
from openrois.ownership.directorate import Directorate
from openrois.ownership.memory_store import MemoryStore
from tests.support.clock import Clock
from tests.support.packages import ROOT
from tools.pages.figures import adapter_figures, cluster_figures, gateway_figures

GROUPS: list[dict[str, Any]] = yaml.safe_load((ROOT / "packaging/alerts.yml").read_text(encoding="utf-8"))["groups"]


def rules() -> Iterator[dict[str, Any]]:
    return chain.from_iterable(group["rules"] for group in GROUPS)


def test_each_asks_for_figures_that_are_served() -> None:
    rows = (*gateway_figures(), *cluster_figures(), *adapter_figures())
    served = {line.split("`")[1]: line for line in rows if line.startswith("| `")}
    for rule in rules():
        # A state set has a label of its own name.
        asked = re.findall(r"\bopenrois_\w+", rule["expr"])
        assert asked
        assert set(asked) <= set(served), rule["alert"]
        for name in asked:
            counts = "increase" in rule["expr"] or "rate" in rule["expr"]
            assert counts is name.endswith("_total"), rule["alert"]


def test_each_asks_for_an_outcome_that_there_is() -> None:
    known = {"claims": Directorate(MemoryStore(Clock(1.0)), "a").outcomes, "relayed_calls": Counts().calls}
    known["resumed_sessions"] = Counts().resumptions
    asked = [re.findall(r'openrois_gateway_(\w+)_total\{outcome!?="(\w+)"\}', rule["expr"]) for rule in rules()]
    found = list(chain.from_iterable(asked))
    assert {name for name, _ in found} == set(known)
    assert [outcome for name, outcome in found if outcome not in known[name]] == []


def test_each_says_what_has_happened_where() -> None:
    names = [rule["alert"] for rule in rules()]
    assert len(names) == len(set(names))
    for rule in rules():
        assert set(rule) <= {"alert", "expr", "for", "annotations"}
        assert re.fullmatch(r"\d+[smh]", rule.get("for", "0s"))
        assert "{{ $labels." in rule["annotations"]["summary"]


def test_the_page_says_what_to_do_about_each_of_several_gateways() -> None:
    page = (ROOT / "docs/how-to/several-gateways.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`[A-Z].*?) \|", page, re.MULTILINE)
    told = {name for row in rows for name in re.findall(r"`([A-Z]\w+)`", row)}
    (ours,) = [group["rules"] for group in GROUPS if group["name"] == "openrois-cluster"]
    assert told - {"JournalIsNotWritten"} == {rule["alert"] for rule in ours}
