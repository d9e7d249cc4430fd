"""STOP by another way than the link between gateways: as notifications of the database that they share."""

import asyncio
import logging
import secrets
from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import Final, Self

from openrois.aio.tasks import TaskScope
from openrois.cluster.postgres.calls import Calls
from openrois.cluster.postgres.database import Database
from openrois.cluster.postgres.stop_messages import (
    AnswerParts,
    StopAnswer,
    StopAsked,
    StopTold,
    answer_texts,
    question_text,
    read_message,
)
from openrois.errors import RoISError, StoreUnreachable

__all__ = ["ANSWER_TIME", "MAX_ASKED", "MAX_SERVED", "STOPPING_TIME", "StopHandler", "Stops"]

_log = logging.getLogger(__name__)

ANSWER_TIME: Final = 0.5
"""Seconds that a gateway waits for the owner's answer."""

STOPPING_TIME: Final = 5.0
"""Seconds that the owner gives a STOP; then it answers that it took too long."""

MAX_ASKED: Final = 64
"""Questions of one gateway that wait for an answer; one more is not sent."""

MAX_SERVED: Final = 64
"""Questions that one owner works at; one more is not answered."""

_TOPIC: Final = "stop"
_NOTIFY: Final = "SELECT pg_notify('openrois', $1 || ' ' || text) FROM unnest($2::text[]) AS said (text)"

StopHandler = Callable[[str, str, str, str], Awaitable[StopAnswer]]
"""Stops everything on an engine, for a subject of some rank, by the id of the STOP, and returns what became of it."""


@dataclass(frozen=True, slots=True)
class _Question:
    """A question that waits for its answer."""

    parts: AnswerParts
    answer: asyncio.Future[StopAnswer]


class Stops(AbstractAsyncContextManager["Stops"]):
    """Questions and answers of one gateway. Enter it as long as the gateway runs.

    A notification is delivered at once or never: what an owner misses while its connection to the database is made
    again is not repeated, and its asker gets no answer. Only gateways can connect to the database: what comes over it
    is believed, and the asker has checked what its subject may.

    Args:
        database: it is entered by the caller.
        gateway_id: of this gateway.

    Attributes:
        garbage: notifications that could not be read.
        turned_away: questions that were not answered because too many were worked at.
    """

    def __init__(self, database: Database, gateway_id: str) -> None:
        self.garbage = 0
        self.turned_away = 0
        self._database = database
        self._gateway_id = gateway_id
        self._calls = Calls(database, 1)
        self._questions: dict[str, _Question] = {}
        self._handler: StopHandler | None = None
        self._tasks = TaskScope()
        self._stack = AsyncExitStack()

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            self._tasks = await stack.enter_async_context(TaskScope())
            stack.callback(self._database.listen(_TOPIC, self._handle_text))
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._stack.aclose()

    def serve(self, handler: StopHandler) -> Callable[[], None]:
        """Answer questions about engines of this gateway with `handler`; return a function that ends that."""
        self._handler = handler

        def leave() -> None:
            self._handler = None

        return leave

    async def ask(
        self,
        gateway_id: str,
        engine_id: str,
        subject: str,
        timeout: float = ANSWER_TIME,
        *,
        rank: str = "",
        stop_id: str = "",
    ) -> StopAnswer:
        """Ask the owner of an engine to stop everything on it.

        Args:
            gateway_id: the owner.
            engine_id: the engine.
            subject: of the principal who wants it; the owner's audit trail names it.
            timeout: seconds until there is no answer.
            rank: of the principal; where it is a person's, programs wait from then on.
            stop_id: of the STOP; the owner makes one unless given.

        Returns:
            What became of it. Without an answer `problem` says why, and it may have happened.
        """
        if len(self._questions) >= MAX_ASKED:
            return _no_answer(f"{MAX_ASKED} other STOPs wait for an answer: ask again")
        question_id = secrets.token_hex(16)
        question = _Question(AnswerParts(gateway_id), asyncio.get_running_loop().create_future())
        self._questions[question_id] = question
        try:
            async with asyncio.timeout(timeout):
                names = (self._gateway_id, gateway_id, engine_id, subject, rank, stop_id)
                await self._send([question_text(question_id, *names)])
                return await question.answer
        except TimeoutError:
            return _no_answer(f"gateway {gateway_id} did not answer within {timeout:.2g} s over {self._database.name}")
        except StoreUnreachable as error:
            return _no_answer(str(error))
        finally:
            del self._questions[question_id]

    async def _send(self, texts: list[str]) -> None:
        async with self._calls.connection() as connection:
            await connection.execute(_NOTIFY, _TOPIC, texts)

    def _handle_text(self, text: str | None) -> None:
        if text is None:
            # Notifications may have been missed, and are not repeated.
            return
        match read_message(text):
            case StopAsked() as asked:
                self._handle_question(asked)
            case StopTold() as told:
                self._handle_answer(told)
            case None:
                self.garbage += 1
                _log.debug("a notification of a STOP cannot be read: %.100r", text)

    def _handle_question(self, asked: StopAsked) -> None:
        if asked.owner != self._gateway_id or self._handler is None:
            return
        if len(self._tasks) >= MAX_SERVED:
            self.turned_away += 1
            _log.error("a STOP of gateway %s is not answered: %d are worked at", asked.asker, MAX_SERVED)
            return
        self._tasks.start(self._serve(asked, self._handler))

    def _handle_answer(self, told: StopTold) -> None:
        question = self._questions.get(told.id)
        if told.asker != self._gateway_id or question is None:
            return
        answer = question.parts.add(told)
        if answer is not None and not question.answer.done():
            question.answer.set_result(answer)

    async def _serve(self, asked: StopAsked, handler: StopHandler) -> None:
        _log.info("gateway %s asks to stop everything on %s, for %s", asked.asker, asked.engine_id, asked.subject)
        try:
            async with asyncio.timeout(STOPPING_TIME):
                answer = await handler(asked.engine_id, asked.subject, asked.rank, asked.stop_id)
        except TimeoutError:
            answer = StopAnswer(problem=f"stopping takes longer than {STOPPING_TIME:.2g} s")
        except RoISError as error:
            answer = StopAnswer(problem=str(error))
        except Exception:
            _log.exception("a STOP of everything on %s failed", asked.engine_id)
            answer = StopAnswer(problem="stopping failed inside the gateway")
        try:
            await self._send(answer_texts(asked, answer))
        except StoreUnreachable as error:
            _log.warning("the answer to a STOP of gateway %s is lost: %s", asked.asker, error)


def _no_answer(problem: str) -> StopAnswer:
    return StopAnswer(problem=problem, is_answered=False)
