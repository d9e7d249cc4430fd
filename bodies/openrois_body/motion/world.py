"""The game engine's scene as it was reported: the figure's place, the floor, and the things on it. Pure."""

from typing import Final

from openrois.aio.listeners import Listeners
from openrois.errors import BadParameter
from openrois_body.messages import Event, Floor, Place, Thing, Things

__all__ = ["World", "thing_ref"]

_MOST_NAMED: Final = 10
"""Most names in a sentence that lists things."""


def thing_ref(engine_id: str, thing: Thing) -> str:
    """Return the ref of a thing of the scene; `engine_id` is the adapter's."""
    return f"urn:x-rois:def:{thing.kind}:OpenRoIS::{engine_id}/scene/{thing.id}"


class World:
    """The scene of the connected game engine; empty without one, and until it has reported something.

    Args:
        engine_id: leads the refs of things.

    Attributes:
        place: where the figure is.
        floor: where it can go; None where the engine has reported no limits.
        things: the things beside the figure.
        changed: called after a change with the event of the engine, or with None when the scene is cleared.
    """

    def __init__(self, engine_id: str) -> None:
        self.engine_id = engine_id
        self.place: Place | None = None
        self.floor: Floor | None = None
        self.things: tuple[Thing, ...] = ()
        self.changed: Listeners[Place | Floor | Things | None] = Listeners()

    def handle_event(self, event: Event) -> None:
        """Update the scene with an event of the game engine; one without news changes nothing."""
        match event:
            case Place() if event != self.place:
                self.place = event
            case Floor() if event != self.floor:
                self.floor = event
            case Things() if event.things != self.things:
                self.things = event.things
            case _:
                return
        self.changed.notify_all(event)

    def clear(self) -> None:
        """Clear the scene: the game engine is disconnected."""
        self.place, self.floor, self.things = None, None, ()
        self.changed.notify_all(None)

    def ref(self, thing: Thing) -> str:
        """Return the ref of a thing."""
        return thing_ref(self.engine_id, thing)

    def find(self, called: str) -> Thing:
        """Return the thing with this ref, id or name, in this order.

        Raises:
            BadParameter: no thing, or several things have this name; the text lists the things.
        """
        by_key = [thing for thing in self.things if called in (self.ref(thing), thing.id)]
        found = by_key or [thing for thing in self.things if thing.name and thing.name == called]
        if len(found) == 1:
            return found[0]
        if found:
            raise BadParameter(f"{called!r} is the name of {len(found)} things; use one of their refs")
        there = ", ".join(repr(thing.name or thing.id) for thing in self.things[:_MOST_NAMED]) or "nothing"
        raise BadParameter(f"{called!r} is not in the scene; there is {there}")
