"""Who may call what: every method of an application passes here, and one without a rule is refused to everybody."""

from collections.abc import Awaitable, Mapping
from typing import Any, Final

from openrois.application import ApplicationSession
from openrois.jsonrpc.session import Handler, Reply
from openrois.types.codes import ReturnCode
from openrois.types.messages import ReturnResult
from openrois.types.methods import METHODS

__all__ = ["enforced"]

_RESULTS: Final = {method.name: method.result for method in METHODS}


def enforced(app: ApplicationSession, methods: Mapping[str, Handler]) -> dict[str, Handler]:
    """Return the methods as the application may call them: those that its roles allow.

    That is asked at every call, because its principal can change. A call that is not allowed is refused before anything
    of its params is read, so that its answer says nothing about them. What its refs may name `app.engine` knows.
    """
    return {name: _enforced(app, name, handler) for name, handler in methods.items()}


def _enforced(app: ApplicationSession, name: str, handler: Handler) -> Handler:
    engine = app.engine

    def answer(params: dict[str, Any]) -> Awaitable[Any]:
        return handler(params) if engine.principal.may_call(name) else _refused(name)

    return answer


async def _refused(name: str) -> Reply:
    result = _RESULTS.get(name, ReturnResult)
    return Reply(result(return_code=ReturnCode.UNSUPPORTED), reason=f"{name} is not for the roles of this application")
