"""Of the HTTP server's library what matters is logged: failures inside, and how many requests could not be read."""

import asyncio
import logging
from urllib.parse import urlsplit

import pytest
from aiohttp.http_exceptions import InvalidHeader

from openrois.observability import http_log
from openrois.observability.http_log import HTTP_LOG
from tests.support import deployment


def failed(error: Exception) -> None:
    try:
        raise error
    except Exception:
        HTTP_LOG.exception("Error handling request")


@pytest.fixture(autouse=True)
def nothing_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http_log._failed, "count", 0)


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


def test_the_same_failure_at_will_is_logged_ever_more_seldom(caplog: pytest.LogCaptureFixture) -> None:
    for _ in range(1000):
        failed(ValueError("a bug"))
    assert len([record for record in caplog.records if record.exc_info]) == 10
    assert "requests that failed inside: 512 so far" in caplog.text


async def test_a_stranger_cannot_fill_the_log(caplog: pytest.LogCaptureFixture) -> None:
    async with deployment.gateway() as gateway:
        url = urlsplit(gateway.url)
        for _ in range(10):
            reader, writer = await asyncio.open_connection(url.hostname, url.port)
            writer.write(b"GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nExpect: \xff\r\n\r\n")
            assert (await reader.read()).startswith(b"HTTP/1.1 500")
            writer.close()
    assert len([record for record in caplog.records if record.exc_info]) == 4
