"""Gathers the generator's input: the tables of methods, the signaling messages, and the catalog."""

from typing import Any, Final

from openrois_signaling.messages import (
    Answer,
    Bye,
    Candidate,
    CaptureClocks,
    Direction,
    IceServer,
    MediaKind,
    Offer,
    Restart,
)
from pydantic import Field

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import CommandType, ComponentType, EventType, QueryType
from openrois.catalog.payload import Payload
from openrois.schema import VERSION
from openrois.types.messages import CommandUnit, ConcurrentCommands, NoParams, ReturnResult
from openrois.types.methods import METHODS, NOTIFICATIONS, MethodType, NotificationType
from openrois.types.streams import EXTENSION_VERSION
from openrois_codegen.ir import Component, Document, Message, Method, Notification, Structure
from openrois_codegen.reader import Reader

__all__ = ["document", "sources"]

_ROIS_VERSION: Final = "2.0"

_NAMES: Final = {
    MediaKind: ("MediaKind", "What a section of a peer connection carries."),
    Direction: ("Direction", "Where the media of a section flow, as seen from the application."),
    CommandUnit | ConcurrentCommands: ("SequenceItem", "One item of a command sequence; items run one after another."),
}


class IceServersResult(ReturnResult):
    """Result of `signaling.ice_servers`: the servers to use, and for how many seconds their credentials hold."""

    ice_servers: tuple[IceServer, ...] = Field(default=(), strict=False)
    ttl: int = Field(default=0, ge=0)


_SIGNALING: Final = (
    MethodType(Answer.method, Answer, ReturnResult, "Answer an engine's offer.", "signaling"),
    MethodType(Candidate.method, Candidate, ReturnResult, "Tell an engine of a candidate.", "signaling"),
    MethodType(Restart.method, Restart, ReturnResult, "Ask for a new peer connection.", "signaling"),
    MethodType("signaling.ice_servers", NoParams, IceServersResult, "Ask which servers help to connect.", "signaling"),
)
_SIGNALS: Final = (
    NotificationType(Offer.method, Offer, "An engine offers a peer connection.", "signaling"),
    NotificationType(Candidate.method, Candidate, "An engine has a candidate.", "signaling"),
    NotificationType(
        CaptureClocks.method, CaptureClocks, "An engine says when what it sends was captured.", "signaling"
    ),
    NotificationType(Bye.method, Bye, "An engine has ended a peer connection.", "signaling"),
)


def sources() -> dict[str, Any]:
    """Return what each type of the wire is in Python, by its name in the document."""
    of_wire, of_values = _read_wire()[0], _read_catalog()[0]
    return {**of_wire.sources, **{name: of_values.sources[name] for name in of_values.enumerations()}}


def document() -> Document:
    """Return everything that files are generated from."""
    of_wire, methods, notifications = _read_wire()
    of_values, components = _read_catalog()
    return Document(
        VERSION,
        dict(sorted({**of_wire.definitions, **of_values.enumerations()}.items())),
        methods,
        notifications,
        components,
        {name: found for name, found in of_values.definitions.items() if isinstance(found, Structure)},
    )


def _read_wire() -> tuple[Reader, tuple[Method, ...], tuple[Notification, ...]]:
    reader = Reader(_NAMES)
    methods = tuple(_method(reader, found) for found in (*METHODS, *_SIGNALING))
    notifications = tuple(_notification(reader, found) for found in (*NOTIFICATIONS, *_SIGNALS))
    return reader, methods, notifications


def _read_catalog() -> tuple[Reader, tuple[Component, ...]]:
    reader = Reader({})
    return reader, tuple(_component(reader, found) for found in (ROIS_COMMON, *BASIC_COMPONENTS))


def _method(reader: Reader, found: MethodType) -> Method:
    params, result = reader.read(found.params), reader.read(found.result)
    return Method(found.name, found.summary, params, result, found.extension, _since(found.extension))


def _notification(reader: Reader, found: NotificationType) -> Notification:
    return Notification(found.name, found.summary, reader.read(found.params), found.extension, _since(found.extension))


def _since(extension: str) -> str:
    return EXTENSION_VERSION if extension else _ROIS_VERSION


def _component(reader: Reader, found: ComponentType) -> Component:
    def payload(model: type[Payload] | None) -> str:
        return "" if model is None else reader.read(model)

    def message(kind: CommandType | QueryType | EventType) -> Message:
        takes = payload(kind.arguments) if isinstance(kind, CommandType) else ""
        return Message(kind.name, kind.description, takes, payload(kind.results))

    return Component(
        found.code,
        found.urn,
        found.description,
        "" if found.function is None else found.function.value,
        tuple(included.code for included in found.includes),
        tuple(message(command) for command in found.commands),
        tuple(message(query) for query in found.queries),
        tuple(message(event) for event in found.events),
        payload(found.parameters),
    )
