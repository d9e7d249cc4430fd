"""A data channel that is announced: the other end agrees to it, and messages pass both ways."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from aiortc import RTCDataChannel, RTCPeerConnection
from openrois_streaming.input.reader import Label
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.peer.data_channel import AnnouncedChannel
from openrois_streaming.peer.input_channels import OpenChannels

pytestmark = pytest.mark.media


class Ends:
    """Our end with its channel, and another one that knows nothing of us."""

    def __init__(self) -> None:
        self.ours, self.theirs = RTCPeerConnection(), RTCPeerConnection()
        self.opened: asyncio.Queue[str] = asyncio.Queue()
        self.came: asyncio.Queue[tuple[Label, str | bytes]] = asyncio.Queue()
        self.heard: asyncio.Queue[str | bytes] = asyncio.Queue()
        self.closed = asyncio.Event()
        self.found: list[RTCDataChannel] = []
        self.theirs.on("datachannel", self._find)
        self.ours.addTransceiver("video", direction="sendonly")
        make = AnnouncedChannel("talk", 4096, lambda: self.opened.put_nowait("ours"))
        self.channel: OpenChannels = make(
            self.ours, GuardFigures(), lambda *came: self.came.put_nowait(came), self.closed.set
        )

    def _find(self, channel: RTCDataChannel) -> None:
        self.found.append(channel)
        channel.on("message", self.heard.put_nowait)

    async def connect(self) -> None:
        await self.ours.setLocalDescription(await self.ours.createOffer())
        await self.theirs.setRemoteDescription(self.ours.localDescription)
        await self.theirs.setLocalDescription(await self.theirs.createAnswer())
        await self.ours.setRemoteDescription(self.theirs.localDescription)


@asynccontextmanager
async def ends() -> AsyncIterator[Ends]:
    made = Ends()
    yield made
    await made.ours.close()
    await made.theirs.close()


async def test_channel_opens_by_agreement_and_passes_messages_both_ways() -> None:
    async with asyncio.timeout(60), ends() as both:
        assert not both.channel.are_open
        assert not both.channel.send_message("lost")
        await both.connect()
        await both.opened.get()
        (theirs,) = both.found
        assert (theirs.label, theirs.ordered, theirs.maxRetransmits) == ("talk", True, None)
        assert both.channel.are_open
        assert both.channel.send_message(b"\xff\0")
        assert await both.heard.get() == b"\xff\0"
        theirs.send(b"\0\xff")
        theirs.send("text")
        assert [await both.came.get() for _ in range(2)] == [("control", b"\0\xff"), ("control", "text")]

        # What the other end opens of its own accord is not taken, and leads nowhere.
        other = both.theirs.createDataChannel("another")
        theirs.send("after it")
        assert await both.came.get() == ("control", "after it")
        assert other.readyState == "connecting"
        theirs.close()
        await both.closed.wait()
