"""What the game engine knows of people and sounds in its scene, told as the standard's senses tell it."""

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Final

from openrois_streaming.clock import MediaClock

from openrois.adapter import Component, ComponentStatus, components
from openrois.aio.tasks import TaskScope
from openrois_avatar.components.sensing import Localizing, Sense
from openrois_avatar.link.messages.motion import Kind
from openrois_avatar.sensing.activity import Activity
from openrois_avatar.sensing.changes import Numbers, Place
from openrois_avatar.world import World

__all__ = ["ScenePersonDetection", "ScenePersonLocalization", "SceneSoundLocalization", "scene_senses"]

_MILLISECOND: Final = 0.001
_SHORTEST: Final = 0.05
"""Seconds between two looks at the scene, however often the engine tells of it."""
_LONGEST: Final = 0.5
"""Seconds after which it is asked again how long an interval is: another one may have been set."""


class _InScene:
    """Looks at the scene when something has changed in it, while the sense has to work."""

    activity: Activity

    def place_in(self, world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]) -> None:
        """Say what scene it is, and how the game engine fares; called by `__init__`."""
        self._world = world
        self._clock = clock
        self._engine_status = engine_status
        self._news = asyncio.Event()
        self._begins = False
        self._scope = TaskScope()
        world.changed.add(lambda _change: self._news.set())
        self.activity.changed.add(self._activity_changed)

    def condition(self) -> ComponentStatus:
        """Follow the game engine."""
        return self._engine_status()

    async def connect(self) -> None:
        """Begin to wait for changes."""
        self._scope = TaskScope()
        await self._scope.__aenter__()
        self._scope.start(self._watch())

    async def disconnect(self) -> None:
        """Wait no more."""
        await self._scope.__aexit__(None, None, None)

    def look(self, now: float) -> None:
        """Tell what is worth telling; `now` is when, in seconds of the clock."""
        raise NotImplementedError

    def interval(self) -> int:
        """Return the milliseconds after a look before which nothing more is to be told, as they are set now."""
        return 0

    def forget(self) -> None:
        """Forget what was told: somebody new listens."""
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
            self.forget()
            self._begins = True
            self._news.set()

    def _pause(self) -> float:
        return max(self.interval() * _MILLISECOND, _SHORTEST)

    async def _watch(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            if self.activity.works:
                # What comes too early is looked at then: nobody may say it again.
                began = self._clock.now()
                self._begins = False
                self.look(began)
                while not self._begins and (left := began + self._pause() - self._clock.now()) > 0:
                    await self._clock.sleep_until(self._clock.now() + min(left, _LONGEST))


class ScenePersonDetection(_InScene, Sense, components.PersonDetection):
    """Tells how many persons are in the game engine's scene: ground truth, nothing is recognised.

    Args:
        world: the scene.
        clock: the media clock.
        engine_status: tells whether the game engine works now.
    """

    def __init__(self, world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__("scene_person_detecter")
        self._numbers = Numbers()
        self.place_in(world, clock, engine_status)

    def look(self, now: float) -> None:
        """Tell another number."""
        number = len(self.places("person"))
        if self._numbers.tells(number):
            self.person_detected(number, self.now())

    def forget(self) -> None:
        """Tell the number again, and 0 where it was another one."""
        self._numbers.begin()


class _Localizing(_InScene, Localizing):
    """Tells where the things of a kind are."""

    kind: Kind
    _told = False

    def look(self, now: float) -> None:
        """Tell those that have moved far enough."""
        places = self.places(self.kind)
        self._told = self.tells(places, now)
        if self._told:
            self.tell(tuple(places), tuple(place.text for place in places.values()), self.now())

    def interval(self) -> int:
        """Return `minimum_interval`, after a look that found something to tell."""
        return (self.minimum_interval or 0) if self._told else 0

    def forget(self) -> None:
        """Tell again where everybody is, however soon."""
        self.forget_places()

    def tell(self, refs: tuple[str, ...], places: tuple[str, ...], moment: datetime) -> None:
        """Announce the event."""
        raise NotImplementedError


class ScenePersonLocalization(_Localizing, components.PersonLocalization):
    """Tells where the persons of the game engine's scene are; as `ScenePersonDetection`."""

    kind = "person"

    def __init__(self, world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__("scene_person_localizer")
        self.place_in(world, clock, engine_status)

    def tell(self, refs: tuple[str, ...], places: tuple[str, ...], moment: datetime) -> None:
        """Announce `person_localized`."""
        self.person_localized(refs, places, moment)


class SceneSoundLocalization(_Localizing, components.SoundLocalization):
    """Tells where the sounds of the game engine's scene come from; as `ScenePersonDetection`."""

    kind = "sound"

    def __init__(self, world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__("scene_sound_localizer")
        self.place_in(world, clock, engine_status)

    def tell(self, refs: tuple[str, ...], places: tuple[str, ...], moment: datetime) -> None:
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
