"""The page on visitors: its programs run as they are written."""

import asyncio
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from openrois_streaming.clock import SystemClock
from openrois_streaming.synthetic import ColourBars, Tone

from openrois.client import Client
from openrois.types.codes import Purpose
from tests.media.visitors.test_listening import Body, body, token, until

pytestmark = pytest.mark.media

__all__ = ["body"]

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs/how-to/visitors.md").read_text(encoding="utf-8")


def pieces(one: Body, role: str) -> dict[str, Any]:
    """Return what all pieces define; an application of theirs has this role at this body, which is called `robot`."""
    defined: dict[str, Any] = {"__name__": "guide"}
    for number, piece in enumerate(re.findall(r"^```python\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)):
        code = piece.replace('"avatar"', '"robot"')
        exec(compile(code, f"docs/how-to/visitors.md, piece {number}", "exec"), defined)
    return defined | {"Client": lambda: Client(one.url, token=token(role))}


async def test_an_adapter_reads_a_visitor_for_what_it_is_for(body: Body) -> None:
    defined, heard = pieces(body, "visitor"), asyncio.Event()
    assert {name: stream.kind for name, stream in defined["streams"].items()} == {"ears": "audio", "eyes": "video"}
    hear = defined["hear"]
    hear.__globals__.update(understand=lambda _samples: heard.set())
    async with body.application("visitor") as media:
        sending = media.send(microphone=Tone(clock=SystemClock()), consent=[Purpose.LIVE])
        async with sending as sent:
            hearing = asyncio.ensure_future(hear(body.visitors.present[0]))
            await sent.consent(Purpose.AGENT)
            async with asyncio.timeout(30):
                await heard.wait()
            hearing.cancel()
            with suppress(asyncio.CancelledError):
                await hearing


async def test_what_visits_is_understood_by_what_listens(body: Body) -> None:
    clock, understood = SystemClock(), asyncio.Event()
    visiting, listening = pieces(body, "visitor"), pieces(body, "listener")
    visit, listen = visiting["visit"], listening["listen"]
    visit.__globals__.update(Client=visiting["Client"])
    listen.__globals__.update(Client=listening["Client"], understand=lambda _samples: understood.set())
    sending = asyncio.ensure_future(visit(ColourBars(160, 120, 15, clock=clock), Tone(clock=clock)))
    # The guide's visitor takes the agent's part back at once: it is given again for what listens.
    await until(lambda: body.visitors.present and body.visitors.present[0].consent.purposes == {Purpose.LIVE})
    body.visitors.present[0].state(frozenset({Purpose.LIVE, Purpose.AGENT}))
    hearing = asyncio.ensure_future(listen())
    async with asyncio.timeout(30):
        await understood.wait()
    for task in (hearing, sending):
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task
