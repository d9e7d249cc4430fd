"""Session that plays to a measuring sink, without a gateway between them."""

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
"""Ids of the streams."""


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
    """Run a session that plays to `sink` while the context lasts; its streams are called VIDEO and AUDIO.

    Args:
        sink: answers all offers.
        video: pictures, if any.
        audio: sound, if any.
        codecs: video codecs that the sink names, as media types; None for all.
        network: network settings of the session.
        ice_servers: STUN and TURN servers of the session.
        inputs: gets the input that the sink sends; None: there are no channels.

    Raises:
        ExceptionGroup: an offer could not be answered.
        NoCommonCodec: none of `codecs` is available.
    """
    messages: asyncio.Queue[Downward] = asyncio.Queue()
    ids = itertools.count(1)
    async with asyncio.TaskGroup() as tasks:
        async with StreamSession(
            mint=lambda: f"stage/p{next(ids)}",
            send=messages.put_nowait,
            on_change=lambda _: None,
            clock=SystemClock(),
            ice_servers=ice_servers,
            network=network,
            sink=inputs,
        ) as session:
            answering = tasks.create_task(_answer(session, sink, messages))
            if video is not None:
                session.connect(VIDEO, "stage/Video", video, "video", codecs)
            if audio is not None:
                session.connect(AUDIO, "stage/Audio", audio, "audio")
            if inputs is not None:
                session.input.open()
            yield session
        answering.cancel()


async def _answer(session: StreamSession, sink: MeasuringSink, messages: asyncio.Queue[Downward]) -> None:
    while True:
        message = await messages.get()
        if isinstance(message, Offer):
            await session.apply_answer(await sink.respond(message))
