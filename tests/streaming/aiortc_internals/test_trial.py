import logging
from collections.abc import Callable

import pytest
from aiortc import InvalidStateError, RTCPeerConnection
from aiortc.rtcdtlstransport import RTCDtlsTransport
from openrois_streaming.aiortc_internals import trial
from openrois_streaming.aiortc_internals.connection import contain_starts
from openrois_streaming.aiortc_internals.trial import UnsupportedLibrary, self_test

pytestmark = pytest.mark.extra(name="streaming")


async def test_the_installed_libraries_are_as_expected() -> None:
    await self_test()


@pytest.mark.parametrize("name", ["aiortc", "aioice"])
async def test_another_version_is_refused(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setitem(trial.TESTED, name, "0.1.")
    with pytest.raises(UnsupportedLibrary, match=rf"{name} .* is installed and not tested: install {name}==0\.1\.\*"):
        await self_test()


def received_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    async def receive(self: RTCDtlsTransport) -> None:
        pass

    monkeypatch.setattr(RTCDtlsTransport, "_recv_next", receive)


def started_later(monkeypatch: pytest.MonkeyPatch) -> None:
    async def describe(self: RTCPeerConnection, description: object) -> None:
        pass

    monkeypatch.setattr(RTCPeerConnection, "setRemoteDescription", describe)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (started_later, "sections are started elsewhere"),
        (received_elsewhere, "packets do not pass _handle_rtp_data; packets do not pass _handle_rtcp_data"),
    ],
)
async def test_a_changed_library_is_refused(
    monkeypatch: pytest.MonkeyPatch, change: Callable[[pytest.MonkeyPatch], None], told: str
) -> None:
    change(monkeypatch)
    with pytest.raises(UnsupportedLibrary, match=told):
        await self_test()


@pytest.mark.parametrize(
    ("failure", "logged"),
    [
        (None, False),
        (IndexError("a section more than the answer has"), False),
        (InvalidStateError("RTCIceTransport is closed"), False),
        (RuntimeError("a mistake"), True),
    ],
)
async def test_failed_start_of_sections_is_logged_unless_overtaken(
    caplog: pytest.LogCaptureFixture, failure: Exception | None, logged: bool
) -> None:
    connection, started = RTCPeerConnection(), []

    async def connect() -> None:
        started.append(failure)
        if failure is not None:
            raise failure

    connection._RTCPeerConnection__connect = connect  # type: ignore[attr-defined]
    contain_starts(connection)
    with caplog.at_level(logging.INFO):
        await connection._RTCPeerConnection__connect()  # type: ignore[attr-defined]
    assert started == [failure]
    assert ("a mistake" in caplog.text) is logged
    await connection.close()
