"""Params and results of the extensions: `openrois.hello`, `openrois.holder` and `rois.stream.*`.

The streaming verbs are the Streaming Interface (clause 8.2.2.5, table 8.6) as methods of their own. Between an engine
and its sub-engine they carry `client_id` as well, because there one connection speaks for many applications.
"""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Final

from pydantic import Field

from openrois.types.codes import Purpose, StreamStatus
from openrois.types.messages import Parameter, ReturnResult
from openrois.types.model import Model
from openrois.types.stops import Stopped

__all__ = [
    "EXTENSIONS",
    "EXTENSION_VERSION",
    "STREAM_METHODS",
    "ConnectStreamParams",
    "ConnectStreamResult",
    "EventsDroppedNotification",
    "HelloParams",
    "HelloResult",
    "HolderNotification",
    "ReportPlayoutParams",
    "SetConsentParams",
    "SetConsentResult",
    "StreamParams",
    "StreamStatusNotification",
    "StreamStatusResult",
    "subject_of",
]

MAX_EXTENSIONS: Final = 64
"""Names in one hello."""

MAX_INSTANCE: Final = 64
"""Characters of the text by which an adapter process is known again."""

MAX_PARAMETERS: Final = 16
"""Parameters of one connect_stream."""

MAX_PURPOSES: Final = 16
"""Purposes in one list of consent."""

MAX_PLAYOUT: Final = 60_000
"""Milliseconds of delay that a viewer may report."""

Purposes = Annotated[tuple[Annotated[Purpose, Field(strict=False)], ...], Field(max_length=MAX_PURPOSES, strict=False)]

EXTENSION_VERSION = "1"
EXTENSIONS = ("rois.stream", "signaling")

STREAM_METHODS = {
    "connect_stream": "rois.stream.connect_stream",
    "disconnect_stream": "rois.stream.disconnect_stream",
    "suspend_stream": "rois.stream.suspend_stream",
    "resume_stream": "rois.stream.resume_stream",
}
"""The streaming verbs that are commands in strict RoIS terms, and the method each is."""


class HelloParams(Model):
    """Params of `openrois.hello`: the sender's extensions of the base wire."""

    version: str
    extensions: tuple[str, ...] = Field(default=(), max_length=MAX_EXTENSIONS, strict=False)


class HelloResult(ReturnResult):
    """Result of `openrois.hello`.

    `engines` are the ids of those in the tree that have the extensions; where it is empty and there are extensions, the
    engine that answers has them. An adapter says who it is: `instance` is a random text of its process, and `epoch` the
    greatest that any gateway has ever reported to it, 0 for none; `stopped` are its engines that persons have stopped.
    """

    version: str = EXTENSION_VERSION
    extensions: tuple[str, ...] = Field(default=(), strict=False)
    engines: tuple[str, ...] = Field(default=(), strict=False)
    client_id: str = ""
    instance: str = Field(default="", max_length=MAX_INSTANCE)
    epoch: int = Field(default=0, ge=0)
    stopped: tuple[Stopped, ...] = Field(default=(), strict=False)


class ConnectStreamParams(Model):
    """Params of connect_stream; parameters are `encoding_parameters` and `transport_parameters`, JSON text each."""

    component_ref: str
    parameters: tuple[Parameter, ...] = Field(default=(), max_length=MAX_PARAMETERS, strict=False)


class StreamParams(Model):
    """Params of every method that acts on a connected stream."""

    stream_id: str


class ReportPlayoutParams(StreamParams):
    """Params of report_playout: milliseconds from the arrival of the stream's media to their being played or shown."""

    milliseconds: Annotated[int, Field(ge=0, le=MAX_PLAYOUT)]


class SetConsentParams(StreamParams):
    """Params of set_consent: all that the sender of the stream consents to from now on; the rest is withdrawn."""

    consent: Purposes


class SetConsentResult(ReturnResult):
    """Result of set_consent: the name of the visitor that the application is to others."""

    visitor_ref: str = ""


class ConnectStreamResult(ReturnResult):
    """Result of connect_stream: the id that stands for this stream until it ends."""

    stream_id: str = ""


class StreamStatusResult(ReturnResult):
    """Result of query_stream_status."""

    status: Annotated[StreamStatus, Field(strict=False)] = StreamStatus.STREAMING_NOT_CONNECTED


class StreamStatusNotification(Model):
    """Params of the notification `rois.stream.notify_stream_status`; `timestamp` is a DateTime."""

    method: ClassVar[str] = "rois.stream.notify_stream_status"

    stream_id: str
    component_ref: str
    status: Annotated[StreamStatus, Field(strict=False)]
    timestamp: str


class EventsDroppedNotification(Model):
    """Params of the notification `openrois.events_dropped`: how many events and errors should stand in its place."""

    method: ClassVar[str] = "openrois.events_dropped"

    count: Annotated[int, Field(gt=0)]


class HolderNotification(Model):
    """Params of the notification `openrois.holder`, which a gateway sends to an adapter with `client_id` beside them.

    The application holds the component from now on, or not any more. `epoch` grows with each new holder; it is the same
    in the notification that begins it, in those that repeat it, and in the one that ends it.
    """

    method: ClassVar[str] = "openrois.holder"

    component_ref: str
    holds: bool
    epoch: Annotated[int, Field(gt=0)]


def subject_of(params: Mapping[str, Any]) -> str:
    """Return the reference or id of the engine that a message of an extension is about; empty where there is none."""
    subject = next((params[name] for name in ("component_ref", "stream_id", "peer_id") if name in params), "")
    return subject if isinstance(subject, str) else ""
