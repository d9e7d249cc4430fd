"""The loop of every embedded game engine: paced pictures and sound out, commands in.

Pictures belong to deadlines on CLOCK_MONOTONIC: the picture of a deadline shows the body at that moment and carries it
as its timestamp. A loop that is late skips to the newest deadline; nothing is queued. Sound is sent ahead of its time,
so that it is there when its moment comes, however long a picture takes; a reaction begins, and is stopped, at the first
moment for which the sound was not sent yet, in picture and sound alike. Without demand no picture is drawn, and no
silence is sent: body and room go on unseen, and the next picture is drawn as soon as there is demand.
"""

import argparse
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import Final, Protocol, assert_never

import cv2
import numpy as np

from openrois.version import __version__
from openrois_avatar.engines.animation.animator import Animator
from openrois_avatar.engines.animation.idle import blink
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.animation.reactions import REACTIONS
from openrois_avatar.engines.animation.visemes import SHAPES, Track
from openrois_avatar.engines.room.life import Life
from openrois_avatar.engines.room.plan import HOME
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.room.shot import shot
from openrois_avatar.engines.settings import LARGE, SMALL, Available, Factory, Picture, Pixels, Renderer
from openrois_avatar.engines.sound import PERIOD, Samples, Sound
from openrois_avatar.link.client import connect_from_environment
from openrois_avatar.link.messages import (
    Bitrate,
    Command,
    Completed,
    Demand,
    Drive,
    Event,
    Halt,
    Hello,
    Idle,
    Input,
    KeyFrame,
    LinkError,
    Log,
    Look,
    Place,
    Quit,
    React,
    Silence,
    Speak,
    Stop,
    VideoShape,
    Viewpoint,
    Walk,
)
from openrois_avatar.link.protocol import PixelFormat
from openrois_avatar.options.picture_size import AUTOMATIC, SIZE_HELP, picture_size

UNAVAILABLE: Final = 3
"""Exit status of an engine that cannot run on this machine; stderr has the reason."""
LINK_LOST: Final = 4
"""Exit status when the adapter could not be reached, or refused the engine."""
_STILL_SEED: Final = 1
AHEAD: Final = 0.06
"""Seconds by which sound is sent ahead of its time: more than a picture takes, and less than a person notices."""
_REPORT: Final = 10.0
"""Seconds between two reports of skipped pictures and blocks."""
_SIGN: Final = 0.5
"""Seconds between two signs of life while nothing is drawn."""
_UNSEEN: Final = 0.1
"""Seconds between two deadlines of body and room while nothing is drawn."""


def main(name: str, available: Available, factory: Factory, viewpoints: Sequence[str], arguments: Sequence[str]) -> int:
    """Run an engine until its link ends, or draw one still; return the exit status.

    Args:
        name: of the engine.
        available: returns whether it runs here.
        factory: makes its renderer.
        viewpoints: those that it offers, of `openrois_avatar.engines.room.shot.VIEWPOINTS`.
        arguments: of the command line.
    """
    options = _options(name, arguments)
    works, hint = available()
    if not works:
        print(hint, file=sys.stderr)
        return UNAVAILABLE
    if options.still:
        width, height = options.size or SMALL
        return _still(factory(Picture(width, height, options.fps)), options)
    renderer, picture = _made(factory, options)
    hello = Hello(
        name,
        __version__,
        VideoShape(picture.width, picture.height, picture.fps, "i420"),
        audio_channels=1,
        reactions=tuple(REACTIONS),
        hears=True,
        ring=True,
        walks=True,
        demand=True,
        viewpoints=tuple(viewpoints),
    )
    try:
        with connect_from_environment(hello) as link:
            Runner(link, renderer, picture, visited=options.visitor).run()
    except LinkError as error:
        print(f"engine link: {error}", file=sys.stderr)
        return LINK_LOST
    return 0


def _made(factory: Factory, options: argparse.Namespace) -> tuple[Renderer, Picture]:
    """Make the renderer, for pictures of the given size, or else of the size that this machine carries."""
    width, height = options.size or LARGE
    picture = Picture(width, height, options.fps)
    renderer = factory(picture)
    if options.size is None:
        # Needs the codecs: imported only where they decide.
        from openrois_avatar.engines.size_choice import choose_size, encoding

        picture, told = choose_size(renderer, options.fps, encoding(options.fps, i420))
        print(told, file=sys.stderr)
        if (picture.width, picture.height) != LARGE:
            renderer.resize(picture)
    return renderer, picture


def _options(name: str, arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog=f"python -m openrois_avatar.engines.{name}", description="Renders the avatar onto the engine link."
    )
    parser.add_argument("--size", type=picture_size, default=AUTOMATIC, metavar="WIDTHxHEIGHT", help=SIZE_HELP)
    parser.add_argument("--fps", type=int, choices=range(1, 121), default=Picture().fps, metavar="1..120")
    parser.add_argument("--visitor", action="store_true", help="let a person walk about in the room")
    still = parser.add_argument_group("one picture instead of a stream")
    still.add_argument("--still", metavar="FILE", help="draw one picture into this file and end")
    still.add_argument("--reaction", choices=REACTIONS)
    still.add_argument("--viseme", choices=SHAPES)
    still.add_argument("--place", type=_place, default=HOME, metavar="X,Y,TH", help="where it is, seen from afar")
    still.add_argument("--at", type=float, default=0.0, metavar="SECONDS", help="how long the reaction has played")
    return parser.parse_args(arguments)


