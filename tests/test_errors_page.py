"""docs/reference/errors.md: every error that an application can meet has its row, with cause and remedy."""

import re

import pytest

import openrois.client
from openrois import errors
from openrois.gateway import adapters, applications, draining, token_expiry
from openrois.jsonrpc import protocol
from openrois.types.codes import CompletedStatus, ErrorType, ReturnCode
from tests.support.packages import ROOT

PAGE = (ROOT / "docs/reference/errors.md").read_text(encoding="utf-8")


def section(title: str) -> str:
    """Return a section of the page."""
    return PAGE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]


def firsts(title: str) -> set[str]:
    """Return the first cells of a section's table, without marks."""
    cells = re.findall(r"^\| `?([^|`]+?)`?(?: \*)? \|", section(title), re.MULTILINE)
    return {cell.strip() for cell in cells if not set(cell) <= set("- ")}


def test_every_exception_has_its_row() -> None:
    public = {name for name in openrois.client.__all__ if isinstance(getattr(openrois.client, name), type)}
    raised = {name for name in public if issubclass(getattr(openrois.client, name), Exception)}
    assert firsts("Exceptions in Python") == raised | {"exception"}
    others = {name for name in errors.__all__ if name[0].isupper()} - raised
    assert all(f"`{name}`" in section("Exceptions in Python") for name in others)


@pytest.mark.parametrize("enumeration", [ReturnCode, CompletedStatus])
def test_every_code_stands_there(enumeration: type[ReturnCode]) -> None:
    text = section("Return codes, and how commands end")
    assert [code.value for code in enumeration if f"`{code.value}`" not in text] == []


def test_codes_become_the_exceptions_that_the_table_says() -> None:
    rows = re.findall(r"^\| `(\w+)` \| (?:`(\w+)`)? \|", section("Return codes, and how commands end"), re.MULTILINE)
    raised = {code: name for code, name in rows if name}
    codes = [code for code in ReturnCode if code is not ReturnCode.OK]
    assert raised == {code.value: type(errors.error_for(code, "")).__name__ for code in codes}


def test_every_kind_of_fault_has_its_row() -> None:
    assert firsts("Errors that are notified") == {each.value for each in ErrorType} | {"error_type"}


def test_every_code_of_json_rpc_has_its_row() -> None:
    codes = {value for value in vars(protocol).values() if type(value) is int and value <= -32000}
    assert firsts("JSON-RPC errors") == {str(code) for code in codes} | {"code"}


def test_every_close_code_of_ours_has_its_row() -> None:
    ours = {adapters.TRY_AGAIN_LATER, applications.RESUMED, draining.SERVICE_RESTART, token_expiry.TOKEN_ENDED}
    assert {str(code) for code in ours} <= firsts("Close codes of a WebSocket")
