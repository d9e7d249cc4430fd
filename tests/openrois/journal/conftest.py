"""Databases that tests leave open, as a gateway does that is killed, are closed when the test is over."""

import sqlite3
from collections.abc import Iterator
from typing import Any
from unittest.mock import patch

import pytest


@pytest.fixture(autouse=True)
def _closed() -> Iterator[None]:
    connect, opened = sqlite3.connect, list[sqlite3.Connection]()

    def connected(*arguments: Any, **options: Any) -> sqlite3.Connection:
        opened.append(connect(*arguments, **options))
        return opened[-1]

    with patch("sqlite3.connect", connected):
        yield
    for database in opened:
        database.close()
