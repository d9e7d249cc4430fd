"""Authorization of calls: every method of an application passes here, and one without a rule is always refused."""

from collections.abc import Iterator, Mapping
from typing import Final

from openrois.jsonrpc.session import Handler, Reply
from openrois.session.session import ApplicationSession
from openrois.types.codes import ReturnCode
from openrois.types.messages import ReturnResult
from openrois.types.methods import METHODS

__all__ = ["enforced"]

_RESULTS: Final = {method.name: method.result for method in METHODS}


def enforced(app: ApplicationSession, methods: Mapping[str, Handler]) -> Mapping[str, Handler]:
    """Return the methods as the application may call them: those that its roles allow.

    The rule is applied at every look-up, because the principal can change. A call that is not allowed is refused before
    anything of its params is read, so that its answer says nothing about them. What its refs may name, `app.engine`
    knows.
    """
    return _Enforced(app, methods)


class _Enforced(Mapping[str, Handler]):
    """A table that costs one application next to nothing: there are thousands of them, and half a hundred methods."""

    __slots__ = ("_app", "_methods")

    def __init__(self, app: ApplicationSession, methods: Mapping[str, Handler]) -> None:
        self._app = app
        self._methods = methods

    def __getitem__(self, name: str) -> Handler:
        handler = self._methods[name]
        return handler if self._app.engine.principal.may_call(name) else lambda _params: _refused(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._methods)

    def __len__(self) -> int:
        return len(self._methods)


async def _refused(name: str) -> Reply:
    result = _RESULTS.get(name, ReturnResult)
    return Reply(result(return_code=ReturnCode.UNSUPPORTED), reason=f"{name} is not for the roles of this application")
