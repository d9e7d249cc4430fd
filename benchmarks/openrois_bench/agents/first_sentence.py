"""How soon the first sentence of a language model is heard: `python -m openrois_bench.agents.first_sentence`.

In the repository; `--quick` for a first look. A server on this machine streams tokens; a mind says its sentences
through an avatar behind a gateway, all in one process, so that all moments are of one clock. The time is counted from
the moment at which the server has written the last token of the first sentence to that of the first sound: in the
own sound of the body, and at the ear of a viewer over WebRTC.
"""

import argparse
import asyncio
import json
import sys
import tempfile
from collections.abc import Sequence
from contextlib import AsyncExitStack
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from openrois_agents.mind.body_stage import BodyStage
from openrois_agents.mind.contract import Allowed, Turn
from openrois_agents.mind.limits import Budget, Limits
from openrois_agents.mind.model.chat import ModelSettings
from openrois_agents.mind.model.model_mind import ModelMind
from openrois_agents.mind.spoken import yielding_voice
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings

from openrois.client import Client
from openrois_bench.clone import require_clone
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import MILLISECONDS, Percentiles
from openrois_bench.measuring.result import write_result
from openrois_bench.viewing.ear import Ear, listening

if TYPE_CHECKING:
    from aiohttp import web

    from tests.support.chat_server import Behaviour, ChatServer

__all__ = ["main"]

_FIRST: Final = ("Good", " day", ", I", " am", " the", " avatar", ".")
_SECOND: Final = (" What", " may", " I", " do", "?")
_TOKEN: Final = 0.02
"""Seconds between two tokens: fifty in a second."""
_PAUSE: Final = 1.0
"""Seconds for which a model is silent behind its first sentence."""
_LOUD: Final = 300
"""Of 32,767: a voice begins softly."""
_PLENTY: Final = Limits(10**9, 10**9, 1e9)


async def _allow() -> Allowed:
    return Allowed(words=True, pictures=True)


def _count(_seconds: float) -> None:
    """Count no speech."""


def _cut() -> None:
    raise AssertionError("no visitor speaks")


def _tokens(pause: float) -> "Behaviour":
    """Return a server's behaviour: tokens at their pace, and a pause between the sentences."""

    async def answer(server: "ChatServer", request: "web.Request") -> "web.StreamResponse":
        from tests.support.chat_server import TEXT, chunk  # a wheel has no tests
        from tests.support.http_answers import begin, event

        response = await begin(request, TEXT)
        for number, token in enumerate((*_FIRST, *_SECOND)):
            await asyncio.sleep(pause if number == len(_FIRST) else _TOKEN)
            await response.write(event(chunk({"content": token})))
            server.written.append(asyncio.get_running_loop().time())
        await response.write(b"data: [DONE]\n\n")
        return response

    return answer


async def _answer(
    mind: ModelMind, stage: BodyStage, server: "ChatServer", ear: Ear, pause: float
) -> tuple[float, float]:
    """Return the seconds from the last token of the first sentence to its sound, in the body and at the ear."""
    mind.forget()
    await ear.silent_for(0.7)
    ear.forget_heard()
    server.written.clear()
    server.script.append(_tokens(pause))
    await mind.answer(Turn("hello", "", 1), stage)
    assert ear.first is not None, "the answer was heard"
    written = server.written[len(_FIRST) - 1]
    return ear.first[0] - written, ear.first[1] - written


async def measure(runs: int) -> dict[str, Any]:
    """Return all figures, in milliseconds."""
    from tests.support.chat_server import chat_server  # a wheel has no tests
    from tests.support.operated import operated_avatar

    found: dict[str, list[tuple[float, float]]] = {"the model goes on": [], "the model pauses": []}
    async with AsyncExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        gateway, _ = await stack.enter_async_context(operated_avatar(Path(folder)))
        url = gateway.url.replace("http", "ws")
        ear = await stack.enter_async_context(listening(gateway, _LOUD))
        session = await stack.enter_async_context(Session(lambda: Client(url), ToolSettings()))
        held = await session.use_body(None, ["say"], 10.0)
        voice = await stack.enter_async_context(yielding_voice(held))
        stage = await stack.enter_async_context(BodyStage(session, voice, (), False, _allow, _count, _cut))
        server = await stack.enter_async_context(chat_server())
        budget = Budget(_PLENTY, _PLENTY, date.today)
        mind = await stack.enter_async_context(ModelMind(ModelSettings(server.address, "scripted"), budget))
        # The first one loads the voice, and opens the connection.
        await _answer(mind, stage, server, ear, _TOKEN)
        for number in range(runs):
            for name, pause in (("the model goes on", _TOKEN), ("the model pauses", _PAUSE)):
                found[name].append(await _answer(mind, stage, server, ear, pause))
            print(f"{number + 1} of {runs}", file=sys.stderr)
    return {
        f"{name}: to {where}": Percentiles.of((each[index] for each in times), MILLISECONDS).model_dump()
        for name, times in found.items()
        for index, where in enumerate(("the body's sound", "the ear"))
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.agents.first_sentence", description=__doc__)
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--quick", action="store_true", help="three runs")
    parser.add_argument("--json", type=Path, help="where the figures are written to")
    chosen = parser.parse_args(arguments)
    require_clone()
    before = load()
    figures = asyncio.run(measure(3 if chosen.quick else chosen.runs))
    found = conditions(before)
    print(f"{found}\n\nmilliseconds from the last token of the first sentence:")
    print(json.dumps(figures, indent=1))
    write_result(chosen.json, "openrois_bench.agents.first_sentence", found, summary=figures)


if __name__ == "__main__":
    main()
