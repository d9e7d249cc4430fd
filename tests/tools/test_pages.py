"""Printed parts of pages: they follow the code, and what is printed replaces nothing but what was."""

import json

import pytest
from openrois_streaming.state import TRANSITIONS

from openrois.gateway.configuration import settings_of
from tools.pages.__main__ import PARTS, ROOT, pages
from tools.pages.configuration import gateway_settings
from tools.pages.figures import adapter_figures, cluster_figures, gateway_figures, mind_figures
from tools.pages.parts import UnknownPart, filled, outdated
from tools.pages.states import negotiation_states, stream_states


def test_every_page_is_as_the_code_says() -> None:
    assert outdated(ROOT, pages()) == [], "run `make generate`"


def test_every_part_stands_on_a_page() -> None:
    text = "".join(pages().values())
    assert [name for name in PARTS if f"<!-- printed: {name} -->" not in text] == []


def test_a_part_replaces_what_is_between_its_marks() -> None:
    page = "before\n<!-- printed: one -->\nold\n<!-- printed until here -->\nafter\n"
    assert filled(page, {"one": lambda: ["new"]}) == (
        "before\n<!-- printed: one -->\n\nnew\n\n<!-- printed until here -->\nafter\n"
    )


def test_an_unknown_part_is_an_error() -> None:
    with pytest.raises(UnknownPart, match="'two' is unknown; there are one"):
        filled("<!-- printed: two -->\n<!-- printed until here -->\n", {"one": list})


def test_a_state_table_has_a_row_for_each_state_that_can_be_left() -> None:
    head, _, *rows = stream_states()
    assert head == "| phase | *up* | *flowing* | *stalled* | *suspend* | *resume* | *end* | status |"
    assert [row.split()[1] for row in rows] == [phase.value for phase, after in TRANSITIONS.items() if after]
    assert "| parked | suspended |  |  | parked | connecting | ended | NOT_CONNECTED |" in rows


def test_a_state_table_says_how_long_a_state_may_last() -> None:
    assert "| offered | offered |  | applying |  | ended | 10 s |" in negotiation_states()


def test_every_setting_has_its_row() -> None:
    rows = [line for line in gateway_settings() if line.startswith("| `")]
    assert [row.split("`")[1] for row in rows] == [setting.key for setting in settings_of()]
    assert "| `port`<br>`--port` | `8765` | TCP port, 0 for any free one |" in rows


def test_every_figure_of_both_has_its_row() -> None:
    tables = [*gateway_figures(), *cluster_figures(), *adapter_figures(), *mind_figures()]
    found = [line.split("`")[1] for line in tables if line.startswith("| `")]
    recorded = json.loads((ROOT / "tests/public_surface.json").read_text(encoding="utf-8"))["metrics"]
    assert sorted(found) == recorded
