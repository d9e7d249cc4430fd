"""What is public stays as it was recorded, wherever modules move; a change that is meant is recorded with it."""

import json
import sys

import pytest

from tests.support.surface import RECORD, surface

RECORDED = json.loads(RECORD.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def found() -> dict[str, object]:
    return surface()


def test_the_record_is_whole(found: dict[str, object]) -> None:
    assert found.keys() == RECORDED.keys()


@pytest.mark.parametrize("kind", RECORDED)
def test_it_is_as_recorded(kind: str, found: dict[str, object]) -> None:
    if kind == "commands" and sys.version_info >= (3, 13):
        pytest.skip("argparse writes its help otherwise since Python 3.13")
    now = json.loads(json.dumps(found[kind]))
    assert now == RECORDED[kind], "if it is meant: python -m tests.support.surface"
