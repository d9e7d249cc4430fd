"""Two bodies and their visitors: one greets, another one guides, and whichever is free takes the next visitor."""

import asyncio
import sys

from openrois.client import Client, RoISError, concurrent
from openrois.client.components import Navigation, Reaction, SpeechSynthesis

PLACE = "-1.0,0.5,0.0"
"""Where visitors are led: x and y in metres, and the direction in radians, on the floor of each body."""
WAIT = 120.0
"""Seconds that visitors wait for a body."""
ATTEMPTS = 5
"""Bodies that may be lost while they serve one visitor."""


async def lead(client: Client, speech: SpeechSynthesis, navigation: Navigation, words: str) -> None:
    """Say something on the way to the place."""
    await speech.set(speech_text=words)
    await navigation.set(target_positions=(PLACE,))
    await client.run(concurrent(speech.start(), navigation.start()))


async def welcome(client: Client) -> None:
    """Let one body greet with a gesture, and another one lead the way."""
    async with (
        client.body(SpeechSynthesis, Reaction, wait=WAIT) as host,
        client.body(SpeechSynthesis, Navigation, wait=WAIT) as guide,
    ):
        speech, reaction = host[SpeechSynthesis], host[Reaction]
        gesture, *_ = await reaction.available_reactions()
        await reaction.set(reaction_ref=gesture)
        await speech.set(speech_text="Welcome! My colleague shows you the way.")
        await client.run(concurrent(speech.start(), reaction.start()))
        await lead(client, guide[SpeechSynthesis], guide[Navigation], "Follow me, please.")
        print(f"{host.engine_id} greeted, {guide.engine_id} guided", flush=True)


async def receive(client: Client, visitor: str) -> None:
    """Serve a visitor with a body that is free; with another one when that is lost."""
    for attempt in range(ATTEMPTS):
        async with client.body(SpeechSynthesis, Navigation, wait=WAIT) as body:
            try:
                await lead(client, body[SpeechSynthesis], body[Navigation], f"Good day, {visitor}. Come with me.")
            except RoISError as error:
                if attempt == ATTEMPTS - 1:
                    raise
                print(f"{visitor}: {body.engine_id} was lost: {error}", flush=True)
            else:
                print(f"{visitor}: {body.engine_id} took care", flush=True)
                return


async def main(url: str = "ws://127.0.0.1:8765/", *visitors: str) -> None:
    """Receive visitors, as many at a time as there are bodies."""
    async with Client(url) as client:
        await welcome(client)
        expected = visitors or ("visitor 1", "visitor 2", "visitor 3")
        await asyncio.gather(*(receive(client, each) for each in expected))


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
