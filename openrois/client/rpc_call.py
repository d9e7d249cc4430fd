"""One request to a gateway: a result whose code is OK becomes a value, everything else an exception."""

from collections.abc import Callable, Mapping
from typing import Any, Final, TypeVar

from pydantic import ValidationError

from openrois.client.errors import ConnectionLost
from openrois.errors import error_for
from openrois.jsonrpc.protocol import INVALID_REQUEST
from openrois.jsonrpc.session import RpcError, RpcSession, SessionClosed
from openrois.types.codes import ReturnCode
from openrois.types.messages import CommandUnit, ConcurrentCommands, ExecuteParams, ReturnResult
from openrois.types.model import PASSING_OVER, Model

__all__ = ["Outcome", "ask", "read_message", "read_result"]

Outcome = TypeVar("Outcome", bound=ReturnResult)
Message = TypeVar("Message", bound=Model)

_HINTS: Final[Mapping[tuple[str, ReturnCode], str]] = {
    ("rois.command.bind", ReturnCode.OUT_OF_RESOURCES): "another application has bound it",
    ("rois.command.bind", ReturnCode.UNSUPPORTED): "there is no such component",
    ("rois.command.bind_any", ReturnCode.OUT_OF_RESOURCES): "other applications have bound all that meet the condition",
    ("rois.command.bind_any", ReturnCode.UNSUPPORTED): "no component meets the condition",
    ("rois.command.execute", ReturnCode.OUT_OF_RESOURCES): "a component that acts has to be bound first",
    ("rois.command.execute", ReturnCode.UNSUPPORTED): "there is no such component, or it has no such command",
    ("rois.command.execute", ReturnCode.BAD_PARAMETER): "an argument is unknown, or not of its type",
    ("rois.command.set_parameter", ReturnCode.OUT_OF_RESOURCES): "a component that acts has to be bound first",
    ("rois.command.set_parameter", ReturnCode.BAD_PARAMETER): "a parameter is unknown, or not of its type",
    ("rois.command.search", ReturnCode.BAD_PARAMETER): "the condition cannot be read",
    ("rois.query.query", ReturnCode.UNSUPPORTED): "no component that meets the condition answers this",
    ("rois.query.query", ReturnCode.BAD_PARAMETER): "several components answer this, or the condition cannot be read",
    ("rois.query.query", ReturnCode.ERROR): "the component is not connected yet, or does not work",
    ("rois.event.subscribe", ReturnCode.UNSUPPORTED): "no component that meets the condition has this event",
    ("rois.event.subscribe", ReturnCode.BAD_PARAMETER): "several components have it, or the condition cannot be read",
    ("rois.event.subscribe", ReturnCode.ERROR): "the component is not connected yet, or does not work",
    ("rois.event.get_event_detail", ReturnCode.BAD_PARAMETER): "there is no such event, or it was too long ago",
}
"""The likely meaning of a code, for a gateway that gives no reason: the base wire carries no more than the code."""

_NAMES: Final = ("component_ref", "query_type", "event_type", "event_id", "command_id", "condition")
_LONGEST: Final = 200


async def ask(
    session: RpcSession,
    method: str,
    params: Model,
    model: type[Outcome],
    *,
    timeout: float,
    accepted: Callable[[Outcome], None] | None = None,
    too_late: Callable[[Outcome], None] | None = None,
) -> Outcome:
    """Call `method` over a session.

    Args:
        session: the connection.
        method: its name.
        params: its params.
        model: of its result.
        timeout: seconds to wait at most.
        accepted: called with a result that is OK before any later message of the gateway is read.
        too_late: called with a result that is OK and comes too late: the caller gave up before it came, or (after
            `accepted`) in the same moment.

    Raises:
        RoISError: the return code is not OK.
        RpcError: the gateway does not know the method, or not with these params; or its answer cannot be read.
        ConnectionLost: the connection ended first.
        TimeoutError: no answer in time.
    """
    outcomes: list[Outcome] = []
    reason = ""

    def explain(told: str) -> None:
        nonlocal reason
        reason = told

    def take(raw: Any) -> None:
        outcome = read_result(method, model, raw, _about(params), reason)
        if accepted is not None:
            accepted(outcome)
        outcomes.append(outcome)

    def take_late(raw: Any) -> None:
        if too_late is not None:
            too_late(read_result(method, model, raw))

    written = params.model_dump(mode="json", exclude_none=True)
    try:
        await session.call(method, written, timeout=timeout, on_result=take, on_late=take_late, on_reason=explain)
    except SessionClosed as closed:
        raise ConnectionLost(f"{method}: the connection ended before the answer came ({closed})") from closed
    except BaseException as error:
        if outcomes and too_late is not None:
            too_late(outcomes[0])
        if isinstance(error, TimeoutError):
            raise TimeoutError(f"{method}: no answer within {timeout:g} s") from None
        raise
    return outcomes[0]


def read_message(model: type[Message], raw: Any) -> Message:
    """Read a message of a gateway, and ignore members that this version of the client does not know.

    Raises:
        pydantic.ValidationError: it is not what the model describes.
    """
    kept = model.model_config.get("extra") == "allow"
    return model.model_validate(raw, extra="allow" if kept else "ignore", context=PASSING_OVER)


def read_result(method: str, model: type[Outcome], raw: Any, about: str = "", reason: str = "") -> Outcome:
    """Return the result of `method` as its model.

    Args:
        method: its name.
        model: of its result.
        raw: the result.
        about: what it was asked of, for a person.
        reason: why it is a refusal, where the gateway has said so.

    Raises:
        RoISError: the return code is not OK.
        RpcError: it is no such result.
    """
    try:
        outcome = read_message(model, raw)
    except ValidationError as error:
        raise RpcError(INVALID_REQUEST, f"the answer to {method} cannot be read: {_why(error)}") from None
    code = outcome.return_code
    if code is not ReturnCode.OK:
        why = reason or _HINTS.get((method, code), "")
        raise error_for(code, f"{method}{about}: {code}{why and f' ({why})'}")
    return outcome


def _about(params: Model) -> str:
    """Return the subject of a request as in a call, `(start of robot/navigation)`; empty without such names."""
    if isinstance(params, ExecuteParams):
        units = [unit for item in params.command_unit_list for unit in _units(item)]
        named = [f"{unit.command_type} of {unit.component_ref}" for unit in units]
    else:
        named = [str(getattr(params, name)) for name in _NAMES if getattr(params, name, "")]
    return f"({' '.join(', '.join(named).split())[:_LONGEST]})" if named else ""


def _units(item: CommandUnit | ConcurrentCommands) -> tuple[CommandUnit, ...]:
    return item.command_list if isinstance(item, ConcurrentCommands) else (item,)


def _why(error: ValidationError) -> str:
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    return ": ".join([".".join(str(part) for part in first["loc"]), first["msg"]]).removeprefix(": ")
