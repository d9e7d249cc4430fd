"""Requests for streams, as the gateway passes them on: checked, with defaults."""

import json
from typing import Final, Literal, TypeVar

from openrois_signaling.messages import IceServer, Restart
from openrois_streaming.adaptation.viewer import Caps
from pydantic import Field

from openrois.errors import BadParameter
from openrois.types.messages import Parameter
from openrois.types.model import Model
from openrois.types.streams import ConnectStreamParams, Purposes

__all__ = ["ConnectFromGateway", "EncodingParameters", "RestartFromGateway", "TransportParameters", "read_parameter"]

MAX_VISITOR_REF: Final = 256
"""Characters of the name of a visitor."""

Read = TypeVar("Read", bound=Model)


class ConnectFromGateway(ConnectStreamParams):
    """Application's request, with the gateway's additions: ICE servers, whether the application may bind, its role."""

    may_bind: bool = True
    role: Literal["visitor", "listener"] | None = None
    ice_servers: tuple[IceServer, ...] = Field(default=(), strict=False)


class RestartFromGateway(Restart):
    """Application's request, with fresh credentials for the ICE servers."""

    ice_servers: tuple[IceServer, ...] | None = Field(default=None, strict=False)


class EncodingParameters(Model, extra="ignore"):
    """Members of `encoding_parameters` that are read; others are for engines that know them."""

    codecs: tuple[str, ...] | None = Field(default=None, max_length=32, strict=False)
    width: int | None = Field(default=None, ge=16, le=16_384)
    height: int | None = Field(default=None, ge=16, le=16_384)
    fps: float | None = Field(default=None, ge=1, le=1000)
    max_bitrate: int | None = Field(default=None, ge=50_000, le=1_000_000_000)
    channels: int = Field(default=1, ge=1, le=2)

    def caps(self) -> Caps:
        """Return the limits that the application asks for."""
        return Caps(self.max_bitrate, self.width, self.height, self.fps)


class TransportParameters(Model, extra="ignore"):
    """Members of `transport_parameters` that are read: `recvonly` is a stream that the application receives.

    With `input` or `speech` the application asks for data channels: of operator input, or of speech as sound. `consent`
    has all that the sender of a stream consents to; None where it states nothing. With `visitor_ref` a stream is
    received that a visitor sends, for `purposes`.
    """

    direction: str = Field(default="recvonly", max_length=32)
    input: bool = False
    speech: bool = False
    consent: Purposes | None = None
    visitor_ref: str = Field(default="", max_length=MAX_VISITOR_REF)
    purposes: Purposes = ()


def read_parameter(parameters: tuple[Parameter, ...], name: str, model: type[Read]) -> Read:
    """Read a parameter that is a JSON object as text; an absent or empty one has the defaults.

    Raises:
        BadParameter: it is no JSON object, or a member has a wrong type.
    """
    text = next((parameter.value for parameter in parameters if parameter.name == name), "")
    try:
        return model.model_validate(json.loads(text) if text else {})
    except (ValueError, RecursionError) as error:
        raise BadParameter(f"{name} must be a JSON object as text: {error}") from error
