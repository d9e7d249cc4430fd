"""The `signaling.*` methods that an application calls, as a table for a JSON-RPC server. The seam is a plain dict."""

from collections.abc import Awaitable, Callable, Hashable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from openrois_signaling.messages import TOO_LONG, Answer, Candidate, IceServer, Restart
from openrois_signaling.relay import Refused, Relay

Handler: TypeAlias = Callable[[Mapping[str, Any]], Awaitable[dict[str, Any]]]
"""Takes the params of a request and returns its result; raises `InvalidParams` and `Refused`."""

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


class TooLong(Refused):
    """A value exceeds its limit."""

    def __init__(self, errors: Sequence[ErrorDetails]) -> None:
        first = _plain(errors[0])
        super().__init__("BAD_PARAMETER", f"{first['path']}: {first['message']}")


def _read(model: type[ModelT], params: Mapping[str, Any]) -> ModelT:
    """Params as a message.

    Raises:
        InvalidParams: they do not have its shape.
        TooLong: they have, and exceed a limit.
    """
    try:
        return model.model_validate(dict(params))
    except ValidationError as error:
        details = error.errors(include_url=False, include_context=False, include_input=False)
        if all(detail["type"] == TOO_LONG for detail in details):
            raise TooLong(details) from None
        raise InvalidParams([_plain(detail) for detail in details[:ERRORS_LIMIT]]) from None


def _plain(detail: ErrorDetails) -> dict[str, str]:
    return {"path": ".".join(str(part) for part in detail["loc"])[:PATH_LIMIT], "message": detail["msg"]}


def signaling_methods(
    relay: Relay[OwnerT, EngineT], owner: OwnerT, ice_servers: Callable[[], IceServers]
) -> dict[str, Handler]:
    """The methods for the application `owner`, whose peers `relay` knows.

    Every result has the `return_code` OK. A handler raises `Refused` otherwise: BAD_PARAMETER for a value that exceeds
    its limit (`TooLong`), UNSUPPORTED for no such peer of this application, OUT_OF_RESOURCES for too many messages.
    Others come from the engine.
    """

    def passing_on(model: type[Answer] | type[Candidate] | type[Restart]) -> Handler:
        async def handle(params: Mapping[str, Any]) -> dict[str, Any]:
            await relay.send(owner, _read(model, params))
            return {"return_code": "OK"}

        return handle

    async def list_ice_servers(params: Mapping[str, Any]) -> dict[str, Any]:
        _read(_NoParams, params)
        offered = ice_servers()
        return {
            "return_code": "OK",
            "ice_servers": [server.wire() for server in offered.servers],
            "ttl": offered.ttl,
        }

    return {
        **{model.method: passing_on(model) for model in (Answer, Candidate, Restart)},
        "signaling.ice_servers": list_ice_servers,
    }
