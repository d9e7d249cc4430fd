"""A session that plays to a measuring sink, without a gateway between them."""

import asyncio
import itertools
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

from openrois_signaling.messages import Downward, IceServer, Offer

from openrois_streaming.clock import SystemClock
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.peer.input_channels import InputSink
from openrois_streaming.publish.rendition_feed import MediaPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.testing.sink import MeasuringSink

VIDEO, AUDIO = "video", "audio"
"""The ids of the streams."""


@asynccontextmanager
async def playing(
    sink: MeasuringSink,
    *,
    video: MediaPublisher | None = None,
    audio: MediaPublisher | None = None,
    codecs: Sequence[str] | None = None,
    network: NetworkSettings | None = None,
    ice_servers: Sequence[IceServer] = (),
    inputs: InputSink | None = None,
) -> AsyncIterator[StreamSession]:
    """A session that plays these to `sink` for as long as the context lasts; its streams are called VIDEO and AUDIO.

    Args:
        sink: answers all offers.
        video: pictures, if any.
        audio: sound, if any.
        codecs: what the sink says that it can decode of pictures, as media types; None for all.
        network: how the session uses the network.
        ice_servers: STUN and TURN servers of the session.
        inputs: hears what the sink sends over data channels; None: there are none.

    Raises:
        ExceptionGroup: an offer could not be answered.
        NoCommonCodec: nothing of `codecs` can be had here.
    """
    heard: asyncio.Queue[Downward] = asyncio.Queue()
    ids = itertools.count(1)
    async with asyncio.TaskGroup() as tasks:
        async with StreamSession(
            mint=lambda: f"stage/p{next(ids)}",
            send=heard.put_nowait,
            on_change=lambda _: None,
            clock=SystemClock(),
            ice_servers=ice_servers,
            network=network,
            sink=inputs,
        ) as session:
            answering = tasks.create_task(_answer(session, sink, heard))
            if video is not None:
                session.connect(VIDEO, "stage/Video", video, "video", codecs)
            if audio is not None:
                session.connect(AUDIO, "stage/Audio", audio, "audio")
            if inputs is not None:
                session.input.open()
            yield session
        answering.cancel()


async def _answer(session: StreamSession, sink: MeasuringSink, heard: asyncio.Queue[Downward]) -> None:
    while True:
        message = await heard.get()
        if isinstance(message, Offer):
            await session.answer(await sink.respond(message))
