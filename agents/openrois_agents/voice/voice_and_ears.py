"""The voice and the ears of a body, opened together."""

from collections.abc import AsyncIterator, Collection
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Final

from openrois_media import Media

from openrois.client import Client, ComponentProxy
from openrois.types.codes import Purpose
from openrois_agents.voice.speech_writer import SpeechWriter
from openrois_agents.voice.visitor_sound import VisitorSound

__all__ = ["open_voice_and_ears"]

_SPOKEN_RATE: Final = 24_000


@asynccontextmanager
async def open_voice_and_ears(
    client: Client, media: Media, body: str | ComponentProxy, purposes: Collection[Purpose]
) -> AsyncIterator[tuple[SpeechWriter, VisitorSound | None]]:
    """Open the voice of a body, and its ears where there is a purpose: what follows in the block speaks and hears.

    The component of the body that speaks is bound for as long as the block runs. At its end the body falls silent.

    Args:
        client: an open client.
        media: of this client, open.
        body: its engine id, or any component of it.
        purposes: what the visitor's sound is used for; none, and nothing is heard.

    Raises:
        Unsupported: the body speaks no sound, or tells no visitors apart.
        OutOfResources: another application speaks through it.
        RoISError: the engine refuses.
        TimeoutError: it is not connected in time.
    """
    async with AsyncExitStack() as stack:
        speech = await stack.enter_async_context(media.speech(body, rate=_SPOKEN_RATE))
        writer = await stack.enter_async_context(SpeechWriter(speech))
        sound = None
        if purposes:
            sound = await stack.enter_async_context(VisitorSound(client, media, body, purposes=purposes))
        yield writer, sound
