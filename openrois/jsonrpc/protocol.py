"""JSON-RPC 2.0 without input or output: text in, events out, text to send. Pure.

A `Peer` knows which of its own requests are unanswered and how to read and write envelopes; it knows nothing of tasks,
sockets, time or RoIS. Frame rules beyond the standard: one object per message, no batches, `params` is an object, and
numbers that JSON does not have (NaN, Infinity) are refused like any other text that is not JSON.
"""

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, NoReturn

from pydantic import BaseModel
from pydantic_core import PydanticSerializationError, from_json, to_json

__all__ = [
    "INTERNAL_ERROR",
    "INVALID_PARAMS",
    "INVALID_REQUEST",
    "METHOD_NOT_FOUND",
    "PARSE_ERROR",
    "TOO_MANY_REQUESTS",
    "ErrorResponse",
    "Incoming",
    "Notification",
    "Params",
    "Peer",
    "Request",
    "RequestId",
    "Response",
    "Violation",
    "decode",
    "encode",
]

PARSE_ERROR: Final = -32700
INVALID_REQUEST: Final = -32600
METHOD_NOT_FOUND: Final = -32601
INVALID_PARAMS: Final = -32602
INTERNAL_ERROR: Final = -32603
TOO_MANY_REQUESTS: Final = -32000

Params = BaseModel | Mapping[str, Any] | str
"""What stands in `params` of a message of ours; a `str` is the JSON text of it."""

RequestId = str | int | float | None
"""What may stand in `id`. `bool` is excluded although Python counts it as an `int`."""


class Request(NamedTuple):
    """A request of the other side, which expects an answer.

    `params` may be any JSON value: only the method's handler can say what is wrong with one that is no object.
    """

    id: RequestId
    method: str
    params: Any


class Notification(NamedTuple):
    """A notification of the other side; no answer is allowed."""

    method: str
    params: dict[str, Any]


class Response(NamedTuple):
    """The answer to our request `id`; `id` is no longer outstanding."""

    id: int
    result: Any


@dataclass(frozen=True, slots=True)
class ErrorResponse:
    """The other side refused our request `id`; `id` is no longer outstanding."""

    id: int
    code: int
    message: str
    data: Any = None


@dataclass(frozen=True, slots=True)
class Violation:
    """The other side broke the protocol.

    Attributes:
        reason: one sentence for the log.
        answer: the error response to send, or None where an answer would answer an answer.
    """

    reason: str
    answer: str | None


Incoming = Request | Notification | Response | ErrorResponse | Violation


def _as_json(value: Any) -> Any:
    """Write what `json` does not know: models."""
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


# Made once: `json.dumps` and `json.loads` make a new one for each message where they get any option.
_ENCODER: Final = json.JSONEncoder(ensure_ascii=False, separators=(",", ":"), allow_nan=False, default=_as_json)
_ASCII_ENCODER: Final = json.JSONEncoder(separators=(",", ":"), allow_nan=False, default=_as_json)


def encode(message: dict[str, Any]) -> str:
    """Write one JSON-RPC object without superfluous blanks, as text that UTF-8 can carry.

    Args:
        message: JSON values, and Pydantic models in the place of objects.

    Raises:
        ValueError: a number in it is NaN or infinite.
        TypeError: something in it has no place in JSON.
    """
    # Pydantic's writer takes a quarter of the time. It has words for numbers that JSON does not have, and none for half
    # a surrogate pair: such texts are written, or refused, by the other one.
    with suppress(PydanticSerializationError):
        text = to_json(message).decode()
        if "NaN" not in text and "Infinity" not in text:
            return text
    text = _ENCODER.encode(message)
    try:
        text.encode()
    except UnicodeEncodeError:
        # JSON can name half a surrogate pair and UTF-8 cannot carry one: an id that holds one is echoed as it came.
        text = _ASCII_ENCODER.encode(message)
    return text


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")


_DECODER: Final = json.JSONDecoder(parse_constant=_refuse_constant)


def decode(text: str) -> Any:
    """Read one JSON value.

    Raises:
        ValueError: it is none; that covers syntax, lone constants and integers of more digits than Python converts.
        RecursionError: it is too deep.
    """
    try:
        # It takes a third of the time, reads whatever it reads as the other one does, and gives up earlier: at lone
        # surrogates and at 200 levels.
        return from_json(text, allow_inf_nan=False)
    except (ValueError, TypeError):
        return _DECODER.decode(text)


