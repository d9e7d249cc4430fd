"""Persons and sounds of the game engine's scene, as the standard's sensing components."""

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Final

from openrois_streaming.clock import MediaClock

from openrois.adapter import Component, ComponentStatus, components
from openrois.aio.tasks import TaskScope
from openrois_body.components.sensing import Localizing, Sense
from openrois_body.messages import Kind
from openrois_body.motion.world import World
from openrois_body.sensing.activity import Activity
from openrois_body.sensing.changes import Numbers, Place

__all__ = ["ScenePersonDetection", "ScenePersonLocalization", "SceneSoundLocalization", "scene_senses"]

_MILLISECOND: Final = 0.001
_SHORTEST: Final = 0.05
"""Seconds between two looks at the scene, however often the engine reports changes."""
_LONGEST: Final = 0.5
"""Seconds after which the interval is read again: another one may have been set."""


class _InScene:
    """Observes the scene when it changes, while the sense is active."""

    activity: Activity

    def place_in(self, world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]) -> None:
        """Set the scene and the game engine's status; called by `__init__`."""
        self._world = world
        self._clock = clock
        self._engine_status = engine_status
        self._news = asyncio.Event()
        self._begins = False
        self._scope = TaskScope()
        world.changed.add(lambda _change: self._news.set())
        self.activity.changed.add(self._activity_changed)

    def condition(self) -> ComponentStatus:
        """Return the status of the game engine."""
        return self._engine_status()

    async def connect(self) -> None:
        """Start to wait for changes."""
        self._scope = TaskScope()
        await self._scope.__aenter__()
        self._scope.start(self._watch())

    async def disconnect(self) -> None:
        """Stop waiting for changes."""
        await self._scope.__aexit__(None, None, None)

    def announce_changes(self, now: float) -> None:
        """Announce what has changed; `now` is in seconds of the clock."""
        raise NotImplementedError

    def interval(self) -> int:
        """Return the milliseconds after an announcement before which there is no other, as set now."""
        return 0

    def reset_announced(self) -> None:
        """Forget what was announced: new subscribers have not received it."""
        raise NotImplementedError

    def places(self, kind: Kind) -> dict[str, Place]:
        """Return where the things of a kind are, by their refs."""
        things = self._world.things
        return {self._world.ref(each): Place(each.x, each.y, each.th) for each in things if each.kind == kind}

    def now(self) -> datetime:
        """Return the time of day."""
        return datetime.fromtimestamp(self._clock.wall(), UTC)

    def _activity_changed(self, works: bool) -> None:
        if works:
            self.reset_announced()
            self._begins = True
            self._news.set()

    def _pause(self) -> float:
        return max(self.interval() * _MILLISECOND, _SHORTEST)

    async def _watch(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            if self.activity.works:
                # A change that comes too early is looked at afterwards: the engine may not report it again.
                began = self._clock.now()
                self._begins = False
                self.announce_changes(began)
                while not self._begins and (left := began + self._pause() - self._clock.now()) > 0:
                    await self._clock.sleep_until(self._clock.now() + min(left, _LONGEST))


class ScenePersonDetection(_InScene, Sense, components.PersonDetection):
    """Announces how many persons are in the game engine's scene: ground truth, nothing is recognised.

    Args:
        world: the scene.
        clock: the media clock.
        engine_status: returns the status of the game engine.
    """

    def __init__(self, world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__("scene_person_detecter")
        self._numbers = Numbers()
        self.place_in(world, clock, engine_status)

    def announce_changes(self, now: float) -> None:
        """Announce a changed number."""
        number = len(self.places("person"))
        if self._numbers.is_news(number):
            self.person_detected(number, self.now())

    def reset_announced(self) -> None:
        """Announce the number again, and 0 where it was another one."""
        self._numbers.begin()


class _Localizing(_InScene, Localizing):
    """Announces where the things of a kind are."""

    kind: Kind
    _told = False

    def announce_changes(self, now: float) -> None:
        """Announce movements beyond the threshold."""
        places = self.places(self.kind)
        self._told = self.is_news(places, now)
        if self._told:
            self.announce_places(tuple(places), tuple(place.text for place in places.values()), self.now())

    def interval(self) -> int:
        """Return `minimum_interval` after an announcement, else 0."""
        return (self.minimum_interval or 0) if self._told else 0

    def reset_announced(self) -> None:
        """Announce all places again, however soon."""
        self.forget_places()

    def announce_places(self, refs: tuple[str, ...], places: tuple[str, ...], moment: datetime) -> None:
        """Announce the event."""
        raise NotImplementedError


class ScenePersonLocalization(_Localizing, components.PersonLocalization):
    """Announces where the persons of the game engine's scene are; as `ScenePersonDetection`."""

    kind = "person"

    def __init__(self, world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__("scene_person_localizer")
        self.place_in(world, clock, engine_status)

    def announce_places(self, refs: tuple[str, ...], places: tuple[str, ...], moment: datetime) -> None:
        """Announce `person_localized`."""
        self.person_localized(refs, places, moment)


class SceneSoundLocalization(_Localizing, components.SoundLocalization):
    """Announces where the sounds of the game engine's scene come from; as `ScenePersonDetection`."""

    kind = "sound"

    def __init__(self, world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__("scene_sound_localizer")
        self.place_in(world, clock, engine_status)

    def announce_places(self, refs: tuple[str, ...], places: tuple[str, ...], moment: datetime) -> None:
        """Announce `sound_localized`."""
        self.sound_localized(refs, places, moment)


def scene_senses(
    world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]
) -> tuple[Component, ...]:
    """Return all senses of a scene."""
    return tuple(
        sense(world, clock, engine_status)
        for sense in (ScenePersonDetection, ScenePersonLocalization, SceneSoundLocalization)
    )
