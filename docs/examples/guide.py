"""Receives visitors with a body that is free, and leads them to places with a robot: `guide.py --help`."""

import argparse
import asyncio
from contextlib import suppress
from pathlib import Path

from small_talk import NoAnswer, SmallTalk
from steady_voice import FAILED, Voice, has_again

from openrois.client import (
    BindingLent,
    BodyLost,
    Client,
    ComponentFailed,
    ComponentProxy,
    Connected,
    ControlRequested,
    ProfileChanged,
)
from openrois.client.components import Navigation

HEARING = "urn:x-rois:def:component:OpenRoIS::Hearing"
SURROUNDINGS = "urn:x-rois:def:component:OpenRoIS::Surroundings"
ATTEMPTS = 5
"""How often a way is gone that was broken off."""
AGAIN = 5.0
"""Seconds after which bodies that hear, and a voice for what was not said, are looked for again."""
IDLE = 60.0
"""Seconds from the last words of a visit to its end."""


async def find(client: Client, kind: type[ComponentProxy] | str, engine_id: str = "") -> list[str]:
    """Return the components of a type, of all bodies or of one."""
    return [ref for info in await client.bodies() for ref in info.refs(kind) if engine_id in ("", info.engine_id)]


class Guide:
    """Serves one visitor at a time, and tells what becomes of its bodies."""

    def __init__(self, client: Client, robot: str, talk: SmallTalk, note: Path) -> None:
        self._client, self._robot, self._talk, self._note = client, robot, talk, note
        self._voice = Voice(client)
        self._heard: asyncio.Queue[tuple[str, str]] = asyncio.Queue(8)
        self._walk: asyncio.Task[None] | None = None

    async def run(self) -> None:
        """Serve visitors until cancelled."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._tell_changes())
            tasks.create_task(self._tell_late())
            tasks.create_task(self._find_ears(tasks))
            print("ready", flush=True)
            if self._note.exists():
                await self._visit(tasks, "I am sorry, I was interrupted.", "", "")
            while True:
                await self._visit(tasks, "Hello!", *await self._heard.get())

    async def _find_ears(self, tasks: asyncio.TaskGroup) -> None:
        """Listen to every body that hears, also to one that comes later."""
        found: set[str] = set()
        async with self._client.notices(ProfileChanged) as changes:
            while True:
                with suppress(*FAILED):
                    for ref in set(await find(self._client, HEARING)) - found:
                        found.add(ref)
                        tasks.create_task(self._listen(self._client.component(ref)))
                with suppress(TimeoutError):
                    await asyncio.wait_for(anext(changes), AGAIN)

    async def _listen(self, hearing: ComponentProxy) -> None:
        while True:
            try:
                async for heard in hearing.event("heard"):
                    self._take(heard["text"].lower(), heard["final"], heard.get("visitor_ref") or "")
            except (LookupError, *FAILED) as error:
                print(f"{hearing.component_ref} is not heard: {error}", flush=True)
            await asyncio.sleep(AGAIN)

    def _take(self, words: str, final: bool, visitor: str) -> None:
        if "stop" in words and self._walk is not None:
            # Whatever is being said or thought meanwhile.
            self._walk.cancel()
        if final and words and not self._heard.full():
            self._heard.put_nowait((words, visitor))

    async def _tell_changes(self) -> None:
        """Tell the visitor what was lost, taken or is back, and hand over what a person requests."""
        async for notice in self._client.notices(BindingLent, BodyLost, Connected, ControlRequested):
            match notice:
                case ControlRequested(ref, request_id, subject):
                    what = "my voice" if ref == self._voice.component_ref else "the robot"
                    await self._voice.say(f"{subject or 'A person'} may have {what}. I wait until it is back.")
                    with suppress(*FAILED):
                        await self._client.control.grant(request_id)
                case BindingLent(ref, holder, seconds) if ref != self._voice.component_ref:
                    await self._voice.say(f"{holder} has the robot for {seconds:.0f} seconds. I wait until it is back.")
                case BodyLost() if self._voice.is_lost:
                    await self._voice.say("What may I do for you?")
                case Connected() if self._voice.body is not None:
                    await self._voice.say("I was cut off for a moment. I am here again.")

    async def _tell_late(self) -> None:
        """Tell the visitor what no body was free to say, as soon as one is."""
        while True:
            await asyncio.sleep(AGAIN)
            with suppress(*FAILED):
                await self._voice.say_late()

    async def _visit(self, tasks: asyncio.TaskGroup, greeting: str, words: str, visitor: str) -> None:
        """Serve a visitor until goodbye. A body is held meanwhile; the note stays where this process dies before."""
        self._note.touch()
        await self._voice.say(greeting)
        places = await self._places()
        while "goodbye" not in words:
            place = next((name for name in places if name in words), "")
            if place or "stop" in words:
                await self._end_walk()
            if place:
                self._walk = tasks.create_task(self._lead(place))
            else:
                await self._voice.say("I stop." if "stop" in words else await self._answer(words, visitor, places))
            words, visitor = await self._next_words()
        await self._end_walk()
        await self._voice.say("Goodbye!")
        await self._voice.rest()
        self._note.unlink(missing_ok=True)

    async def _next_words(self) -> tuple[str, str]:
        while True:
            try:
                return await asyncio.wait_for(self._heard.get(), IDLE)
            except TimeoutError:
                if self._walk is None or self._walk.done():
                    return "goodbye", ""

    async def _end_walk(self) -> None:
        if self._walk is not None:
            self._walk.cancel()
            await asyncio.wait({self._walk})

    async def _lead(self, place: str) -> None:
        """Let the robot lead to a place. It stops when its legs are given back: also where this is cancelled."""
        try:
            ref = next(iter(await find(self._client, Navigation, self._robot)), f"{self._robot}/navigation")
            legs = self._client.component(Navigation, ref)
            await legs.bind()
        except FAILED as error:
            print(f"no robot: {error}", flush=True)
            await self._voice.say("The robot is not free now. Ask me again later.")
            return
        try:
            words = f"Please follow the robot to the {place}."
            for _ in range(ATTEMPTS):
                await self._voice.say(words)
                try:
                    await legs.set(target_positions=(place,))
                    await legs.start()
                except FAILED as error:
                    print(f"the robot broke off: {error}", flush=True)
                    if isinstance(error, ComponentFailed) or not await has_again(self._client, ref, in_line=True):
                        break
                    words = f"We go on to the {place}."
                else:
                    await self._voice.say(f"Here we are: the {place}.")
                    return
            await self._voice.say("The robot cannot go on. Please wait there; I am here for you.")
        finally:
            with suppress(*FAILED):
                await legs.release()

    async def _places(self) -> list[str]:
        """Return the names of the things that the robot knows; none where it is away."""
        names: list[str] = []
        with suppress(LookupError, ValueError, *FAILED):
            for ref in await find(self._client, SURROUNDINGS, self._robot):
                things = await self._client.component(ref).query("things")
                names += [name for name, kind in zip(things["name"], things["kind"], strict=True) if kind != "person"]
        return names

    async def _answer(self, words: str, visitor: str, places: list[str]) -> str:
        can = f"I can lead you to: {', '.join(places) or 'no place now'}. Say stop, or goodbye."
        try:
            return (await self._talk.answer(words, visitor) if words else "") or can
        except (NoAnswer, *FAILED) as error:
            print(f"no small talk: {error}", flush=True)
            return f"I cannot think about that now. {can}"


async def main() -> None:
    """Serve visitors of one house."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gateway", default="ws://127.0.0.1:8765/")
    parser.add_argument("--robot", default="robot", help="the engine that leads visitors")
    parser.add_argument("--llm-url", default="", help="an OpenAI-compatible server: http://127.0.0.1:8080/v1")
    parser.add_argument("--note", type=Path, default="guide.visit", help="a file that is there during a visit")
    chosen = parser.parse_args()
    async with Client(chosen.gateway) as client:
        await Guide(client, chosen.robot, SmallTalk(client, chosen.llm_url), chosen.note).run()


if __name__ == "__main__":
    asyncio.run(main())
