"""One operation of RoIS as a JSON-RPC method: a failure in RoIS terms becomes a result with its return code."""

import logging
from collections.abc import Awaitable, Callable
from dataclasses import replace
from functools import partial
from typing import Any, Protocol, TypeVar

from pydantic import BaseModel

from openrois.errors import RoISError
from openrois.jsonrpc.handler import Handler, Reply, params_reader
from openrois.jsonrpc.method_tables import SharedMethod
from openrois.session.session import ApplicationSession
from openrois.types.messages import ReturnResult
from openrois.types.references import engine_of
from openrois.types.streams import subject_of

__all__ = ["operation", "reply_first", "shared_operation"]

_log = logging.getLogger(__name__)

Params = TypeVar("Params", bound=BaseModel)


def operation(
    params: type[Params],
    result: type[ReturnResult],
    function: Callable[[Params], Awaitable[ReturnResult | Reply]],
) -> Handler:
    """Return the handler of an operation of one connection; see `shared_operation`."""
    shared = shared_operation(params, result, lambda _owner, checked: function(checked))
    return partial(shared, None)


def shared_operation(
    params: type[Params],
    result: type[ReturnResult],
    function: Callable[[Any, Params], Awaitable[ReturnResult | Reply]],
) -> SharedMethod:
    """Return an operation for a table that all connections share.

    Args:
        params: the model of its params; what does not fit is answered with -32602.
        result: the model of its result; a failure answers it with defaults and the failure's return code, and its
            message is the reply's reason.
        function: does it for the owner of the table; returns the result, or raises `RoISError`.
    """
    read = params_reader(params)

    async def answer(owner: Any, given: dict[str, Any]) -> ReturnResult | Reply:
        checked = read(given)
        try:
            return await function(owner, checked)
        except RoISError as error:
            _log.debug("%s: %s", params.__name__, error)
            return Reply(result(return_code=error.return_code), reason=str(error))

    return answer


class OfApplication(Protocol):
    """An owner of methods that belong to an application."""

    @property
    def app(self) -> ApplicationSession:
        """Its session."""
        ...


def reply_first(method: SharedMethod) -> SharedMethod:
    """Return a method of an extension whose reply leaves before the notifications that the call causes."""

    async def answer(owner: OfApplication, params: dict[str, Any]) -> Reply:
        replied = owner.app.order.asked(engine_of(subject_of(params)))
        try:
            result = await method(owner, params)
        except BaseException:
            replied()
            raise
        return replace(result, then=replied) if isinstance(result, Reply) else Reply(result, replied)

    return answer
