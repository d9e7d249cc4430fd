"""A voice that speaks through one body or another, and what became of a part that was lost; `guide.py` uses both."""

import asyncio
from contextlib import AsyncExitStack, suppress

from openrois.client import Body, Client, ConnectionLost, ControlChanged, RoISError
from openrois.client.components import SpeechSynthesis
from openrois.types.leases import LeaseState

FAILED = (RoISError, ConnectionLost, TimeoutError)
"""What an operation at the gateway raises where it fails."""
ATTEMPTS = 5
"""How often a sentence is said that was broken off."""
WAIT = 120.0
"""Seconds until a body is free."""
LATE = 3
"""Texts that wait for a body; of more only the last ones are said."""
LOAN = 600.0
"""Seconds until a person has given a part back."""


async def has_again(client: Client, component_ref: str, *, in_line: bool = False) -> bool:
    """Wait while a person has borrowed a part; tell whether the guide has it then. `in_line`: or until it gets it."""
    with suppress(*FAILED):
        async with asyncio.timeout(LOAN), client.notices(ControlChanged) as changes:
            # A lost connection is waited for, too.
            lease = await client.control.status(component_ref)
            while lease.return_position:
                await anext(changes)
                lease = await client.control.status(component_ref)
            if lease.state is LeaseState.MINE:
                return not lease.stopped_by
            if in_line:
                await client.control.request(component_ref, wait=True)
                return True
    return False


class Voice:
    """Speaks through a body that is free, and through another one when that is lost."""

    def __init__(self, client: Client) -> None:
        self.body: Body | None = None
        self._client = client
        self._held = AsyncExitStack()
        self._turn = asyncio.Lock()
        self._broke_off = False
        self._late: list[str] = []

    @property
    def component_ref(self) -> str:
        """What speaks; empty while no body is held."""
        return "" if self.body is None else self.body[SpeechSynthesis].component_ref

    @property
    def is_lost(self) -> bool:
        """Whether the body does not speak for the guide any more."""
        return self.body is not None and (self._broke_off or self.body.error is not None)

    async def say(self, text: str) -> None:
        """Return when a text was heard; what was broken off is said again, and what no body could say before it."""
        async with self._turn:
            late = [*self._late, text] if text else self._late
            if not late:
                return
            whole = " ".join(late)
            for _ in range(ATTEMPTS):
                if self.body is not None and self.is_lost:
                    whole = f"I had to leave the {self.body.engine_id}, and go on here. {whole}"
                    await self.rest()
                try:
                    if self.body is None:
                        self.body = await self._held.enter_async_context(self._client.body(SpeechSynthesis, wait=WAIT))
                except FAILED as error:
                    print(f"no body is free: {error}", flush=True)
                    break
                speech = self.body[SpeechSynthesis]
                try:
                    await speech.set(speech_text=whole)
                    await speech.start()
                except FAILED as error:
                    print(f"{self.body.engine_id} broke off: {error}", flush=True)
                    self._broke_off = not await has_again(self._client, speech.component_ref)
                else:
                    print(f"{self.body.engine_id} said: {whole}", flush=True)
                    self._late = []
                    return
            self._late = late[-LATE:]

    async def say_late(self) -> None:
        """Say what no body could say, if there is such a thing, and a voice is free for it now."""
        if not self._late:
            return
        if self.body is None or self.is_lost:
            voices = [(info, ref) for info in await self._client.bodies() for ref in info.refs(SpeechSynthesis)]
            if not any(each.free for info, ref in voices for each in info.components if each.component_ref == ref):
                return
        await self.say("")

    async def rest(self) -> None:
        """Give the body back, and forget what it could not say."""
        self.body, self._broke_off, self._late = None, False, []
        with suppress(*FAILED):
            await self._held.aclose()
