"""A pipeline of Pipecat in a body."""

from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager
from typing import Final

from openrois_media import Media
from openrois_streaming.source.downsample import SPEECH_RATE
from pipecat.transports.base_transport import BaseTransport, TransportParams

from openrois.client import Client, ComponentProxy
from openrois.types.codes import Purpose
from openrois_agents.pipecat.input_transport import VisitorInputTransport
from openrois_agents.pipecat.output_transport import BodyOutputTransport
from openrois_agents.voice.speech_writer import SpeechWriter
from openrois_agents.voice.visitor_sound import VisitorSound
from openrois_agents.voice.voice_and_ears import open_voice_and_ears

__all__ = ["BodyTransport", "embodied"]

_CONNECTED: Final = "on_client_connected"
_DISCONNECTED: Final = "on_client_disconnected"


class BodyTransport(BaseTransport):
    """Ears and mouth of a pipeline: `input()` is its first processor, and `output()` one behind those that speak.

    It has the events `on_client_connected` and `on_client_disconnected`, with the `visitor_ref` of the visitor that is
    heard from now on, or no more.

    Args:
        writer: open for as long as this is used, and used by nothing else.
        sound: likewise; None to hear nothing.
    """

    def __init__(self, writer: SpeechWriter, sound: VisitorSound | None) -> None:
        super().__init__()
        for event in (_CONNECTED, _DISCONNECTED):
            self._register_event_handler(event)
        params = TransportParams(
            audio_out_enabled=True,
            audio_out_sample_rate=writer.rate,
            # A body plays to the end what it has.
            audio_out_end_silence_secs=0,
            audio_in_enabled=sound is not None,
            audio_in_sample_rate=SPEECH_RATE if sound is None else sound.rate,
        )
        self._heard = ""
        self._input = VisitorInputTransport(sound, params, self._tell_change)
        self._output = BodyOutputTransport(writer, params)

    def input(self) -> VisitorInputTransport:
        """Return the processor that hears."""
        return self._input

    def output(self) -> BodyOutputTransport:
        """Return the processor that speaks."""
        return self._output

    def get_client_id(self, client: str) -> str:
        """Return the id of a visitor, which is its `visitor_ref`."""
        return client

    async def _tell_change(self, visitor_ref: str) -> None:
        left, self._heard = self._heard, visitor_ref
        if left:
            await self._call_event_handler(_DISCONNECTED, left)
        if visitor_ref:
            await self._call_event_handler(_CONNECTED, visitor_ref)


@asynccontextmanager
async def embodied(
    client: Client, media: Media, body: str | ComponentProxy, *, purposes: Collection[Purpose] = ()
) -> AsyncIterator[BodyTransport]:
    """Let a pipeline speak through a body, and hear its visitor: yields its transport, for as long as the block runs.

    Run the pipeline inside the block, once. The component of the body that speaks is bound meanwhile.

    Args:
        client: an open client.
        media: of this client, open.
        body: its engine id, or any component of it.
        purposes: what the visitor's sound is used for, such as `agent`, and `transfer` where a service on another
            machine recognises or answers; none, and the pipeline hears nothing.

    Raises:
        Unsupported: the body speaks no sound, or tells no visitors apart.
        OutOfResources: another application speaks through it.
        RoISError: the engine refuses.
        TimeoutError: it is not connected in time.
    """
    async with open_voice_and_ears(client, media, body, purposes) as (writer, sound):
        yield BodyTransport(writer, sound)
