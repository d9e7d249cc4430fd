"""The body that a component from outside is added to, as its constructor gets it."""

from dataclasses import dataclass
from typing import TypeVar

from openrois_streaming.clock import MediaClock

from openrois.component.component import Component
from openrois_body.body import Body
from openrois_body.speech.speaker import Speaker

__all__ = ["HostBody"]

_C = TypeVar("_C", bound=Component)


@dataclass(frozen=True, slots=True)
class HostBody:
    """The body that a component is added to by `--component`.

    What is done with it is not asked of the leases of its components: `voice.say` waits for its turn, as every speech
    does, but a reaction replaces the one that plays.

    Attributes:
        engine_id: leads every ref.
        clock: the media clock.
        components: those that the body has by itself.
        voice: speaks; None where the body has no voice of ours.
        figure: moves mouth and eyes, and plays reactions; None where no engine of ours moves the body.
    """

    engine_id: str
    clock: MediaClock
    components: tuple[Component, ...]
    voice: Speaker | None = None
    figure: Body | None = None

    def find(self, kind: type[_C]) -> _C | None:
        """Return the body's component of a class; None if it has none."""
        return next((each for each in self.components if isinstance(each, kind)), None)
