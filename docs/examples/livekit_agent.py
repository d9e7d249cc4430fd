"""Repeats what a visitor of a body says, as a voice agent without any model: `livekit_agent.py [BODY [URL]]`."""

import asyncio
import sys
from collections.abc import AsyncIterator

import numpy as np
from livekit.agents import Agent, AgentSession, StopResponse, llm, stt
from livekit.rtc import AudioFrame
from openrois_agents.livekit import embodied, run_agent
from openrois_media import Media, Purpose

from openrois.client import Client


class Ears(stt.STT):
    """Stands where a model that recognises speech would, and keeps the sound."""

    said: tuple[AudioFrame, ...] = ()
    _recognize_impl = None  # It recognises streams alone.

    def stream(self, **options: object) -> "Listening":
        """Listen from now on."""
        return Listening(stt=self, conn_options=options["conn_options"])


class Listening(stt.RecognizeStream):
    """Waits for sound, and then for half a second of silence."""

    async def _run(self) -> None:
        heard, quiet = tuple[AudioFrame, ...](), 0.0
        async for frame in self._input_ch:
            if isinstance(frame, AudioFrame):
                loud = np.abs(np.frombuffer(frame.data, np.int16).astype(int)).max() > 500
                quiet = 0.0 if loud else quiet + frame.duration
                heard = (*heard, frame) if heard or loud else ()
                if heard and quiet >= 0.5:
                    self._stt.said, heard = heard, ()
                    text = f"{sum(each.duration for each in self._stt.said) - quiet:.1f} s of sound"
                    for kind in (stt.SpeechEventType.FINAL_TRANSCRIPT, stt.SpeechEventType.END_OF_SPEECH):
                        self._event_ch.send_nowait(stt.SpeechEvent(kind, alternatives=[stt.SpeechData("en", text)]))


class Parrot(Agent):
    """Says what it heard; one with a language model and a voice needs nothing of this."""

    async def on_user_turn_completed(self, turn_ctx: llm.ChatContext, new_message: llm.ChatMessage) -> None:
        """Repeat what was said last."""
        print(new_message.text_content, flush=True)
        self.session.say(new_message.text_content, audio=self._sound(self.session.stt.said))
        raise StopResponse

    async def _sound(self, frames: tuple[AudioFrame, ...]) -> AsyncIterator[AudioFrame]:
        for frame in frames:
            yield frame


async def main(body: str = "avatar", url: str = "ws://127.0.0.1:8765/") -> None:
    """Put the session into the body until Ctrl-C."""
    ears = Ears(capabilities=stt.STTCapabilities(streaming=True, interim_results=False))
    bot = AgentSession(stt=ears, vad=None, turn_handling={"turn_detection": "stt"})
    async with Client(url) as app, Media(app) as media, embodied(bot, app, media, body, purposes=[Purpose.AGENT]), bot:
        await bot.start(Parrot(instructions=""))
        await asyncio.Event().wait()


if __name__ == "__main__":
    run_agent(main(*sys.argv[1:]))
