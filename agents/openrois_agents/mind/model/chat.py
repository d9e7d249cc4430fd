"""The client of a server with an API like OpenAI's chat completions: replies as they arrive."""

from collections.abc import AsyncGenerator, AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, aclosing, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Self

from openrois_body.services.address import ServiceAddress
from openrois_body.services.events import EventReader, MalformedEvents
from openrois_body.services.server import Answer, Server, ServerFailed, ServerRefused

from openrois_agents.mind.model.reply import BadReply, Delta, read_delta

__all__ = ["MAX_ANSWER", "PATH", "PATIENCE", "Chat", "ModelSettings", "ServerFailed"]

PATH: Final = "chat/completions"
"""What a server is asked for."""

MAX_ANSWER: Final = 4_000_000
"""Bytes of an answer; each token comes with some hundred more."""

PATIENCE: Final = 60.0
"""Seconds for which an answer is waited for in all, what is thought and not told included."""

_STREAMS: Final = frozenset({"", "text/event-stream"})
_WHOLE: Final = "application/json"
_END: Final = "[DONE]"
_WITH_USAGE: Final = MappingProxyType({"stream_options": {"include_usage": True}})


@dataclass(frozen=True, slots=True)
class ModelSettings:
    """Which language model answers.

    Attributes:
        url: of its server.
        model: its name there.
        key_file: holds the key for the server; None: it wants none.
        sees: whether it is shown pictures.
    """

    url: ServiceAddress
    model: str
    key_file: Path | None = None
    sees: bool = False


class Chat:
    """Asks a server; `async with` it.

    Args:
        settings: the server, the model and the key.
    """

    def __init__(self, settings: ModelSettings) -> None:
        self._model = settings.model
        self._tells_usage: bool | None = None
        """Whether the server tells what an answer has used; None before it has answered."""
        self._server = Server(settings.url, "the language model", "--llm-url", settings.key_file)

    async def __aenter__(self) -> Self:
        await self._server.__aenter__()
        return self

    async def __aexit__(self, *_failure: object) -> None:
        await self._server.__aexit__(None, None, None)

    @asynccontextmanager
    async def asking(
        self, messages: Sequence[Mapping[str, Any]], tools: Sequence[Mapping[str, Any]], *, may_call: bool
    ) -> AsyncIterator[AsyncGenerator[Delta]]:
        """Ask for a reply, which arrives while the block runs; leaving it closes the connection.

        Args:
            messages: the conversation.
            tools: that the model has.
            may_call: whether it may call them now.

        Raises:
            ServerFailed: the server is away, refuses, stalls, floods, or what it sends is no reply. Its sentence does
                not have the key.
        """
        asked = {
            "model": self._model,
            "messages": messages,
            "stream": True,
        }
        if tools:
            asked |= {"tools": tools, "tool_choice": "auto" if may_call else "none"}
        async with self._answer(asked) as answer, aclosing(self._deltas(answer)) as deltas:
            yield deltas

    @asynccontextmanager
    async def _answer(self, asked: Mapping[str, Any]) -> AsyncIterator[Answer]:
        """Ask for the usage as well, unless the server is one of those that refuse that."""
        async with AsyncExitStack() as stack:
            answer = None
            if self._tells_usage is not False:
                try:
                    answer = await stack.enter_async_context(self._server.post(PATH, {**asked, **_WITH_USAGE}))
                    self._tells_usage = True
                except ServerRefused:
                    if self._tells_usage:
                        raise
            if answer is None:
                answer = await stack.enter_async_context(self._server.post(PATH, asked))
                self._tells_usage = False
            yield answer

    async def _deltas(self, answer: Answer) -> AsyncGenerator[Delta]:
        try:
            if answer.kind == _WHOLE:
                yield read_delta(await answer.text(MAX_ANSWER))
                return
            if answer.kind not in _STREAMS:
                raise BadReply(f"it answers {answer.kind[:80]}, not {'/'.join(sorted(_STREAMS)).strip('/')}")
            reader = EventReader()
            async with aclosing(answer.parts(MAX_ANSWER, PATIENCE)) as parts:
                async for part in parts:
                    for event in reader.add(part):
                        if event.strip() == _END:
                            return
                        yield read_delta(event)
        except (BadReply, MalformedEvents) as error:
            said = self._server.without_key(str(error))
            raise ServerFailed(f"{self._server.name} cannot be used: {said}; check --llm-url and --llm-model") from None
