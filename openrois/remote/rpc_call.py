"""Requests to a remote engine: the wire's answers become values or `RoISError`."""

import logging
from collections.abc import Callable
from typing import Any, Final, TypeVar

from pydantic import ValidationError

from openrois.errors import ComponentFailed, EngineUnreachable, NotResponding, RoISError, error_for
from openrois.jsonrpc.protocol import Params
from openrois.jsonrpc.session import RpcError, RpcSession, SessionClosed
from openrois.types.codes import ReturnCode
from openrois.types.messages import ReturnResult

__all__ = ["RpcCalls", "read_result"]

_log = logging.getLogger(__name__)

_REFUSALS: Final = frozenset(code.value for code in ReturnCode if code is not ReturnCode.OK)

Outcome = TypeVar("Outcome", bound=ReturnResult)


class _Latest:
    """Reason of a refused request: the other side may notify any number of them, and the last one counts."""

    __slots__ = ("line",)

    def __init__(self) -> None:
        self.line = ""

    def keep_line(self, line: str) -> None:
        self.line = line


def _refusal(name: str, code: ReturnCode, reason: _Latest) -> RoISError:
    return error_for(code, reason.line or f"the engine answered {name} with {code}")


class RpcCalls:
    """Calls methods over a session until the other side is lost."""

    def __init__(self, session: RpcSession) -> None:
        self._session = session
        self.lost = False

    def require_connected(self) -> None:
        """Raise `EngineUnreachable` once the other side is lost."""
        if self.lost:
            raise EngineUnreachable("the connection to the engine has ended")

    async def ask(
        self,
        name: str,
        params: Params,
        model: type[Outcome],
        accepted: Callable[[Outcome], None] | None = None,
        too_late: Callable[[Any], None] | None = None,
        *,
        urgent: bool = False,
        before: Callable[[], None] | None = None,
        timeout: float | None = None,
    ) -> Outcome:
        """Call a method, check the answer, and raise what its return code stands for.

        Args:
            name: the method.
            params: its params.
            model: of its result.
            accepted: called with a result whose code is OK before any later message is read.
            too_late: called with a result, as it came, that has no caller any more.
            urgent: whether it is asked also where there is no room for questions.
            before: called when there is room, right before it is asked; what that raises is raised.
            timeout: seconds to wait; as long as for any answer unless given.

        Raises:
            RoISError: the other side refused, did not answer in time or properly, or is gone.
        """

        def on_result(result: Any) -> Outcome:
            checked = read_result(name, result, model)
            if accepted is not None and checked.return_code is ReturnCode.OK:
                accepted(checked)
            return checked

        reason = _Latest()
        checked: Outcome = await self._ask(
            name, params, on_result, too_late, reason, urgent=urgent, before=before, timeout=timeout
        )
        if checked.return_code is not ReturnCode.OK:
            raise _refusal(name, checked.return_code, reason)
        return checked

    async def ask_unread(
        self, name: str, params: Params, too_late: Callable[[Any], None], before: Callable[[], None]
    ) -> Any:
        """Call a method and return the result as it came, unless its return code is a refusal.

        Raises:
            RoISError: as `ask`.
        """
        reason = _Latest()
        result = await self._ask(name, params, None, too_late, reason, before=before)
        code = result.get("return_code") if isinstance(result, dict) else None
        if code in _REFUSALS:
            raise _refusal(name, ReturnCode(code), reason)
        return result

    async def _ask(
        self,
        name: str,
        params: Params,
        on_result: Callable[[Any], Any] | None,
        too_late: Callable[[Any], None] | None,
        reason: _Latest,
        *,
        urgent: bool = False,
        before: Callable[[], None] | None = None,
        timeout: float | None = None,
    ) -> Any:
        self.require_connected()
        try:
            return await self._session.call(
                name,
                params,
                timeout=timeout,
                urgent=urgent,
                before=before,
                on_result=on_result,
                on_late=too_late,
                on_reason=reason.keep_line,
            )
        except TimeoutError:
            raise NotResponding(f"the engine did not answer {name} in time") from None
        except SessionClosed as closed:
            raise EngineUnreachable(f"the connection to the engine ended: {closed}") from closed
        except RpcError as refused:
            # Its text is for the operator: an application gets the sentence of a `RoISError`.
            _log.info("an engine refused %s", refused)
            raise ComponentFailed(f"the engine refused {name} with the error {refused.code}") from refused


def read_result(name: str, result: Any, model: type[Outcome]) -> Outcome:
    """Return the result of `name` as its model.

    Raises:
        ComponentFailed: it is none.
    """
    try:
        return model.read(result)
    except ValidationError as error:
        # One line: it is logged, and becomes the reason of a close frame.
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        path = ".".join(str(step) for step in first["loc"])
        raise ComponentFailed(f"the engine's answer to {name} is malformed: {path}: {first['msg']}"[:500]) from error
