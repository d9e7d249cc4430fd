"""The `signaling.*` methods that an application calls, as a table for a JSON-RPC server. The seam is a plain dict."""

from collections.abc import Awaitable, Callable, Hashable, Mapping
from typing import Any, NamedTuple, TypeAlias, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from openrois_signaling.messages import TOO_LONG, Answer, Candidate, IceServer, Restart
from openrois_signaling.relay import Relay, Upward

Handler: TypeAlias = Callable[[Mapping[str, Any]], Awaitable[dict[str, Any]]]
"""Takes the params of a request and returns its result; raises `InvalidParams`."""

OwnerT = TypeVar("OwnerT", bound=Hashable)
EngineT = TypeVar("EngineT", bound=Hashable)
ModelT = TypeVar("ModelT", bound=BaseModel)


ERRORS_LIMIT = 10
"""Errors that one refusal lists; the sender chose how many there are."""

PATH_LIMIT = 128
"""Characters of a path in them; an unknown field's name was chosen by the sender."""


class InvalidParams(ValueError):
    """Params that do not have the shape of the method.

    `errors` is a list of `{"path", "message"}`: where in the params, dotted ("" is the whole), and what is wrong. The
    messages do not repeat the values.
    """

    def __init__(self, errors: list[dict[str, str]]) -> None:
        super().__init__("; ".join(f"{error['path']}: {error['message']}" for error in errors))
        self.errors = errors


class IceServers(NamedTuple):
    """The servers an application may use, and for how many seconds their credentials hold."""

    servers: tuple[IceServer, ...]
    ttl: int


class _NoParams(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class _TooLong(Exception):
    pass


def _read(model: type[ModelT], params: Mapping[str, Any]) -> ModelT:
    """Params as a message.

    Raises:
        InvalidParams: they do not have its shape.
        _TooLong: they have, and exceed a limit.
    """
    try:
        return model.model_validate(dict(params))
    except ValidationError as error:
        details = error.errors(include_url=False, include_context=False, include_input=False)
        if all(detail["type"] == TOO_LONG for detail in details):
            raise _TooLong from None
        raise InvalidParams([_plain(detail) for detail in details[:ERRORS_LIMIT]]) from None


def _plain(detail: ErrorDetails) -> dict[str, str]:
    return {"path": ".".join(str(part) for part in detail["loc"])[:PATH_LIMIT], "message": detail["msg"]}


def signaling_methods(
    relay: Relay[OwnerT, EngineT], owner: OwnerT, ice_servers: Callable[[], IceServers]
) -> dict[str, Handler]:
    """The methods for the application `owner`, whose peers `relay` knows.

    Every result has a `return_code`. BAD_PARAMETER: a value exceeds its limit. UNSUPPORTED: no such peer of this
    application. OUT_OF_RESOURCES: too many messages. Others come from the engine.
    """

    def passing_on(model: type[ModelT], send: Callable[[ModelT], Awaitable[str]]) -> Handler:
        async def handle(params: Mapping[str, Any]) -> dict[str, Any]:
            try:
                message = _read(model, params)
            except _TooLong:
                return {"return_code": "BAD_PARAMETER"}
            return {"return_code": await send(message)}

        return handle

    async def send(message: Upward) -> str:
        return await relay.send(owner, message)

    async def list_ice_servers(params: Mapping[str, Any]) -> dict[str, Any]:
        _read(_NoParams, params)
        offered = ice_servers()
        return {
            "return_code": "OK",
            "ice_servers": [server.wire() for server in offered.servers],
            "ttl": offered.ttl,
        }

    return {
        Answer.method: passing_on(Answer, send),
        Candidate.method: passing_on(Candidate, send),
        Restart.method: passing_on(Restart, send),
        "signaling.ice_servers": list_ice_servers,
    }
