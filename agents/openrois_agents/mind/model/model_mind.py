"""A mind that a language model is: it speaks while the model goes on, and acts by the tools that the model calls."""

import asyncio
import base64
import json
import logging
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import aclosing
from typing import Any, Final, Self

from openrois_agents.mind.contract import Stage, Turn
from openrois_agents.mind.limits import Budget
from openrois_agents.mind.model.chat import Chat, ModelSettings, ServerFailed
from openrois_agents.mind.model.figures import ModelFigures
from openrois_agents.mind.model.history import History
from openrois_agents.mind.model.pacing import with_pauses
from openrois_agents.mind.model.prompts import FAILED, INSTRUCTIONS, LOST_THREAD, NO_ANSWER, WITHDRAWN, visitor_text
from openrois_agents.mind.model.reply import BadReply, Reply, ToolCall, estimate_tokens
from openrois_agents.mind.model.sentences import Sentences
from openrois_agents.mind.model.tool_choice import LOOK, USABLE, mistake_in, tool_schemas
from openrois_agents.tools.failures import FAILURES
from openrois_agents.tools.names import Vocabulary

__all__ = ["MAX_AT_ONCE", "MAX_ROUNDS", "SETTLING", "ModelMind"]

_log = logging.getLogger(__name__)

MAX_ROUNDS: Final = 5
"""Requests for one turn; at the last one no tool can be called."""

MAX_AT_ONCE: Final = 4
"""Calls of tools of one reply that are made; the others are refused."""

SETTLING: Final = 0.06
"""Seconds without a token after which a sentence that seems whole is spoken."""


class ModelMind:
    """A `Mind`; `async with` it.

    Args:
        settings: which model answers.
        budget: counts its tokens, and is asked between its requests.
        figures: are counted.
        clock: monotonic seconds.

    Attributes:
        sends_to: where words of visitors are sent; empty where that is this machine.
        figures: as above.
    """

    needs_visitor = True

    def __init__(
        self,
        settings: ModelSettings,
        budget: Budget,
        figures: ModelFigures | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.sends_to = settings.url.destination
        self.figures = figures or ModelFigures()
        self._tools = frozenset(USABLE) - (frozenset() if settings.sees else {LOOK})
        self._chat = Chat(settings)
        self._budget = budget
        self._clock = clock
        self._history = History()
        self._has_said = False

    async def __aenter__(self) -> Self:
        await self._chat.__aenter__()
        return self

    async def __aexit__(self, *_failure: object) -> None:
        await self._chat.__aexit__()

    async def answer(self, turn: Turn, stage: Stage) -> None:
        """Answer a turn; return when the answer was heard. A server that fails is a polite sentence and a line."""
        self._history.begin_turn(visitor_text(turn.text, turn.visitor))
        self._has_said = False
        try:
            if not await self._converse(stage):
                await stage.say(NO_ANSWER)
        except ServerFailed as error:
            self.figures.failures += 1
            _log.warning("%s", error)
            await stage.say(LOST_THREAD if self._has_said else FAILED)
        except asyncio.CancelledError:
            self.figures.interruptions += 1
            raise
        await stage.all_said()

    def interrupted(self, heard: str) -> None:
        """Keep of the answer what was heard."""
        self._history.cut(heard)

    def forget(self) -> None:
        """Forget the conversation."""
        self._history.forget_turns()

    async def _converse(self, stage: Stage) -> bool:
        """Ask and act until the model has answered; return whether it said or did anything."""
        schemas = tool_schemas(self._tools, await _names(stage))
        has_acted = False
        for left in range(MAX_ROUNDS - 1, -1, -1):
            allowed = await stage.allowed()
            if not allowed.words:
                # What waits to be sent is dropped.
                self._history.forget_turns()
                await stage.say(WITHDRAWN)
                return True
            if not allowed.pictures:
                self._history.withhold_pictures()
            calls = await self._speak(stage, schemas, may_call=left > 0)
            if not calls or not left:
                break
            has_acted = True
            self._history.add_calls(calls)
            await self._act(stage, calls)
            self._history.go_on()
            if not self._budget.tokens_left:
                # What may be used is used up: the model is not asked what it says to that.
                if not self._has_said:
                    await stage.say(self._budget.refusal())
                break
        return has_acted or self._has_said

    async def _speak(
        self, stage: Stage, schemas: Sequence[Mapping[str, Any]], *, may_call: bool
    ) -> tuple[ToolCall, ...]:
        """Say a reply while it arrives; return the calls of tools that it makes.

        Raises:
            ServerFailed: the server gave no whole reply.
        """
        messages = self._history.messages(INSTRUCTIONS)
        reply, sentences, began = Reply(), Sentences(), self._clock()
        self.figures.requests += 1
        try:
            async with (
                self._chat.asking(messages, schemas, may_call=may_call) as deltas,
                aclosing(with_pauses(deltas, SETTLING)) as arriving,
            ):
                async for delta in arriving:
                    whole = sentences.settle() if delta is None else sentences.add(reply.add(delta))
                    await self._say(stage, whole)
                    if reply.is_full:
                        _log.info("a reply of the language model was cut: it is too long to be spoken")
                        return reply.calls
        except BadReply as error:
            raise ServerFailed(f"the reply of the language model is refused: {error}") from None
        finally:
            self._count(messages, schemas, reply, self._clock() - began)
        await self._say(stage, sentences.finish())
        return reply.calls

    async def _say(self, stage: Stage, sentences: Sequence[str]) -> None:
        for sentence in sentences:
            self._history.add_said(sentence)
            self._has_said = True
            await stage.say(sentence)

    async def _act(self, stage: Stage, calls: Sequence[ToolCall]) -> None:
        """Call tools side by side, and tell their results."""
        self.figures.tool_calls += len(calls)
        async with asyncio.TaskGroup() as tasks:
            for number, call in enumerate(calls):
                if number < MAX_AT_ONCE:
                    tasks.create_task(self._call(stage, call))
                else:
                    self._refuse(call, f"not called: no more than {MAX_AT_ONCE} tools are called at once")

    async def _call(self, stage: Stage, call: ToolCall) -> None:
        arguments = call.arguments()
        mistake = mistake_in(call.name, arguments, self._tools)
        if mistake or arguments is None:
            self._refuse(call, mistake)
            return
        answer = await stage.use(call.name, arguments)
        self._history.add_result(call, answer.text)
        if answer.picture:
            picture = base64.b64encode(answer.picture).decode()
            self._history.add_picture(call, f"data:image/jpeg;base64,{picture}")

    def _refuse(self, call: ToolCall, reason: str) -> None:
        self.figures.refused_calls += 1
        self._history.add_result(call, reason)

    def _count(self, messages: Any, schemas: Any, reply: Reply, seconds: float) -> None:
        """Count what a request has used: as the server says, but no less than what it was seen to write."""
        read, written = 0, reply.written
        if reply.usage is not None:
            read, written = reply.usage.read, max(written, reply.usage.written)
        if not read:
            # A request is never empty: a server that says so, or nothing, is not believed.
            read = estimate_tokens(json.dumps([messages, schemas], ensure_ascii=False))
        self.figures.read += read
        self.figures.written += written
        self.figures.seconds += seconds
        self._budget.count_tokens(read + written)


async def _names(stage: Stage) -> Vocabulary:
    """Return the names that can be chosen; none where the gateway does not tell, as each call of a tool says then."""
    try:
        return await stage.vocabulary()
    except FAILURES:
        return Vocabulary()
