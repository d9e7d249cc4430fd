"""Handlers of methods, their replies, and params that do not fit."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from itertools import islice
from typing import Any, Final, TypeVar

from pydantic import BaseModel, ValidationError

__all__ = ["MAX_PROBLEMS", "Handler", "InvalidParams", "NotificationHandler", "Reply", "method", "params_reader"]

MAX_PROBLEMS: Final = 16
"""Problems that one -32602 lists; their number is the sender's choice."""

_MAX_PATH: Final = 200
_MAX_MEMBERS: Final = 64
"""Members of params that are read: no method has as many, so that what is left out changes nothing."""


@dataclass(frozen=True, slots=True)
class Reply:
    """A result, and what belongs to its reply.

    Attributes:
        result: the result.
        then: what to do once the reply stands in the outbox: notifications put there come after it.
        reason: why the result is a refusal; empty where it is none.
    """

    result: Any
    then: Callable[[], None] | None = None
    reason: str = ""


Handler = Callable[[dict[str, Any]], Awaitable[Any]]
"""Answers one method: params in, the result or a `Reply` out."""

NotificationHandler = Callable[[dict[str, Any]], None]
"""Handles one notification; must not block."""


class InvalidParams(Exception):
    """The params do not fit the method: answered with -32602.

    Attributes:
        problems: a list of `{"path": dotted path, "message": sentence}`.
    """

    def __init__(self, problems: list[dict[str, str]]) -> None:
        super().__init__("; ".join(f"{problem['path']}: {problem['message']}" for problem in problems))
        self.problems = problems


Params = TypeVar("Params", bound=BaseModel)


def method(model: type[Params], function: Callable[[Params], Awaitable[Any]]) -> Handler:
    """Return a handler that reads its params with `model` and passes them on."""
    read = params_reader(model)
    return lambda params: function(read(params))


def params_reader(model: type[Params]) -> Callable[[dict[str, Any]], Params]:
    """Return a function that reads params with `model`, and raises `InvalidParams` where they do not fit."""
    validate: Callable[[dict[str, Any]], Params] = model.__pydantic_validator__.validate_python

    def read(params: dict[str, Any]) -> Params:
        if len(params) > _MAX_MEMBERS:
            params = dict(islice(params.items(), _MAX_MEMBERS))
        try:
            return validate(params)
        except ValidationError as error:
            entries = error.errors(include_url=False, include_context=False, include_input=False)
            raise InvalidParams([_problem(entry) for entry in entries[:MAX_PROBLEMS]]) from None

    return read


def _problem(entry: Any) -> dict[str, str]:
    return {"path": ".".join(str(part) for part in entry["loc"])[:_MAX_PATH], "message": entry["msg"]}
