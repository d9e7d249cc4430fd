"""The wire as the strictest client reads it: no field beside the catalog's, no null for a list, names for numbers.

Pure.
"""

from collections.abc import Mapping
from typing import Any, Final

from pydantic import BaseModel, Field, ValidationError

from openrois.types.messages import ReturnResult
from openrois.types.methods import METHODS, NOTIFICATIONS
from openrois.types.model import Model
from openrois_conformance.deviation import Deviation, shown

__all__ = ["check_envelope", "explained_by", "is_extension", "read_notification", "read_result"]


class _Section(Model):
    mid: str
    stream_id: str
    component_ref: str
    kind: str
    direction: str


class _Offer(Model):
    peer_id: str
    generation: int
    sdp: str
    streams: tuple[_Section, ...] = Field(strict=False)
    replaces: str | None = None


class _Candidate(Model):
    peer_id: str
    generation: int
    candidate: str | None
    sdp_mid: str | None = None
    sdp_m_line_index: int | None = None


class _SenderClock(Model):
    mid: str
    ssrc: int
    clock_rate: int
    rtp_origin: int
    wall: int


class _CaptureClocks(Model):
    peer_id: str
    senders: tuple[_SenderClock, ...] = Field(strict=False)


class _Bye(Model):
    peer_id: str
    reason: str


class _IceServers(ReturnResult):
    ice_servers: list[dict[str, Any]] = Field(default_factory=list)
    ttl: int = 0


_RESULTS: Final[Mapping[str, type[BaseModel]]] = {
    **{method.name: method.result for method in METHODS},
    "signaling.answer": ReturnResult,
    "signaling.candidate": ReturnResult,
    "signaling.restart": ReturnResult,
    "signaling.ice_servers": _IceServers,
}
_BASE_NOTIFICATIONS: Final[Mapping[str, type[BaseModel]]] = {
    notification.name: notification.params for notification in NOTIFICATIONS if not notification.extension
}
_EXTENSION_NOTIFICATIONS: Final[Mapping[str, type[BaseModel]]] = {
    **{notification.name: notification.params for notification in NOTIFICATIONS if notification.extension},
    "signaling.offer": _Offer,
    "signaling.candidate": _Candidate,
    "signaling.capture_clocks": _CaptureClocks,
    "signaling.bye": _Bye,
}
_BASE_METHODS: Final = frozenset(method.name for method in METHODS if not method.extension)


def is_extension(method: str) -> bool:
    """Tell whether a method is one of an extension."""
    return method in _RESULTS and method not in _BASE_METHODS


def check_envelope(message: Any) -> None:
    """Refuse what is no JSON-RPC response or notification, to the letter.

    Raises:
        Deviation: a member is missing, has the wrong type, or should not be there.
    """
    if not isinstance(message, dict) or message.get("jsonrpc") != "2.0":
        raise Deviation('one JSON-RPC object with "jsonrpc": "2.0"', shown(message))
    members = set(message)
    if "method" in members:
        if "id" in members:
            raise Deviation("no request of the gateway to an application", shown(message))
        fits = members <= {"jsonrpc", "method", "params"} and isinstance(message["method"], str)
        fits = fits and isinstance(message.get("params", {}), dict)
    elif "error" in members:
        fits = members == {"jsonrpc", "id", "error"} and _is_error(message["error"])
    else:
        fits = members == {"jsonrpc", "id", "result"}
    if not fits:
        raise Deviation("the members of a JSON-RPC response or notification and no other", shown(message))


def explained_by(told: Mapping[str, Any], message: Mapping[str, Any]) -> Any:
    """Return the id that a reason names, of a request or of a command.

    Args:
        told: the params of the reason.
        message: the one right behind it.

    Raises:
        Deviation: it is no line, or not about that message.
    """
    if not told["reason"].isprintable():
        raise Deviation("a reason of one line, without control characters", shown(told["reason"]))
    request_id, command_id = told["request_id"], told["command_id"]
    result, params = message.get("result"), message.get("params", {})
    refused = isinstance(result, dict) and result.get("return_code") != "OK"
    failed = message.get("method") == "rois.command.completed" and params.get("status") != "OK"
    if refused and command_id is None and message["id"] == request_id:
        return request_id
    if failed and request_id is None and params.get("command_id") == command_id:
        return command_id
    raise Deviation(f"right behind a reason what it explains ({shown(told)})", shown(message))


def _is_error(error: Any) -> bool:
    return (
        isinstance(error, dict)
        and set(error) <= {"code", "message", "data"}
        and type(error.get("code")) is int
        and isinstance(error.get("message"), str)
    )


def read_result(method: str, result: Any) -> dict[str, Any]:
    """Return a result with every field of its method; what may be absent has its default.

    Raises:
        Deviation: it is not what the method answers.
    """
    if not isinstance(result, dict) or "return_code" not in result:
        raise Deviation(f"a result of {method} with a return_code", shown(result))
    return _read(_RESULTS[method], result, f"a result of {method}")


def read_notification(method: str, params: Any, *, extended: bool) -> dict[str, Any]:
    """Return the params of a notification; what may be absent has its default.

    Args:
        method: its name.
        params: its params.
        extended: whether the application has used a method of an extension.

    Raises:
        Deviation: there is no such notification, or it is not for this application, or it does not fit.
    """
    model = _BASE_NOTIFICATIONS.get(method)
    if model is None:
        model = _EXTENSION_NOTIFICATIONS.get(method)
        if model is None:
            raise Deviation("one of the notifications of the wire", method)
        if not extended:
            raise Deviation("no notification of an extension for an application that uses none", method)
    return _read(model, params, f"the params of {method}")


def _read(model: type[BaseModel], value: Any, what: str) -> dict[str, Any]:
    try:
        return model.model_validate(value).model_dump(mode="json")
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        path = ".".join(str(step) for step in first["loc"])
        raise Deviation(f"{what} that fits ({path}: {first['msg']})", shown(value)) from None
