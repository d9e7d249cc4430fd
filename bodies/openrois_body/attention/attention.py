"""Attention of a body with several visitors: microphone and camera of its senses are those of one of them."""

import asyncio
from contextlib import AsyncExitStack
from typing import Final, Literal

from openrois_media.devices import LEVEL_INTERVAL, Camera, Microphone
from openrois_media.visitors.registry import VisitorRegistry
from openrois_media.visitors.visitor import Visitor
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.loudness import FLOOR, LevelMeter
from openrois_streaming.source.source import RawAudio

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois.types.codes import Purpose
from openrois_body.attention.faces import FaceSizes
from openrois_body.attention.rule import NEAREST, AttentionRule, Candidate

__all__ = ["Attention"]

_LIVE: Final = frozenset({Purpose.LIVE})
_USES: Final = frozenset({Purpose.LIVE, Purpose.RECOGNITION})
_RECOGNITION: Final = frozenset({Purpose.RECOGNITION})


class Attention:
    """Chooses the visitor whose microphone and camera the senses get. `run` has to run.

    A visitor is attended to as soon as it comes, where there is no other. Of several the loudness of each voice is
    measured, and the size of each face now and then; only who is attended to is analysed in full. Where that visitor
    sends no camera, or no microphone, the first other one that does is seen, or heard.

    Args:
        visitors: who may be attended to.
        microphone: that of the senses.
        camera: likewise.
        faces: sizes of faces; None for a body that does not see.
        clock: the media clock.

    Attributes:
        mode: whom to attend to: `nearest`, `loudest`, or a visitor_ref.
        attended_changed: called with the visitor_ref of who is attended to from now on; empty for none.
    """

    def __init__(
        self,
        visitors: VisitorRegistry,
        microphone: Microphone,
        camera: Camera,
        clock: MediaClock,
        faces: FaceSizes | None = None,
    ) -> None:
        self.mode = NEAREST
        self.attended_changed: Listeners[str] = Listeners()
        self._visitors = visitors
        self._microphone = microphone
        self._camera = camera
        self._faces = faces
        self._clock = clock
        self._rule = AttentionRule()
        self._meters: dict[Visitor, _Meter] = {}
        self._several = asyncio.Event()
        """Set while there is a choice."""
        visitors.changed.add(self._on_changed)

    @property
    def attended(self) -> str:
        """The visitor_ref of who is attended to; empty for none."""
        return self._rule.attended

    def set_mode(self, mode: str) -> None:
        """Attend by another rule, or to the visitor that is named, from now on."""
        self.mode = mode
        self.choose()

    def choose(self) -> None:
        """Choose by what is known now."""
        # Who consents to nothing cannot be attended to.
        present = [each for each in self._visitors.present if each.consent.purposes & _USES]
        before = self._rule.attended
        candidates = [self._candidate(each) for each in present]
        attended = self._rule.choose(self.mode, candidates, self._clock.now())
        ordered = sorted(present, key=lambda each: each.visitor_ref != attended)
        self._microphone.attend(_first_with("audio", ordered))
        self._camera.attend(_first_with("video", ordered))
        if attended != before:
            self.attended_changed.notify_all(attended)

    async def run(self) -> None:
        """Measure and choose until cancelled, while there are several."""
        while True:
            await self._several.wait()
            async with AsyncExitStack() as stack:
                tasks = await stack.enter_async_context(TaskScope())
                if self._faces is not None:
                    tasks.start(self._faces.watch_visitors(self._unseen))
                while self._several.is_set():
                    self._measure(tasks)
                    await self._clock.sleep_until(self._clock.now() + LEVEL_INTERVAL)
                    for meter in self._meters.values():
                        meter.read()
                    self.choose()
            self._meters.clear()

    def note_face(self, visitor_ref: str, share: float) -> None:
        """Note how large the face of the visitor is that is analysed."""
        if self._faces is not None and visitor_ref:
            self._faces.note(visitor_ref, share)

    def _on_changed(self, _visitor: Visitor) -> None:
        present = self._visitors.present
        if len(present) > 1:
            self._several.set()
        else:
            self._several.clear()
        if self._faces is not None:
            self._faces.keep_only(frozenset(each.visitor_ref for each in present if each.consent.holds(_RECOGNITION)))
        self.choose()

    def _candidate(self, visitor: Visitor) -> Candidate:
        meter = self._meters.get(visitor)
        face = 0.0 if self._faces is None else self._faces.of(visitor.visitor_ref)
        return Candidate(visitor.visitor_ref, FLOOR if meter is None else meter.loudness, face)

    def _unseen(self) -> tuple[Visitor, ...]:
        """Return those whose camera is not analysed, and may be."""
        return tuple(
            each
            for each in self._visitors.present
            if self.mode == NEAREST
            and each.sends("video")
            and not (self._faces is not None and self._faces.are_analysed(each.visitor_ref))
            and each.consent.holds(_RECOGNITION)
        )

    def _measure(self, tasks: TaskScope) -> None:
        """Measure every microphone, and no other."""
        sending = [each for each in self._visitors.present if each.sends("audio")]
        for visitor in [each for each in self._meters if each not in sending]:
            self._meters.pop(visitor).cancel()
        for visitor in sending:
            if visitor not in self._meters:
                meter = self._meters[visitor] = _Meter()
                meter.task = tasks.start(meter.listen(visitor))


class _Meter:
    """Loudness of one visitor's microphone, as far as it may be heard."""

    def __init__(self) -> None:
        self.loudness = FLOOR
        self.task: asyncio.Task[None] | None = None
        self._meter = LevelMeter()

    async def listen(self, visitor: Visitor) -> None:
        """Measure until cancelled."""
        async with visitor.source("audio", _LIVE).open() as blocks:
            async for block in blocks:
                sound: RawAudio = block
                self._meter.add(sound.samples)

    def read(self) -> None:
        """Take the loudness since the last reading."""
        self.loudness = self._meter.read().rms

    def cancel(self) -> None:
        """Stop measuring."""
        if self.task is not None:
            self.task.cancel()


def _first_with(kind: Literal["audio", "video"], visitors: list[Visitor]) -> Visitor | None:
    return next((each for each in visitors if each.sends(kind)), None)