def _place(text: str) -> Place:
    try:
        x, y, th = (float(part) for part in text.split(","))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"must be metres, metres and radians, as 1,0.5,-1.57, not {text!r}") from error
    return Place(x, y, th)


def _still(renderer: Renderer, options: argparse.Namespace) -> int:
    place = options.place
    scene = AT_HOME if place == HOME else Scene(place, None, shot(place.x, place.y, 1.0))
    pixels = renderer.draw(still_pose(options.reaction, options.viseme, options.at), scene)
    if not cv2.imwrite(options.still, pixels[:, :, :3]):
        print(f"cannot write {options.still}", file=sys.stderr)
        return 1
    return 0


def still_pose(reaction: str | None = None, viseme: str | None = None, at: float = 0.0) -> Pose:
    """Return the pose `at` seconds into a reaction, with the mouth in the shape of a viseme; without either, at rest.

    It is a moment between two blinks.
    """
    animator = Animator(_STILL_SEED)
    start = next(moment for moment in count(10.0, 0.1) if blink(moment + at, _STILL_SEED) == 0.0)
    if viseme is not None:
        animator.speak(start - 1, Track(start - 1, [(0.0, viseme, 1.0)], at + 5.0))
    if reaction is not None:
        animator.react(start, "still", reaction)
    return animator.pose(start + at)


class Link(Protocol):
    """The part of `LinkClient` that the runner uses."""

    @property
    def connected(self) -> bool:
        """False once the link has ended."""

    def poll_commands(self, timeout: float = 0.0) -> list[Command]:
        """Return the commands that have arrived; wait up to `timeout` seconds for a first one."""

    def poll_audio(self) -> Sequence[Samples]:
        """Return the operator's sound that has arrived."""

    def draw_video(
        self, draw: Callable[[Pixels], None], width: int, height: int, format: PixelFormat, timestamp_ns: int
    ) -> None:
        """Send a picture, which `draw` writes into the array that it is given."""

    def send_audio(self, samples: Samples, timestamp_ns: int) -> None:
        """Send a block of sound."""

    def send_event(self, event: Event) -> None:
        """Send an event."""


@dataclass(slots=True)
class _Skips:
    """Pictures and blocks of sound that were skipped since the last report."""

    pictures: int = 0
    blocks: int = 0


