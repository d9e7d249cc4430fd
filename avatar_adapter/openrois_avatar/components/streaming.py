"""VideoStreaming and AudioStreaming (components 16 and 17): what can be streamed, and how the streams fare.

The streaming verbs need to know which application asks, so they arrive as extension calls (`openrois_avatar.streams`);
the engine that the application speaks to turns `execute`, `query` and `subscribe` with these verbs into the same calls.
"""

import json
from collections.abc import Callable

from openrois.component import Component, command, parameter_profile, query
from openrois.errors import BadParameter, Unsupported
from openrois.types.codes import ComponentFunction, ComponentStatus
from openrois.types.messages import Result
from openrois.types.profiles import CommandMessageProfile, EventMessageProfile, QueryMessageProfile
from openrois_avatar.components.profiles import component_profile

__all__ = ["Streaming"]

_STREAM_ID = parameter_profile("stream_id", "String")
_STATUS = parameter_profile("status", "Stream_Status")


class Streaming(Component):
    """One of the two streaming components.

    Args:
        name: `VideoStreaming` or `AudioStreaming`.
        codecs: the media types it can be streamed in, best first.
        source_status: tells whether there is something to stream now.
    """

    def __init__(self, name: str, codecs: tuple[str, ...], source_status: Callable[[], ComponentStatus]) -> None:
        super().__init__(
            component_profile(
                name,
                ComponentFunction.FUNCTION,
                commands=(
                    CommandMessageProfile(name="connect_stream", results=(_STREAM_ID,)),
                    CommandMessageProfile(name="disconnect_stream", arguments=(_STREAM_ID,)),
                    CommandMessageProfile(name="suspend_stream", arguments=(_STREAM_ID,)),
                    CommandMessageProfile(name="resume_stream", arguments=(_STREAM_ID,)),
                ),
                queries=(QueryMessageProfile(name="get_stream_status", results=(_STATUS,)),),
                events=(
                    EventMessageProfile(
                        name="notify_stream_status",
                        results=(parameter_profile("timestamp", "DateTime"), _STATUS, _STREAM_ID),
                    ),
                ),
                parameters=(
                    parameter_profile("encoding_parameters", "String"),
                    parameter_profile("transport_parameters", "String"),
                    parameter_profile("available_encodings", "String", json.dumps({"codecs": list(codecs)})),
                    parameter_profile("available_transports", "String", json.dumps({"direction": ["recvonly"]})),
                ),
            )
        )
        self._source_status = source_status

    def condition(self) -> ComponentStatus:
        """Follow the source."""
        return self._source_status()

    def accept_parameters(self, values: dict[str, str]) -> dict[str, str]:
        """Refuse to change what is available: every application reads it, and only the engine knows."""
        for name in values:
            if name.startswith("available_"):
                raise BadParameter(f"{name} can only be read")
        return values

    @command("connect_stream", "disconnect_stream", "suspend_stream", "resume_stream")
    async def act(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        """Refuse: without the application a stream would belong to nobody.

        Raises:
            Unsupported: always.
        """
        raise Unsupported("streams are connected for an application, through the streaming methods")

    @query("get_stream_status")
    async def get_stream_status(self) -> tuple[Result, ...]:
        """Refuse, for the same reason.

        Raises:
            Unsupported: always.
        """
        raise Unsupported("the status of a stream is told to its application, through the streaming methods")
