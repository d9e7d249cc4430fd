"""One operation of RoIS as a JSON-RPC method: a failure in RoIS terms becomes a result with its return code."""

import logging
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any, TypeVar

from pydantic import BaseModel

from openrois.errors import RoISError
from openrois.jsonrpc.session import Handler, Reply, method
from openrois.session.session import ApplicationSession
from openrois.types.messages import ReturnResult
from openrois.types.references import engine_of
from openrois.types.streams import subject_of

__all__ = ["operation", "reply_first"]

_log = logging.getLogger(__name__)

Params = TypeVar("Params", bound=BaseModel)


def operation(
    params: type[Params],
    result: type[ReturnResult],
    function: Callable[[Params], Awaitable[ReturnResult | Reply]],
) -> Handler:
    """Return the handler of an operation.

    Args:
        params: the model of its params; what does not fit is answered with -32602.
        result: the model of its result; a failure answers it with defaults and the failure's return code, and its
            message is the reply's reason.
        function: does it; returns the result, or raises `RoISError`.
    """
    return method(params, _Operation(result, function))


class _Operation:
    """Carries out an operation with params that fit; see `operation`."""

    __slots__ = ("_function", "_result")

    def __init__(self, result: type[ReturnResult], function: Callable[[Any], Awaitable[ReturnResult | Reply]]) -> None:
        self._result = result
        self._function = function

    async def __call__(self, checked: BaseModel) -> ReturnResult | Reply:
        try:
            return await self._function(checked)
        except RoISError as error:
            _log.debug("%s: %s", type(checked).__name__, error)
            return Reply(self._result(return_code=error.return_code), reason=str(error))


def reply_first(app: ApplicationSession, handler: Handler) -> Handler:
    """Return a handler of an extension's method whose reply leaves before the notifications that the call causes."""

    async def answer(params: dict[str, Any]) -> Reply:
        replied = app.order.asked(engine_of(subject_of(params)))
        try:
            result = await handler(params)
        except BaseException:
            replied()
            raise
        return replace(result, then=replied) if isinstance(result, Reply) else Reply(result, replied)

    return answer
