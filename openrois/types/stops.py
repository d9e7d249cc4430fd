"""Messages about engines that a person has stopped: what programs wait for, and how a person hands them back."""

import secrets
from typing import Annotated, ClassVar, Final, TypeAlias

from pydantic import Field

from openrois.types.model import Model

__all__ = ["MAX_STOP_ID", "STOPPED", "ReleaseStopParams", "StopId", "Stopped", "StoppedNotification", "new_stop_id"]

STOPPED: Final = "openrois.lease.stopped"
"""The name of the notification; in an adapter's answer to `openrois.hello` it says that the adapter keeps the latch."""


MAX_STOP_ID: Final = 64
"""Characters of the id of a STOP."""

StopId: TypeAlias = Annotated[str, Field(max_length=MAX_STOP_ID)]


def new_stop_id() -> str:
    """Return the id of a STOP that begins."""
    return secrets.token_hex(16)


class Stopped(Model):
    """An engine, the person that has stopped it for programs, and the id of that STOP."""

    engine_id: str
    by: str
    stop_id: str = ""


class StoppedNotification(Model):
    """Params of the notification `openrois.lease.stopped`, to applications and to the adapter of the engine.

    Attributes:
        engine_id: the engine.
        by: the person that has stopped it for programs; empty once it is handed back.
        reason: one sentence for a person.
        stop_id: of the STOP, or of the one that was ended; another one with each STOP.
    """

    method: ClassVar[str] = STOPPED

    engine_id: str
    by: str = ""
    reason: str = ""
    stop_id: str = ""


class ReleaseStopParams(Model):
    """Params of `openrois.lease.release_stop`: an engine, or the one of a component.

    Attributes:
        engine_id: the engine.
        component_ref: a component of the engine, in place of its id.
        stop_id: of the STOP that is to end, and no later one; any, unless given.
    """

    engine_id: str | None = None
    component_ref: str | None = None
    stop_id: StopId | None = None
