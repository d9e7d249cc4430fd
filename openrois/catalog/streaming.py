"""AudioStreaming and VideoStreaming (16 and 17): the Streaming Interface in terms of commands, queries and events."""

from datetime import datetime
from typing import Annotated, Final

from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import CommandType, ComponentType, EventType, QueryType
from openrois.catalog.payload import Data, Payload
from openrois.types.codes import ComponentFunction, StreamStatus

__all__ = [
    "AUDIO_STREAMING",
    "VIDEO_STREAMING",
    "ConnectStreamResults",
    "NotifyStreamStatus",
    "StreamArguments",
    "StreamStatusResults",
    "StreamingParameters",
]


class ConnectStreamResults(Payload):
    """The stream that was connected."""

    stream_id: Annotated[str, Data("String", "M", "stands for the stream until it ends")]


class StreamArguments(Payload):
    """Which stream is meant."""

    stream_id: Annotated[str, Data("String", "M", "the stream", note="an out parameter in the IDL")]


class StreamStatusResults(Payload):
    """What a stream does."""

    status: Annotated[StreamStatus, Data("Stream_Status", "M", "the stream's status")]


class NotifyStreamStatus(Payload):
    """What a stream does now."""

    timestamp: Annotated[datetime, Data("DateTime", "M", "since when")]
    status: Annotated[StreamStatus, Data("Stream_Status", "M", "the stream's status")]
    stream_id: Annotated[
        str | None,
        Data(
            "string",
            "O",
            "the stream",
            source="OpenRoIS",
            note="an argument in the XML, for which the schema has no place; without it the event does not say whose",
        ),
    ] = None


_SET: Final = "the standard leaves the syntax open, ours is JSON (see wire.md); the IDL's get_parameter lacks it"
_READ: Final = "the standard leaves the syntax open, ours is JSON; the IDL's set_parameter lacks it"


class StreamingParameters(Payload):
    """How streams are to be made, and how they can be."""

    encoding_parameters: Annotated[str | None, Data("String", "M", "the encoding to use", note=_SET)] = None
    transport_parameters: Annotated[str | None, Data("String", "M", "the transport to use", note=_SET)] = None
    available_encodings: Annotated[
        str | None, Data("String", "M", "the encodings to choose from", note=_READ, read_only=True)
    ] = None
    available_transports: Annotated[
        str | None, Data("String", "M", "the transports to choose from", note=_READ, read_only=True)
    ] = None


_COMMANDS: Final = (
    CommandType("connect_stream", "Connect a stream.", results=ConnectStreamResults),
    CommandType("disconnect_stream", "End a stream.", arguments=StreamArguments),
    CommandType("suspend_stream", "Pause a stream.", arguments=StreamArguments),
    CommandType("resume_stream", "Go on with a stream.", arguments=StreamArguments),
)
_QUERIES: Final = (
    # Table 8.6 calls it query_stream_status; component tables, IDL and XML have this name. Its stream_id stands in the
    # condition, because a query takes no arguments.
    QueryType("get_stream_status", "Ask what a stream does.", StreamStatusResults),
)
_EVENTS: Final = (EventType("notify_stream_status", "A stream does something else now.", NotifyStreamStatus),)

AUDIO_STREAMING: Final = ComponentType(
    code="AudioStreaming",
    name="audio_streaming",
    description="Streams sound; the media flow beside RoIS.",
    source="AudioStreaming.xml",
    function=ComponentFunction.FUNCTION,
    commands=_COMMANDS,
    queries=_QUERIES,
    events=_EVENTS,
    parameters=StreamingParameters,
    includes=(ROIS_COMMON,),
)

VIDEO_STREAMING: Final = ComponentType(
    code="VideoStreaming",
    name="video_streaming",
    description="Streams pictures; the media flow beside RoIS.",
    source="VideoStreaming.xml",
    function=ComponentFunction.FUNCTION,
    commands=_COMMANDS,
    queries=_QUERIES,
    events=_EVENTS,
    parameters=StreamingParameters,
    includes=(ROIS_COMMON,),
)
