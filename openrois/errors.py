"""Errors in RoIS terms. In Python operations return values or raise; return codes exist on the wire only.

Pure.
"""

from typing import ClassVar

from openrois.types.codes import CompletedStatus, ComponentStatus, ReturnCode

__all__ = [
    "Aborted",
    "BadParameter",
    "ComponentFailed",
    "EngineUnreachable",
    "NotResponding",
    "OutOfResources",
    "RoISError",
    "StoreUnreachable",
    "TimedOut",
    "Unsupported",
    "error_for",
    "require_usable",
]


class RoISError(Exception):
    """An operation or command failed; each subclass carries the code it has on the wire.

    Attributes:
        return_code: what the operation answers.
        completed_status: what `completed` says when a command ends this way.
    """

    return_code: ClassVar[ReturnCode] = ReturnCode.ERROR
    completed_status: ClassVar[CompletedStatus] = CompletedStatus.ERROR


class BadParameter(RoISError):
    """A parameter, argument, condition or id is not what the operation takes."""

    return_code = ReturnCode.BAD_PARAMETER


class Unsupported(RoISError):
    """There is no such component, command, query, event or stream, as far as the caller may know."""

    return_code = ReturnCode.UNSUPPORTED


class OutOfResources(RoISError):
    """Another application holds what is needed, or a limit is reached."""

    return_code = ReturnCode.OUT_OF_RESOURCES
    completed_status = CompletedStatus.OUT_OF_RESOURCES


class TimedOut(RoISError):
    """It took longer than it may."""

    return_code = ReturnCode.TIMEOUT
    completed_status = CompletedStatus.TIMEOUT


class NotResponding(TimedOut):
    """The engine that owns the component did not answer at all."""


class ComponentFailed(RoISError):
    """The component could not do it."""


class EngineUnreachable(RoISError):
    """The connection to the engine that owns the component is gone."""


class StoreUnreachable(RoISError):
    """The store that gateways share did not do what was asked, or did not answer: a change may have been made.

    Nothing is repeated by itself. What a gateway owns goes on; what is new needs the store.
    """


class Aborted(RoISError):
    """The command was stopped before its end."""

    completed_status = CompletedStatus.ABORT


_BY_RETURN_CODE: dict[ReturnCode, type[RoISError]] = {
    ReturnCode.ERROR: ComponentFailed,
    ReturnCode.BAD_PARAMETER: BadParameter,
    ReturnCode.UNSUPPORTED: Unsupported,
    ReturnCode.OUT_OF_RESOURCES: OutOfResources,
    ReturnCode.TIMEOUT: TimedOut,
}


def error_for(code: ReturnCode, message: str) -> RoISError:
    """Return the error that `code`, which is not OK, stands for."""
    return _BY_RETURN_CODE[code](message)


def require_usable(name: str, status: ComponentStatus, problem: str = "") -> None:
    """Do nothing where a component is READY or BUSY.

    Args:
        name: of the component, or its ref.
        status: of the component.
        problem: why the status is none of these, where that is known.

    Raises:
        ComponentFailed: it is not; the sentence says what that means.
    """
    why = f": {problem}" if problem else ""
    if status is ComponentStatus.UNINITIALIZED:
        raise ComponentFailed(f"{name} is not connected yet (UNINITIALIZED){why}")
    if status not in (ComponentStatus.READY, ComponentStatus.BUSY):
        raise ComponentFailed(f"{name} does not work now ({status}){why}")