class Runner:
    """Serves one link with one renderer until either ends."""

    def __init__(
        self,
        link: Link,
        renderer: Renderer,
        picture: Picture,
        clock: Callable[[], float] = time.monotonic,
        *,
        visited: bool = False,
    ) -> None:
        self._link, self._renderer, self._picture, self._clock = link, renderer, picture, clock
        self._animator, self._sound = Animator(), Sound()
        self._life = Life(clock(), visited=visited)
        self._skips = _Skips()
        self._waiting: list[Command] = []
        self._coming: deque[tuple[float, React | Stop]] = deque()
        """Commands that take effect from a moment on."""
        self._sent = clock()
        """The moment up to which sound was sent."""
        self._pictures = _Ticks(clock(), 1 / picture.fps)
        self._wanted = True
        """Whether there is demand for pictures."""
        self._signed = clock()
        """When the last sign of life was sent."""
        self._quit = False

    def run(self) -> None:
        """Send pictures and sound on time until the link ends, or until `Quit`."""
        start = self._clock()
        self._pictures, blocks = _Ticks(start, 1 / self._picture.fps), _Ticks(start, PERIOD)
        reports = _Ticks(start + _REPORT, _REPORT)
        while self._link.connected and not self._quit:
            now = self._clock()
            if reports.due <= now:
                reports.next_tick()
                self._report()
            resting = self._is_resting()
            if resting:
                blocks.catch_up(now + AHEAD)
                self._sent = blocks.due
            if not resting and blocks.due - AHEAD <= now:
                self._skips.blocks += blocks.catch_up(now)
                self._send_sound(blocks.next_tick())
            elif self._pictures.due <= now:
                left_out = self._pictures.catch_up(now)
                self._skips.pictures += left_out if self._wanted else 0
                self._listen(0.0)
                self._live(self._pictures.next_tick())
            else:
                due = self._pictures.due if resting else min(blocks.due - AHEAD, self._pictures.due)
                self._listen(due - now)

    def _is_resting(self) -> bool:
        """Return whether there is neither demand for pictures nor sound."""
        return not self._wanted and self._sound.is_silent and self._life.radio == 0.0

    def _listen(self, seconds: float) -> None:
        """Receive commands, for `seconds` at most."""
        commands = self._link.poll_commands(seconds)
        for command in commands:
            if isinstance(command, Demand):
                self._heed(command)
            else:
                self._waiting.append(command)
            self._quit = self._quit or isinstance(command, Quit)
        if commands and not self._wanted:
            # Commands are obeyed at once, not at the next deadline, which may be far.
            self._pictures = _Ticks(self._clock(), _UNSEEN)

    def _heed(self, demand: Demand) -> None:
        """Start or stop drawing: the first picture of a new demand is due at once."""
        wanted = demand.consumers > 0
        if wanted and not self._wanted:
            self._pictures = _Ticks(self._clock(), 1 / self._picture.fps)
        self._wanted = wanted

    def _send_sound(self, due: float) -> None:
        self._link.send_audio(self._sound.block(due, self._life.radio), round(due * 1e9))
        self._sent = due + PERIOD

    def _live(self, due: float) -> None:
        """Advance body and room to `due`, and draw the picture if there is demand."""
        for command in self._waiting:
            self._obey(command, due)
        self._waiting = []
        self._begin(due)
        if heard := self._link.poll_audio():
            self._animator.follow_voice(due, heard)
        scene = self._life.advance(due, self._animator.is_expressive(due))
        if self._wanted:
            self._send_picture(self._renderer.draw(self._animator.pose(due, self._life.walking), scene), due)
        elif due >= self._signed + _SIGN:
            self._signed = due
            self._link.send_event(Idle())
        for outcome in self._animator.outcomes(due):
            self._link.send_event(Completed(outcome.id, outcome.status))
        for event in self._life.news():
            self._link.send_event(event)

    def _send_picture(self, pixels: Pixels, due: float) -> None:
        width, height = self._picture.width, self._picture.height
        self._link.draw_video(partial(write_i420, pixels), width, height, PixelFormat.I420, round(due * 1e9))

    def _obey(self, command: Command, now: float) -> None:
        match command:
            case React():
                self._sound.hush()
                self._sound.cue(command.reaction, self._sent)
                self._coming.append((self._sent, command))
            case Speak():
                visemes = [(viseme.offset_ms / 1e3, viseme.shape, viseme.weight) for viseme in command.visemes]
                self._animator.speak(now, Track(command.start_ns / 1e9, visemes, command.duration_ms / 1e3))
            case Silence():
                self._animator.silence(now)
                self._stay_unless_expressive(now)
            case Look():
                self._animator.turn_eyes(now, command.x, command.y)
            case Stop():
                self._sound.hush()
                self._coming.append((self._sent, command))
            case Walk() | Drive() | Halt():
                self._life.obey(now, command)
            case Viewpoint():
                self._life.show_from(command.name)
            case Quit() | Demand() | Input() | KeyFrame() | Bitrate():
                pass  # the first two are handled on arrival; HELLO asks for no input, and nothing is encoded
            case _:
                assert_never(command)

    def _begin(self, now: float) -> None:
        """Apply the commands whose moment has come."""
        while self._coming and self._coming[0][0] <= now:
            moment, command = self._coming.popleft()
            if isinstance(command, React):
                self._animator.react(moment, command.id, command.reaction)
            else:
                self._animator.stop(moment, command.id)
                self._stay_unless_expressive(now)

    def _stay_unless_expressive(self, now: float) -> None:
        """After an interruption, turn to the viewer only for speech or a reaction that goes on."""
        if not self._animator.is_expressive(now):
            self._life.stay()

    def _report(self) -> None:
        if self._skips.pictures or self._skips.blocks:
            skips = self._skips
            text = f"late: {skips.pictures} pictures and {skips.blocks} blocks of sound left out in {_REPORT:.0f} s"
            self._link.send_event(Log(text))
            self._skips = _Skips()


class _Ticks:
    """Periodic deadlines; missed ones are skipped."""

    def __init__(self, start: float, period: float) -> None:
        self._start, self._period, self._number = start, period, 0

    @property
    def due(self) -> float:
        """The next deadline."""
        return self._start + self._number * self._period

    def next_tick(self) -> float:
        """Return the next deadline, and go on to the one after it."""
        due = self.due
        self._number += 1
        return due

    def catch_up(self, now: float) -> int:
        """Go on to the newest deadline that is not after `now`; return how many were skipped."""
        newest = int((now - self._start) / self._period)
        left_out = max(0, newest - self._number)
        self._number += left_out
        return left_out


def i420(pixels: Pixels) -> Pixels:
    """Convert BGRA to the planes Y, U, V, one below the other."""
    height, width = pixels.shape[:2]
    planes = np.empty((height * 3 // 2, width), np.uint8)
    write_i420(pixels, planes)
    return planes


def write_i420(pixels: Pixels, into: Pixels) -> None:
    """Write BGRA as the planes Y, U, V (limited range): a third of the bytes, so the cheaper thing to send."""
    height, width = pixels.shape[:2]
    cv2.cvtColor(pixels, cv2.COLOR_BGRA2YUV_I420, into.reshape(height * 3 // 2, width))
