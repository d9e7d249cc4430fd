"""The stage of one answer: sentences are queued, and spoken one behind another, and gestures go with them."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping, Sequence
from types import TracebackType
from typing import Any, Final, Self

from openrois.aio.tasks import TaskScope
from openrois_agents.mind.contract import Allowed
from openrois_agents.mind.spoken import Spoken
from openrois_agents.tools.answer import Answer
from openrois_agents.tools.failures import failure
from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.session import Session
from openrois_agents.tools.toolbox import TOOLS, call_tool

__all__ = ["MAX_WAITING", "BodyStage"]

_log = logging.getLogger(__name__)

MAX_WAITING: Final = 4
"""Sentences that wait to be spoken; a mind waits while there are more."""

_LONGEST: Final = 4_000
"""Characters of a sentence, as `say` takes them."""

_OF_THE_CONVERSATION: Final = frozenset({"use_body", "give_back"})
"""Tools that are no mind's: the conversation holds the body."""

_MOVES: Final = frozenset({"gesture", "look_at", "go_to", "call"})
"""Tools that move: where one was asked for, no small gesture goes with the words."""

_UNSEEN: Final = "Unsupported: no picture is taken while a visitor is here who does not consent to that"


class BodyStage:
    """Where one answer is given: a `Stage`. Leaving the block stops what it began.

    Args:
        session: holds the body.
        spoken: how much of what is being said was heard.
        beats: small gestures of the body that go with speech, the first one that may be made; none where it has none.
        has_eyes: whether the body can look at the visitor.
        allowed: asks what may go to a model now.
        count_sound: told of seconds of speech.
        cut: called when speech was broken off from outside, as a visitor began to speak.
    """

    def __init__(
        self,
        session: Session,
        spoken: Spoken,
        beats: Sequence[str],
        has_eyes: bool,
        allowed: Callable[[], Awaitable[Allowed]],
        count_sound: Callable[[float], None],
        cut: Callable[[], None],
    ) -> None:
        self._session = session
        self._spoken = spoken
        self._beats = beats
        self._has_eyes = has_eyes
        self._allowed = allowed
        self._count_sound = count_sound
        self._cut = cut
        self._tasks = TaskScope()
        self._waiting: asyncio.Queue[str] = asyncio.Queue(MAX_WAITING)
        self._said: list[str] = []
        self._saying = ""
        self._small: asyncio.Task[None] | None = None
        self._is_moving = False
        self._has_stopped = False
        """Whether the mind itself has stopped what is being said: that is no interruption."""

    async def __aenter__(self) -> Self:
        self._tasks.start(self._speak())
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop what is still said, and the gesture that goes with it."""
        await self._tasks.__aexit__(kind, error, trace)

    @property
    def heard(self) -> str:
        """What was heard so far of this answer."""
        begun = self._spoken.heard_of(self._saying)
        return " ".join(each for each in (*self._said, begun) if each)

    async def say(self, text: str) -> None:
        """Queue a sentence; return before it is heard, but wait while four wait already."""
        if text.strip():
            await self._waiting.put(text[:_LONGEST])

    async def use(self, tool: str, arguments: Mapping[str, Any]) -> Answer:
        """Call a tool; one that fails is answered too."""
        if tool not in TOOLS or tool in _OF_THE_CONVERSATION:
            return Answer(f"Unsupported: there is no tool {tool!r} in a conversation", {"failed": "Unsupported"})
        if tool == "look" and not (await self.allowed()).pictures:
            return Answer(_UNSEEN, {"failed": "Unsupported"})
        if tool in _MOVES:
            self._is_moving = True
            await self._end_small_gesture()
        if tool == "stop":
            self._has_stopped = True
        return await self._call(tool, arguments)

    async def all_said(self) -> None:
        """Wait until the queued sentences were heard."""
        await self._waiting.join()

    async def vocabulary(self) -> Vocabulary:
        """Return the names that can be chosen now."""
        return await self._session.vocabulary()

    async def allowed(self) -> Allowed:
        """Ask anew what may go to a model."""
        return await self._allowed()

    async def _speak(self) -> None:
        while True:
            self._saying = await self._waiting.get()
            self._has_stopped = False
            self._spoken.begin_sentence()
            self._make_small_gesture()
            began = self._session.clock()
            try:
                answer = await self._call("say", {"text": self._saying})
            finally:
                self._count_sound(self._session.clock() - began)
            match answer.data.get("failed"):
                case None:
                    self._said.append(self._saying)
                case "Aborted" if self._has_stopped:
                    self._said.append(self._spoken.heard_of(self._saying))
                case "Aborted":
                    # What was heard of it stays, and nothing more is said.
                    self._cut()
                    return
                case _:
                    _log.warning("a sentence was not said: %s", answer.text)
            self._saying = ""
            self._waiting.task_done()

    def _make_small_gesture(self) -> None:
        """Let a small gesture go with an answer, or a look, unless it moves by itself."""
        if self._small is None and not self._is_moving:
            if self._beats:
                self._small = self._tasks.start(self._do("gesture", {"name": self._beats[0]}))
            elif self._has_eyes:
                self._small = self._tasks.start(self._do("look_at", {"direction": "ahead"}))

    async def _end_small_gesture(self) -> None:
        if self._small is not None and not self._small.done():
            self._small.cancel()
            await asyncio.wait({self._small})

    async def _do(self, tool: str, arguments: Mapping[str, Any]) -> None:
        answer = await self._call(tool, arguments)
        if "failed" in answer.data:
            _log.debug("no gesture goes with the words: %s", answer.text)

    async def _call(self, tool: str, arguments: Mapping[str, Any]) -> Answer:
        try:
            return await call_tool(self._session, tool, dict(arguments), _report)
        except Exception as error:
            kind, text = failure(tool, error)
            return Answer(text, {"failed": kind})


async def _report(_seconds: float, _what: str) -> None:
    """Report to no host."""
