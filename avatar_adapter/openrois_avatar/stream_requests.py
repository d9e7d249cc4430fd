"""What an application asks of streams, as it comes from the gateway: checked, with defaults where it says nothing."""

import json
from typing import TypeVar

from openrois_signaling.messages import IceServer, Restart
from openrois_streaming.adaptation.caps import Caps
from pydantic import Field

from openrois.errors import BadParameter
from openrois.types.messages import Parameter
from openrois.types.model import Model
from openrois.types.streams import ConnectStreamParams

__all__ = ["ConnectFromGateway", "EncodingParameters", "RestartFromGateway", "TransportParameters", "read_parameter"]

Read = TypeVar("Read", bound=Model)


class ConnectFromGateway(ConnectStreamParams):
    """As an application's, and what the gateway adds: ICE servers, and that the application may not bind."""

    may_bind: bool = True
    ice_servers: tuple[IceServer, ...] = Field(default=(), strict=False)


class RestartFromGateway(Restart):
    """As an application's, and fresh credentials for the ICE servers."""

    ice_servers: tuple[IceServer, ...] | None = Field(default=None, strict=False)


class EncodingParameters(Model, extra="ignore"):
    """What of `encoding_parameters` is read; other members are for engines that know them."""

    codecs: tuple[str, ...] | None = Field(default=None, max_length=32, strict=False)
    width: int | None = Field(default=None, ge=16, le=16_384)
    height: int | None = Field(default=None, ge=16, le=16_384)
    fps: float | None = Field(default=None, ge=1, le=1000)
    max_bitrate: int | None = Field(default=None, ge=50_000, le=1_000_000_000)
    channels: int = Field(default=1, ge=1, le=2)

    def caps(self) -> Caps:
        """What the application wants at most."""
        return Caps(self.max_bitrate, self.width, self.height, self.fps)


class TransportParameters(Model, extra="ignore"):
    """What of `transport_parameters` is read: `recvonly` is a stream that the application receives.

    With `input` the application wants data channels for what its person does.
    """

    direction: str = Field(default="recvonly", max_length=32)
    input: bool = False


def read_parameter(parameters: tuple[Parameter, ...], name: str, model: type[Read]) -> Read:
    """Read a parameter that is a JSON object in a text; one that is absent or empty has its defaults.

    Raises:
        BadParameter: it is not such a text, or a member has a wrong type.
    """
    text = next((parameter.value for parameter in parameters if parameter.name == name), "")
    try:
        return model.model_validate(json.loads(text) if text else {})
    except (ValueError, RecursionError) as error:
        raise BadParameter(f"{name} is a JSON object in a text: {error}") from error
