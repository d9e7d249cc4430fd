"""The enumerations of RoIS 2.0. On the wire the enumerator's name stands, never its number."""

from enum import StrEnum, auto

__all__ = [
    "CompletedStatus",
    "ComponentFunction",
    "ComponentStatus",
    "ErrorType",
    "Purpose",
    "ReturnCode",
    "StreamStatus",
]


class _Name(StrEnum):
    """A member's value is its own name."""

    @staticmethod
    def _generate_next_value_(name: str, start: int, count: int, last_values: list[str]) -> str:
        return name


class ReturnCode(_Name):
    """How an operation ended (RoIS_HRI::ReturnCode_t)."""

    OK = auto()
    ERROR = auto()
    BAD_PARAMETER = auto()
    UNSUPPORTED = auto()
    OUT_OF_RESOURCES = auto()
    TIMEOUT = auto()


class CompletedStatus(_Name):
    """How a command ended (RoIS_Service::Completed_Status)."""

    OK = auto()
    ERROR = auto()
    ABORT = auto()
    OUT_OF_RESOURCES = auto()
    TIMEOUT = auto()


class ErrorType(_Name):
    """What kind of error is notified (RoIS_Service::ErrorType)."""

    ENGINE_INTERNAL_ERROR = auto()
    COMPONENT_INTERNAL_ERROR = auto()
    COMPONENT_NOT_RESPONDING = auto()
    USER_DEFINED_ERROR = auto()


class ComponentStatus(_Name):
    """What a component is able to do now (RoIS_Common::Component_Status)."""

    UNINITIALIZED = auto()
    READY = auto()
    BUSY = auto()
    WARNING = auto()
    ERROR = auto()


class StreamStatus(_Name):
    """The state of a stream (Stream_Status, table 8.10); RESUMED is announced as an event and is never a state."""

    STREAMING_NOT_CONNECTED = auto()
    STREAMING_NOT_RUNNING = auto()
    STREAMING_RUNNING = auto()
    STREAMING_SUSPENDED = auto()
    STREAMING_RESUMED = auto()


class Purpose(StrEnum):
    """What microphone and camera of a visitor may be used for. An extension of the wire.

    Attributes:
        LIVE: persons hear and see the visitor.
        RECOGNITION: words, sounds, faces and gestures are recognised, and announced as events.
        AGENT: a program that answers by itself gets them.
        RECORDING: they are kept.
        TRANSFER: they are sent to another machine than those of gateway, body and listeners.
    """

    LIVE = "live"
    RECOGNITION = "recognition"
    AGENT = "agent"
    RECORDING = "recording"
    TRANSFER = "transfer"


class ComponentFunction(StrEnum):
    """The class of a component: only an actuation has to be bound before it is operated. An extension of the wire."""

    ACTUATION = "actuation"
    SENSING = "sensing"
    FUNCTION = "function"
