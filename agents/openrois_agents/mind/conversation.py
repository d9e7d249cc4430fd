"""Conversations of a mind with visitors, one at a time: each holds the body that was spoken to while it lasts."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine, Sequence
from contextlib import AsyncExitStack
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.client import RoISError
from openrois.types.references import engine_of
from openrois_agents.mind.body_stage import BodyStage
from openrois_agents.mind.consenting import Asked, Consents, Remembered, request_consent
from openrois_agents.mind.contract import Allowed, Mind, Turn
from openrois_agents.mind.figures import MindFigures
from openrois_agents.mind.limits import Budget
from openrois_agents.mind.news import CutShort, Item, News, Over
from openrois_agents.mind.showing import DIALOGUE, show_dialogue
from openrois_agents.mind.spoken import Spoken, yield_again, yielding_voice
from openrois_agents.mind.words import Words, is_addressed, is_goodbye, is_stop
from openrois_agents.tools.abilities import ABILITIES
from openrois_agents.tools.event_log import LoggedEvent
from openrois_agents.tools.failures import FAILURES
from openrois_agents.tools.held_body import HeldBody
from openrois_agents.tools.session import Session
from openrois_agents.tools.vocabulary import gestures_of

__all__ = ["SILENCE", "Conversations"]

_log = logging.getLogger(__name__)

SILENCE: Final = 60.0
"""Seconds after the last words, or the end of the last answer, after which a conversation is over."""

_MOVING: Final = 5.0
"""Seconds for which another body is waited for when the one of a conversation was lost."""

_LOOK: Final = 1.0
_BEATS: Final = ("beat", "explain", "nod", "tilt")
"""Small gestures that go with speech, the best first."""
_HERE_NOW: Final = "I go on here."
_WENT_WRONG: Final = "I am sorry, something went wrong."


class Conversations:
    """Leads conversations; `hear` is told of words, `run` is the work.

    Args:
        session: holds the body of a conversation.
        mind: answers.
        budget: says when there were enough turns.
        figures: are counted.
        wake_word: with which a visitor addresses the mind; empty where all words are for it.
        examples: returns what can be said, to be shown.
        pause: waits between two looks at the clock of the session.
    """

    def __init__(
        self,
        session: Session,
        mind: Mind,
        budget: Budget,
        figures: MindFigures,
        wake_word: str = "",
        examples: Callable[[], Sequence[str]] = tuple,
        pause: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._session = session
        self._mind = mind
        self._budget = budget
        self._figures = figures
        self._wake_word = wake_word
        self._examples = examples
        self._pause = pause
        self._tasks = TaskScope()
        self._news = News()
        self._voice = AsyncExitStack()
        self._spoken = Spoken()
        self._beats: Sequence[str] = ()
        self._answering: asyncio.Task[None] | None = None
        self._turns = 0
        self._answers = 0
        self._last_words = 0.0
        self._has_stopped = False
        """Whether it has stopped for what is being said."""
        self._refused = ""
        """The refusal that was said last; it is said once."""
        self._stopped_bodies: set[str] = set()
        self._remembered = Remembered(mind)
        self._asked = Asked(session.clock, SILENCE, figures)

    def hear(self, words: Words) -> None:
        """Take what a body has heard; what is still being said pushes nothing out."""
        self._news.add_words(words)

    async def run(self) -> None:
        """Lead conversations until cancelled; then the body is given back."""
        remove = self._session.log.added.add(self._news.add_event)
        try:
            async with self._tasks:
                self._tasks.start(self._watch_silence())
                try:
                    while True:
                        await self._take_safely(await self._news.take_next())
                finally:
                    await self._end("the mind ends")
        finally:
            remove()

    async def _take_safely(self, news: Item) -> None:
        """Take news; a mistake in that ends the conversation, and not those that come after it."""
        try:
            await self._take(news)
        except Exception:
            _log.exception("a conversation ends, as something went wrong in it")
            try:
                await self._end("something went wrong")
            except Exception:
                _log.exception("the body of a conversation could not be given back")

    async def _take(self, news: Item) -> None:
        match news:
            case Words():
                await self._take_words(news)
            case LoggedEvent():
                await self._take_event(news)
            case CutShort(answer) if answer == self._answers:
                await self._interrupt()
            case Over(answer) if answer == self._answers:
                await self._end("the conversation is over")

    async def _take_words(self, words: Words) -> None:
        held = self._session.held
        if words.body in self._stopped_bodies or (held is not None and held.engine_id != words.body):
            return
        if held is not None and is_stop(words.text, self._wake_word):
            await self._stop(final=words.final)
            return
        if not words.final:
            return
        self._has_stopped = False
        if is_stop(words.text, self._wake_word):
            return
        if not self._are_for_it(words):
            if words.text:
                # Speech to others silences the body, too, and begins nothing.
                await self._interrupt()
            return
        await self._interrupt()
        consents = await self._remembered.read_consents_at(self._session, words.body)
        if consents is None or self._asked.passes_over(words, consents.missing(words.visitor), lasts=held is not None):
            return
        if held is None and not await self._begin(words.body):
            return
        await self._answer_turn(words, consents)

    def _are_for_it(self, words: Words) -> bool:
        """Return whether words are for the mind.

        Speech that is not understood is, unless a wake word is missing in it, or the mind speaks: it may be its own.
        """
        if words.text:
            return is_addressed(words.text, self._wake_word)
        return not self._wake_word and not self._is_answering

    @property
    def _is_answering(self) -> bool:
        return self._answering is not None and not self._answering.done()

    async def _begin(self, body: str) -> bool:
        """Reserve a body for a conversation; return whether it has one."""
        self._budget.begin_conversation()
        refusal = self._budget.refusal()
        if refusal and refusal == self._refused:
            self._figures.refusals["limit"] += 1
            return False
        try:
            info = await self._session.body_info(body)
            tools = [tool for tool, ability in ABILITIES.items() if info.refs(ability.urn)]
            try:
                held = await self._session.use_body(body, tools, 0)
            except RoISError:
                held = await self._session.use_body(body, None, 0)
        except FAILURES as error:
            self._figures.refusals["busy"] += 1
            _log.info("%s was spoken to, and cannot answer: %s", body, error)
            return False
        self._turns = 0
        self._figures.conversations += 1
        await self._settle(held)
        return True

    async def _settle(self, held: HeldBody) -> None:
        """Learn what the body can that is held."""
        self._figures.holds = 1
        self._last_words = self._session.clock()
        gestures = await gestures_of(held.client, held.info) if "gesture" in held.tools else {}
        self._beats = tuple(each for each in _BEATS if each in gestures)
        await self._show(held)
        self._voice = AsyncExitStack()
        await self._voice.enter_async_context(self._remembered.following(held.client, held.info))
        self._spoken = await self._voice.enter_async_context(yielding_voice(held))

    async def _answer_turn(self, words: Words, consents: Consents) -> None:
        self._figures.turns += 1
        self._last_words = self._session.clock()
        if refusal := self._budget.refusal():
            self._figures.refusals["limit"] += 1
            self._refused = refusal
            self._start_saying(refusal, lambda: self._news.post(Over(self._answers)))
            return
        self._refused = ""
        if not self._remembered.may_stay(consents, words.visitor):
            # The words of one visitor are told again with those of another one.
            self._forget()
        if missing := consents.missing(words.visitor):
            self._figures.refusals["consent"] += 1
            self._forget()
            # The body is held until the visitor has been silent for long: it shows meanwhile what to agree to.
            self._start_saying(request_consent(missing), lambda: self._asked.add(words.visitor, missing))
            return
        self._asked.discard(words.visitor)
        self._remembered.add(words.visitor, consents)
        self._budget.count_turn()
        self._turns += 1
        turn = Turn(words.text, words.visitor, self._turns)
        self._start(self._answer(turn, is_goodbye(words.text, self._wake_word)))

    async def _answer(self, turn: Turn, ends: bool) -> None:
        async with self._stage() as stage:
            try:
                if await self._ask_mind(turn, stage):
                    self._figures.answers += 1
            except asyncio.CancelledError:
                self._figures.interruptions += 1
                self._mind.interrupted(stage.heard)
                raise
            finally:
                self._last_words = self._session.clock()
        if ends:
            self._news.post(Over(self._answers))

    async def _ask_mind(self, turn: Turn, stage: BodyStage) -> bool:
        """Let the mind answer; return whether it did. One that fails is logged, and the visitor is told."""
        try:
            await self._mind.answer(turn, stage)
        except Exception:
            _log.exception("the mind failed in an answer")
            await stage.say(_WENT_WRONG)
            await stage.all_said()
            return False
        await stage.all_said()
        return True

    def _start_saying(self, text: str, is_said: Callable[[], None] = lambda: None) -> None:
        async def say() -> None:
            async with self._stage() as stage:
                await stage.say(text)
                await stage.all_said()
            is_said()

        self._start(say())

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        self._answers += 1
        self._answering = self._tasks.start(work)

    def _stage(self) -> BodyStage:
        held, number = self._session.held, self._answers

        def cut() -> None:
            self._news.post(CutShort(number))

        async def allowed() -> Allowed:
            if held is None:
                return Allowed(words=False, pictures=False)
            return self._remembered.allowed(await self._remembered.read_consents(held.client, held.info))

        has_eyes = held is not None and "look_at" in held.tools
        return BodyStage(self._session, self._spoken, self._beats, has_eyes, allowed, self._count_sound, cut)

    def _count_sound(self, seconds: float) -> None:
        self._figures.sound += seconds
        self._budget.count_sound(seconds)

    async def _interrupt(self) -> None:
        """Cancel the answer, and what it began."""
        if self._answering is not None and self._is_answering:
            self._answering.cancel()
            await asyncio.wait({self._answering})
        self._answering = None

    async def _stop(self, *, final: bool) -> None:
        """Stop all that the body does, at once, and once for what is being said."""
        self._last_words = self._session.clock()
        if not self._has_stopped:
            self._figures.stops += 1
            await self._interrupt()
            try:
                held = self._session.require_body()
                await held.client.control.stop_all(held.engine_id)
            except FAILURES as error:
                _log.warning("the body could not be stopped: %s", error)
        self._has_stopped = not final

    async def _take_event(self, event: LoggedEvent) -> None:
        match event.name:
            case "stopped_by_a_person":
                self._stopped_bodies.add(event.source)
                if self._session.held is not None and self._session.held.engine_id == event.source:
                    await self._end("a person stopped the body")
            case "handed_back_by_a_person":
                self._stopped_bodies.discard(event.source)
            case "part_taken_for_a_time":
                await self._interrupt()
            case "part_came_back":
                await self._set_again(event.source)
            case "body_lost":
                await self._move(event.source)

    async def _set_again(self, came_back: str) -> None:
        """Set again what a component has forgotten, or its borrower has changed."""
        held = self._session.held
        if held is not None and held.body.error is None and engine_of(came_back) == held.engine_id:
            if came_back in held.info.refs(DIALOGUE):
                await self._show(held)
            await yield_again(held, came_back)

    async def _show(self, held: HeldBody) -> None:
        await show_dialogue(held, self._mind.sends_to, self._examples(), self._wake_word)

    async def _move(self, lost: str) -> None:
        """Go on with another body, where one is free."""
        held = self._session.held
        if held is None or held.engine_id != lost or held.body.error is None:
            return
        await self._interrupt()
        await self._voice.aclose()
        try:
            now = await self._session.use_body(None, None, _MOVING)
        except FAILURES as error:
            _log.info("%s was lost, and no other body is free: %s", lost, error)
            await self._end(f"{lost} was lost")
            return
        _log.info("%s was lost: the conversation goes on with %s", lost, now.engine_id)
        self._figures.moves += 1
        await self._settle(now)
        self._start_saying(_HERE_NOW)

    async def _end(self, reason: str) -> None:
        """End the conversation, if there is one: the body is free then, and the mind has forgotten it."""
        await self._interrupt()
        try:
            await self._voice.aclose()
        finally:
            try:
                await self._session.give_back(reason)
            finally:
                if self._figures.holds:
                    self._figures.holds = 0
                    self._forget()

    def _forget(self) -> None:
        self._mind.forget()
        self._remembered.forget_visitors()

    async def _watch_silence(self) -> None:
        while True:
            await self._pause(_LOOK)
            silence = self._session.clock() - self._last_words
            if self._figures.holds and not self._is_answering and silence > SILENCE:
                self._news.post(Over(self._answers))
