"""Lets a body behind the gateway say what is given on the command line, and make a gesture."""

import asyncio
import sys

from openrois.client import Client, concurrent
from openrois.client.components import Reaction, SpeechSynthesis


async def main(text: str = "Hello!", url: str = "ws://127.0.0.1:8765/") -> None:
    """Say `text`; return when it has been said."""
    async with Client(url) as client, client.body(SpeechSynthesis, Reaction) as body:
        speech, reaction = body[SpeechSynthesis], body[Reaction]
        gesture, *_ = await reaction.available_reactions()
        await speech.set(speech_text=text, volume=80)
        await reaction.set(reaction_ref=gesture)
        await client.run(concurrent(speech.start(), reaction.start()))
        print(f"{body.engine_id} said: {text}")


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
