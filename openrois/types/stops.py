"""Messages about engines that a person has stopped: what programs wait for, and how a person hands them back."""

from typing import ClassVar, Final

from openrois.types.model import Model

__all__ = ["STOPPED", "ReleaseStopParams", "Stopped", "StoppedNotification"]

STOPPED: Final = "openrois.lease.stopped"
"""The name of the notification; in an adapter's answer to `openrois.hello` it says that the adapter keeps the latch."""


class Stopped(Model):
    """An engine, and the person that has stopped it for programs."""

    engine_id: str
    by: str


class StoppedNotification(Model):
    """Params of the notification `openrois.lease.stopped`, to applications and to the adapter of the engine.

    Attributes:
        engine_id: the engine.
        by: the person that has stopped it for programs; empty once it is handed back.
        reason: one sentence for a person.
    """

    method: ClassVar[str] = STOPPED

    engine_id: str
    by: str = ""
    reason: str = ""


class ReleaseStopParams(Model):
    """Params of `openrois.lease.release_stop`: an engine, or the one of a component."""

    engine_id: str | None = None
    component_ref: str | None = None
