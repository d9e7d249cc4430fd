"""The inspector has nothing in it that is made for a component: it knows profiles."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON

_SOURCES: Final = sorted((Path(__file__).parents[1] / "web_demo" / "app" / "inspector").glob("*.ts"))
_QUOTED: Final = re.compile(r"""["'`]([^"'`\n]*)["'`]""")
_WORD: Final = re.compile(r"\w+")


def _names() -> Iterator[str]:
    for kind in (ROIS_COMMON, *BASIC_COMPONENTS):
        yield from (kind.code, kind.name)
        yield from (command.name for command in kind.commands)
        yield from (query.name for query in kind.queries)
        yield from (event.name for event in kind.events)


def _said(source: str) -> set[str]:
    """The texts in quotation marks, and every name that can be nothing but one of the wire."""
    return {*_QUOTED.findall(source), *(word for word in _WORD.findall(source) if "_" in word)}


def test_no_component_and_no_message_of_the_standard_is_named_in_the_inspector() -> None:
    assert len(_SOURCES) > 15
    names = set(_names())
    assert len(names) > 50
    # The type of a status is a type of values, whatever query answers with it.
    allowed = {"component_status"}
    found = {path.name: _said(path.read_text()) & names - allowed for path in _SOURCES}
    assert {name: said for name, said in found.items() if said} == {}
