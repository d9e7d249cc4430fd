"""What the game engine has told of its scene: where the figure is, where it can go, and what else is there. Pure."""

from typing import Final

from openrois.aio.listeners import Listeners
from openrois.errors import BadParameter
from openrois_avatar.link.messages import Event, Floor, Place, Thing, Things

__all__ = ["World", "thing_ref"]

_MOST_NAMED: Final = 10
"""Names in a sentence on what there is."""


def thing_ref(engine_id: str, thing: Thing) -> str:
    """Return the ref of a thing of the scene; `engine_id` is the adapter's."""
    return f"urn:x-rois:def:{thing.kind}:OpenRoIS::{engine_id}/scene/{thing.id}"


class World:
    """The scene of the game engine that is connected now; empty while none is, and until it has told something.

    Args:
        engine_id: leads the refs of things.

    Attributes:
        place: where the figure is.
        floor: where it can go; None where the engine has told no limits.
        things: what there is beside the figure.
        changed: are told what is new after it is known here: the event of the engine, or None when all is unknown.
    """

    def __init__(self, engine_id: str) -> None:
        self.engine_id = engine_id
        self.place: Place | None = None
        self.floor: Floor | None = None
        self.things: tuple[Thing, ...] = ()
        self.changed: Listeners[Place | Floor | Things | None] = Listeners()

    def take(self, event: Event) -> None:
        """Take an event of the game engine; one that says again what is known changes nothing."""
        match event:
            case Place() if event != self.place:
                self.place = event
            case Floor() if event != self.floor:
                self.floor = event
            case Things() if event.things != self.things:
                self.things = event.things
            case _:
                return
        self.changed.tell(event)

    def clear(self) -> None:
        """The game engine is gone, and its scene with it."""
        self.place, self.floor, self.things = None, None, ()
        self.changed.tell(None)

    def ref(self, thing: Thing) -> str:
        """Return the ref of a thing."""
        return thing_ref(self.engine_id, thing)

    def find(self, called: str) -> Thing:
        """Return the thing with this ref, id or name, in this order.

        Raises:
            BadParameter: there is none, or there are several of this name; the text names what there is.
        """
        by_key = [thing for thing in self.things if called in (self.ref(thing), thing.id)]
        found = by_key or [thing for thing in self.things if thing.name and thing.name == called]
        if len(found) == 1:
            return found[0]
        if found:
            raise BadParameter(f"{called!r}: {len(found)} things have this name; their refs tell them apart")
        there = ", ".join(repr(thing.name or thing.id) for thing in self.things[:_MOST_NAMED]) or "nothing"
        raise BadParameter(f"{called!r} is not in the scene; there is {there}")
