"""The senses of a camera behind one engine id; the test sets what is seen."""

from typing import Any

from openrois_body.camera_senses import CameraSenses, camera_senses
from openrois_body.sensing.changes import Place
from openrois_body.vision.box import Box
from openrois_body.vision.sighting import Person, Sighting
from openrois_media.devices import Camera

from openrois.contract import Event
from openrois.engine.registry import LocalRegistry
from openrois.types.messages import Argument
from openrois.types.values import decode_value
from tests.support.streaming import VirtualClock

__all__ = ["CameraStage", "seen_person"]


def seen_person(number: int = 1, x: float = 0.0, y: float = 1.0, **more: Any) -> Person:
    """A person at a place."""
    return Person(number, Box(0.4, 0.3, 0.2, 0.3), Place(x, y, 0.0), **more)


class CameraStage:
    """All senses of a camera, and what those who listen hear."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.camera = Camera()
        self.senses: CameraSenses = camera_senses("avatar", self.camera, self.clock)
        self.registry = LocalRegistry("avatar", self.senses.components)
        self.heard: list[dict[str, Any]] = []

    async def listen(self, component: str, event: str) -> str:
        """Subscribe to an event."""
        return await self.registry.subscribe(f"avatar/{component}", event, self._hear)

    async def set(self, component: str, **values: str) -> None:
        """Set parameters of a component."""
        arguments = tuple(Argument(name=name, data_type_ref="int", value=value) for name, value in values.items())
        await self.registry.invoke(f"avatar/{component}", "set_parameter", arguments)

    def see(self, *persons: Person, passed: float = 0.1) -> list[dict[str, Any]]:
        """Let the watch see persons in the next picture; return the events about them."""
        self.clock.jump(passed)
        before = len(self.heard)
        self.senses.watch.seen.notify_all(Sighting(self.clock.now(), persons))
        return self.heard[before:]

    def _hear(self, item: object) -> None:
        assert isinstance(item, Event)
        told = {result.name: decode_value(result.data_type_ref, result.value) for result in item.results}
        told.pop("timestamp", None)
        self.heard.append(told)
