"""The channels of an application: how much waits in them for a network that is slow."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from aiortc import RTCPeerConnection
from openrois_streaming.input.reader import Label
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.peer.input_channels import SPEECH_UNSENT_LIMIT, UNSENT_LIMIT, Channels
from openrois_streaming.viewing.speech_channel import SpeechChannel

pytestmark = pytest.mark.media

MESSAGE = "x" * 1_000


@asynccontextmanager
async def channels() -> AsyncIterator[tuple[Channels, asyncio.Queue[str]]]:
    """The body's channels, and what comes at the application's end of `speech`."""
    body, application = RTCPeerConnection(), RTCPeerConnection()
    told: asyncio.Queue[str] = asyncio.Queue()
    ours = Channels(body, GuardFigures(), lambda _label, _data: None, lambda: None)
    theirs = SpeechChannel(told.put_nowait, lambda: None)
    body.addTransceiver("audio", direction="sendonly")
    try:
        await body.setLocalDescription(await body.createOffer())
        await application.setRemoteDescription(body.localDescription)
        theirs.make(application)
        await application.setLocalDescription(await application.createAnswer())
        await body.setRemoteDescription(application.localDescription)
        application.createDataChannel("input", negotiated=True, id=0)
        while not (theirs.is_open and ours.are_open):  # noqa: ASYNC110 - our end tells nothing when it opens
            await asyncio.sleep(0)
        yield ours, told
    finally:
        await body.close()
        await application.close()


@pytest.mark.parametrize(("label", "limit"), [("control", UNSENT_LIMIT), ("speech", SPEECH_UNSENT_LIMIT)])
async def test_what_waits_to_be_sent_is_bounded_and_of_speech_there_may_be_more(label: Label, limit: int) -> None:
    async with asyncio.timeout(60), channels() as (ours, told):
        taken = 0
        # Nothing leaves while the event loop does not run.
        while ours.send_message(MESSAGE, label):
            taken += 1
        assert taken == pytest.approx(limit / len(MESSAGE), abs=2)
        if label == "speech":
            assert [await told.get() for _ in range(taken)] == [MESSAGE] * taken
            assert ours.send_message("more", label)
            assert await told.get() == "more"
