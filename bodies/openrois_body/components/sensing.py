"""The base of the sensing components: RoIS_Common, and activity by subscriptions."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field

from openrois.adapter import parameter
from openrois.aio.listeners import Listeners
from openrois_body.sensing.activity import Activity
from openrois_body.sensing.changes import Movements, Place

__all__ = ["Localizing", "Sense"]


class Sense:
    """Mixin that makes a component a sense; it stands before the standard's base class:

        class FaceDetection(Sense, components.FaceDetection):
            def __init__(self, ...) -> None:
                super().__init__()

    `activity` has whether the sense is active. `start` completes at once: the sense is active until `stop`.
    """  # noqa: D415 - the sentence ends in the example

    def __init__(self, name: str | None = None) -> None:
        super().__init__(name)  # type: ignore[call-arg]
        self.activity = Activity()
        self.visitor_ref = ""
        """Visitor of whom the next event tells; empty for none. The component sets it before it announces."""
        self.attributed: Listeners[str, str] = Listeners()
        """Called with the name of an event that is about to be announced, and the visitor that it tells of."""

    def __rois_announce__(self, method: str, values: tuple[object, ...], named: Mapping[str, object]) -> None:
        """Announce an event, and before it whom it tells of: the standard's events have no member for that."""
        if self.visitor_ref:
            self.attributed.notify_all(method, self.visitor_ref)
        super().__rois_announce__(method, values, named)  # type: ignore[misc]

    async def start(self) -> None:
        """Be active until `stop`, also without a subscription."""
        self.activity.start()

    async def stop(self) -> None:
        """Be inactive until the next `start` or the next subscription."""
        self.activity.stop()

    async def suspend(self) -> None:
        """Pause until `resume`."""
        self.activity.suspend()

    async def resume(self) -> None:
        """Go on."""
        self.activity.resume()

    def subscribers_changed(self, event_type: str, number: int) -> None:
        """Be active while there is a subscription."""
        self.activity.subscribers_changed(event_type, number)


class Localizing(Sense):
    """A sense that announces places, filtered by its two parameters; without them it announces every movement."""

    detection_threshold: Annotated[int, Field(ge=0)] | None = parameter(None)
    minimum_interval: Annotated[int, Field(ge=0)] | None = parameter(None)

    def __init__(self, name: str | None = None) -> None:
        super().__init__(name)
        self._movements = Movements()

    def is_news(self, places: Mapping[str, Place], now: float) -> bool:
        """Return whether all places, by their refs, have to be announced at this time in seconds."""
        return self._movements.is_news(places, now, self.detection_threshold, self.minimum_interval)

    def forget_places(self) -> None:
        """Forget all announced places: new subscribers have not received them."""
        self._movements = Movements()
