"""State machine of a stream, as a table. Pure.

A stream is connected and disconnected by its application, suspended and resumed by application and engine, each for
itself; everything else is measured. Its status follows from the phase.
"""

from collections.abc import Set as AbstractSet
from enum import Enum


class StreamStatus(Enum):
    """Status of a stream, as applications are notified of it."""

    NOT_CONNECTED = "not_connected"
    NOT_RUNNING = "not_running"
    RUNNING = "running"
    SUSPENDED = "suspended"


class StreamPhase(Enum):
    """Phase of a stream."""

    CONNECTING = "connecting"
    """There is no media path yet."""
    PARKED = "parked"
    """There is no media path yet, and it is suspended already."""
    IDLE = "idle"
    """There is a media path, and no media reaches the other end."""
    RUNNING = "running"
    """Media reaches the other end: the viewer, or the engine."""
    SUSPENDED = "suspended"
    """Nothing passes, because the application or the engine has suspended it."""
    RESUMING = "resuming"
    """Media may pass again, and has not reached the other end yet."""
    ENDED = "ended"
    """The stream has ended; its id is not used again."""


class StreamInput(Enum):
    """Input of the state machine."""

    UP = "up"
    """The media path is there."""
    FLOWING = "flowing"
    """Media was measured to reach the other end."""
    STALLED = "stalled"
    """Media was measured not to reach the other end."""
    SUSPEND = "suspend"
    """A party has suspended it."""
    RESUME = "resume"
    """Every party that suspended it has resumed it."""
    END = "end"


class Party(Enum):
    """Party that can suspend a stream. A stream resumes when every party that suspended it has resumed it."""

    APPLICATION = "application"
    ENGINE = "engine"


_P, _I = StreamPhase, StreamInput

TRANSITIONS: dict[StreamPhase, dict[StreamInput, StreamPhase]] = {
    _P.CONNECTING: {_I.UP: _P.IDLE, _I.SUSPEND: _P.PARKED, _I.RESUME: _P.CONNECTING, _I.END: _P.ENDED},
    _P.PARKED: {_I.UP: _P.SUSPENDED, _I.SUSPEND: _P.PARKED, _I.RESUME: _P.CONNECTING, _I.END: _P.ENDED},
    _P.IDLE: {
        _I.UP: _P.IDLE,
        _I.FLOWING: _P.RUNNING,
        _I.STALLED: _P.IDLE,
        _I.SUSPEND: _P.SUSPENDED,
        _I.RESUME: _P.IDLE,
        _I.END: _P.ENDED,
    },
    _P.RUNNING: {
        _I.UP: _P.RUNNING,
        _I.FLOWING: _P.RUNNING,
        _I.STALLED: _P.IDLE,
        _I.SUSPEND: _P.SUSPENDED,
        _I.RESUME: _P.RUNNING,
        _I.END: _P.ENDED,
    },
    _P.SUSPENDED: {_I.UP: _P.SUSPENDED, _I.SUSPEND: _P.SUSPENDED, _I.RESUME: _P.RESUMING, _I.END: _P.ENDED},
    _P.RESUMING: {
        _I.UP: _P.RESUMING,
        _I.FLOWING: _P.RUNNING,
        _I.STALLED: _P.IDLE,
        _I.SUSPEND: _P.SUSPENDED,
        _I.RESUME: _P.RESUMING,
        _I.END: _P.ENDED,
    },
    _P.ENDED: {},
}
"""All legal transitions. `suspend` and `resume` may be repeated."""

STATUS: dict[StreamPhase, StreamStatus] = {
    _P.CONNECTING: StreamStatus.NOT_CONNECTED,
    _P.PARKED: StreamStatus.NOT_CONNECTED,
    _P.IDLE: StreamStatus.NOT_RUNNING,
    _P.RUNNING: StreamStatus.RUNNING,
    _P.SUSPENDED: StreamStatus.SUSPENDED,
    _P.RESUMING: StreamStatus.SUSPENDED,
    _P.ENDED: StreamStatus.NOT_CONNECTED,
}
"""The status that belongs to a phase. A stream that resumes becomes RUNNING when its first picture is on its way."""

OPEN = frozenset({_P.CONNECTING, _P.IDLE, _P.RUNNING, _P.RESUMING})
"""The phases in which media passes as soon as it can."""


class IllegalTransition(RuntimeError):
    """Input that the current phase does not have; nothing was changed."""


def following(phase: StreamPhase, event: StreamInput) -> StreamPhase:
    """Return the phase after `event`.

    Raises:
        IllegalTransition: `TRANSITIONS` does not have it.
    """
    try:
        return TRANSITIONS[phase][event]
    except KeyError:
        raise IllegalTransition(f"{event.value} while {phase.value}") from None


def resumption(suspended_by: AbstractSet[Party], by: Party) -> StreamInput:
    """Return the input for a stream that `suspended_by` have suspended when `by` resumes it.

    The stream stays suspended as long as another party suspends it.
    """
    return StreamInput.SUSPEND if suspended_by - {by} else StreamInput.RESUME
