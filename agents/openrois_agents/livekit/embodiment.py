"""A session of LiveKit Agents in a body."""

from collections.abc import AsyncIterator, Collection
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from typing import Any

from livekit.agents import AgentSession
from livekit.agents.voice.transcription import TranscriptSynchronizer
from openrois_media import Media

from openrois.client import Client, ComponentProxy
from openrois.types.codes import Purpose
from openrois_agents.livekit.audio_input import VisitorAudioInput
from openrois_agents.livekit.audio_output import BodyAudioOutput
from openrois_agents.voice.voice_and_ears import open_voice_and_ears

__all__ = ["embodied"]


@asynccontextmanager
async def embodied(
    session: AgentSession[Any],
    client: Client,
    media: Media,
    body: str | ComponentProxy,
    *,
    purposes: Collection[Purpose] = (),
) -> AsyncIterator[None]:
    """Let a session speak through a body, and hear its visitor, for as long as the block runs.

    Start the session inside the block, without a room; one that still runs at its end has neither ears nor mouth from
    then on. The component of the body that speaks is bound meanwhile. What the body breaks off, as when a person takes
    it, the session takes for an interruption; of a visitor that withdraws its consent, or leaves, the words that were
    not answered yet are forgotten.

    Args:
        session: not started.
        client: an open client.
        media: of this client, open.
        body: its engine id, or any component of it.
        purposes: what the visitor's sound is used for, such as `agent`, and `transfer` where a service on another
            machine recognises or answers; none, and the session hears nothing.

    Raises:
        Unsupported: the body speaks no sound, or tells no visitors apart.
        OutOfResources: another application speaks through it.
        RoISError: the engine refuses.
        TimeoutError: it is not connected in time.
    """
    async with open_voice_and_ears(client, media, body, purposes) as (writer, sound), AsyncExitStack() as stack:
        writer.broken_off.add(lambda _reason: _interrupt(session))
        output = BodyAudioOutput(writer)
        # The history of the conversation gets what was heard of an answer, and not all that was meant.
        texts = session.output.transcription
        synchronizer = TranscriptSynchronizer(next_in_chain_audio=output, next_in_chain_text=texts)
        stack.push_async_callback(synchronizer.aclose)
        if sound is not None:
            sound.heard_changed.add(lambda heard: None if heard else _forget_turn(session))
            session.input.audio = VisitorAudioInput(sound)
        session.output.audio = synchronizer.audio_output
        session.output.transcription = synchronizer.text_output
        try:
            yield
        finally:
            _interrupt(session)
            session.input.audio = session.output.audio = None
            session.output.transcription = texts


def _interrupt(session: AgentSession[Any]) -> None:
    """End what the session says now; it is not said to its end."""
    if (speech := session.current_speech) is not None:
        speech.interrupt(force=True)


def _forget_turn(session: AgentSession[Any]) -> None:
    # A session that does not run, or has ended, has no turn.
    with suppress(RuntimeError):
        session.clear_user_turn()
