"""What the sensing components have in common: RoIS_Common, and working only for those who listen."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field

from openrois.adapter import parameter
from openrois_avatar.sensing.activity import Activity
from openrois_avatar.sensing.changes import Movements, Place

__all__ = ["Localizing", "Sense"]


class Sense:
    """Makes a component a sense, where it stands before the standard's base class:

        class FaceDetection(Sense, components.FaceDetection):
            def __init__(self, ...) -> None:
                super().__init__()

    `activity` tells whether it has to work, and when that changes. `start` ends at once: the sense goes on until
    `stop`.
    """  # noqa: D415 - the sentence ends in the example

    def __init__(self, name: str | None = None) -> None:
        super().__init__(name)  # type: ignore[call-arg]
        self.activity = Activity()

    async def start(self) -> None:
        """Work until `stop`, also while nobody subscribes."""
        self.activity.start()

    async def stop(self) -> None:
        """Work no more, until the next `start` or the next subscription."""
        self.activity.stop()

    async def suspend(self) -> None:
        """Pause until `resume`."""
        self.activity.suspend()

    async def resume(self) -> None:
        """Go on."""
        self.activity.resume()

    def subscribers_changed(self, event_type: str, number: int) -> None:
        """Work for those who subscribe."""
        self.activity.subscribers_changed(event_type, number)


class Localizing(Sense):
    """A sense that tells places, as its two parameters filter them: where none is set, every movement is told."""

    detection_threshold: Annotated[int, Field(ge=0)] | None = parameter(None)
    minimum_interval: Annotated[int, Field(ge=0)] | None = parameter(None)

    def __init__(self, name: str | None = None) -> None:
        super().__init__(name)
        self._movements = Movements()

    def tells(self, places: Mapping[str, Place], now: float) -> bool:
        """Take all places there are, by their refs, and the time in seconds; whether they have to be told."""
        return self._movements.tells(places, now, self.detection_threshold, self.minimum_interval)

    def forget_places(self) -> None:
        """Begin anew: whoever listens now has not heard where anything is."""
        self._movements = Movements()