class Peer:
    """One end of a JSON-RPC 2.0 connection.

    Requests of our own get integer ids that are never used twice. An answer to an id that is not outstanding (late,
    repeated or invented) is a `Violation` without an answer.
    """

    def __init__(self) -> None:
        self._next_id = 1
        self._outstanding: set[int] = set()

    def request(self, method: str, params: Params) -> tuple[int, str]:
        """Return a new id and the text of a request."""
        request_id = self._next_id
        text = encode({"jsonrpc": "2.0", "id": request_id, "method": method, "params": params})
        self._next_id += 1
        self._outstanding.add(request_id)
        return request_id, text

    def abandon_request(self, request_id: int) -> None:
        """Give up waiting: an answer that still comes is a violation that is only logged."""
        self._outstanding.discard(request_id)

    @staticmethod
    def notification(method: str, params: Params) -> str:
        """Return the text of a notification; `method` is one of our own names."""
        if isinstance(params, str):
            return f'{{"jsonrpc":"2.0","method":"{method}","params":{params}}}'
        return encode({"jsonrpc": "2.0", "method": method, "params": params})

    @staticmethod
    def response(request_id: RequestId, result: Any) -> str:
        """Return the text of the result for `request_id`."""
        return encode({"jsonrpc": "2.0", "id": request_id, "result": result})

    @staticmethod
    def error(request_id: RequestId, code: int, message: str, data: Any = None) -> str:
        """Return the text of the error for `request_id`; `data` is left out when None."""
        error: dict[str, Any] = {"code": code, "message": message}
        if data is not None:
            error["data"] = data
        return encode({"jsonrpc": "2.0", "id": request_id, "error": error})

    def receive(self, text: str) -> Incoming:
        """Read one message. Never raises, whatever the text holds."""
        try:
            message = decode(text)
        except (ValueError, RecursionError):
            return self._violation("the message is not JSON", PARSE_ERROR)
        if not isinstance(message, dict):
            return self._violation("a message is one JSON object; batches are not supported", INVALID_REQUEST)
        request_id = message.get("id")
        if not _is_request_id(request_id):
            return self._violation("id must be a string, a number or null", INVALID_REQUEST)
        if message.get("jsonrpc") != "2.0":
            return self._violation('jsonrpc must be "2.0"', INVALID_REQUEST, request_id)
        if "method" in message:
            return self._receive_call(message, request_id)
        return self._receive_answer(message, request_id)

    def _receive_call(self, message: dict[str, Any], request_id: RequestId) -> Incoming:
        method, params = message["method"], message.get("params")
        if not isinstance(method, str):
            return self._violation("method must be a string", INVALID_REQUEST, request_id)
        if params is None:
            params = {}
        if "id" not in message:
            # A notification cannot be answered, so one with unusable params is dropped with its reason logged.
            return (
                Notification(method, params)
                if isinstance(params, dict)
                else Violation("params must be an object", None)
            )
        return Request(request_id, method, params)

    def _receive_answer(self, message: dict[str, Any], request_id: RequestId) -> Incoming:
        has_result, error = "result" in message, message.get("error")
        if not has_result and "error" not in message:
            return self._violation("neither a request nor a response", INVALID_REQUEST, request_id)
        if not isinstance(request_id, int) or request_id not in self._outstanding:
            return Violation(f"an answer to id {str(request_id)[:80]!r}, which is not outstanding", None)
        self._outstanding.discard(request_id)
        if has_result and error is None:
            return Response(request_id, message["result"])
        if isinstance(error, dict) and isinstance(error.get("code"), int) and isinstance(error.get("message"), str):
            return ErrorResponse(request_id, error["code"], error["message"], error.get("data"))
        return ErrorResponse(request_id, INVALID_REQUEST, "the answer's error object is malformed")

    def _violation(self, reason: str, code: int, request_id: RequestId = None) -> Violation:
        name = "Parse error" if code == PARSE_ERROR else "Invalid Request"
        return Violation(reason, self.error(request_id, code, name))


def _is_request_id(value: Any) -> bool:
    kind = type(value)
    if kind is float:
        # 1e999 parses to infinity, which could not be written back.
        return bool(value - value == 0)
    # `isinstance` would take a bool for an int.
    return kind is int or kind is str or value is None
