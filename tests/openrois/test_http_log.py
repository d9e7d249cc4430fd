"""Of the HTTP server's library what matters is logged: failures inside, and how many requests could not be read."""

import logging

import pytest
from aiohttp.http_exceptions import InvalidHeader

from openrois.http_log import HTTP_LOG


def failed(error: Exception) -> None:
    try:
        raise error
    except Exception:
        HTTP_LOG.exception("Error handling request")


def test_failures_are_logged_and_what_strangers_send_is_not(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO, "openrois")
    failed(ValueError("a bug"))
    failed(InvalidHeader("Authorization: Bearer abcdefgh"))
    HTTP_LOG.info("said")
    assert [record.getMessage() for record in caplog.records if record.name == HTTP_LOG.name] == [
        "Error handling request",
        "said",
    ]
    assert "abcdefgh" not in caplog.text
    assert "a bug" in caplog.text
