"""Versions of two gateways: one minor release apart is tried, and what is more is said to the operator."""

import pytest

from openrois.federation.version_skew import is_tried, told_version


@pytest.mark.parametrize(
    ("theirs", "ours", "expected"),
    [
        ("0.3.0", "0.2.0", True),
        ("0.2.0", "0.3.1", True),
        ("0.2.7", "0.2.0", True),
        ("0.3.0rc1", "0.2.0", True),
        ("0.4.0", "0.2.0", False),
        ("1.2.0", "0.2.0", False),
        ("1.0", "1.1", True),
        ("1", "1", True),
        ("1", "0.2.0", False),
        ("", "0.2.0", False),
        (f"{'9' * 7}.1.0", "0.2.0", False),
    ],
)
def test_one_minor_release_apart_is_tried(theirs: str, ours: str, expected: bool) -> None:
    assert is_tried(theirs, ours) is expected


def test_what_is_said_of_it() -> None:
    assert told_version("b", "0.3.0", "0.2.0") == "gateway b runs OpenRoIS 0.3.0, and this one is 0.2.0"
    assert told_version("b", "0.4.0", "0.2.0").endswith("upgrade by one minor release at a time, nothing else is tried")
