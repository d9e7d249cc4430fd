"""A game engine in a thread, made of one socket, correct except for one chosen fault."""

import select
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Final

from openrois_avatar.link.messages import (
    Bye,
    Command,
    Completed,
    Demand,
    Drive,
    Halt,
    Hello,
    Idle,
    Input,
    LinkError,
    Pause,
    Place,
    Quit,
    Reached,
    React,
    Stop,
    VideoShape,
    Walk,
    Welcome,
)
from openrois_avatar.link.protocol import Audio, Doorbell, Message, Parser, PixelFormat, Sender, Video, encode
from openrois_avatar.link.ring_writer import RingWriter

WIDTH, HEIGHT, FPS = 16, 8, 25
PIXELS: Final = bytes(WIDTH * HEIGHT * 4)
HELLO: Final = Hello("odd", "1", VideoShape(WIDTH, HEIGHT, FPS), 1, ("nod",), "", hears=True, walks=True, input=True)


class OddEngine:
    """Runs until its connection is over; `odd` names what it does wrong."""

    def __init__(self, address: str, secret: str, odd: str) -> None:
        self._address, self._secret, self._odd = address, secret, odd
        self._number = -1
        self._place = Place(0.0, 0.0, -1.57)
        self._walk: tuple[Walk, int] | None = None
        self._reaction: tuple[str, float] | None = None
        self._driven_until = 0.0
        self._ring: RingWriter | None = None
        self._sound_at = 0.0
        self._wanted = True
        self._over = False

    def run(self) -> None:
        """Connect, and run until either side ends the connection."""
        times = 2 if self._odd == "comes back" else 1
        for _ in range(times):
            with suppress(OSError, LinkError):
                self._number, self._over, self._reaction, self._walk = -1, False, None, None
                self._live()

    def _live(self) -> None:
        host, _, port = self._address.removeprefix("tcp:").partition(":")
        with socket.create_connection((host, int(port)), 5) as self._link:
            if self._odd == "says nothing":
                self._link.recv(1)
                return
            if self._odd == "speaks HTTP":
                self._link.sendall(b"GET / HTTP/1.1\r\nHost: here\r\n\r\n")
                self._link.recv(1 << 16)
                return
            self._send(self._hello())
            self._play()

    def _hello(self) -> Hello:
        secret = "wrong" if self._odd == "wrong secret" else self._secret
        hello = replace(HELLO, secret=secret, ring=self._odd.startswith("ring"))
        match self._odd:
            case "can nothing":
                return replace(hello, audio_channels=None, reactions=(), hears=False, walks=False, input=False)
            case "silent says HELLO":
                return replace(hello, audio_channels=None)
        return replace(hello, demand=self._odd.startswith("sleeps"))

    def _send(self, *messages: Message) -> None:
        self._link.sendall(b"".join(b"".join(encode(message)) for message in messages))

    def _play(self) -> None:
        parser, start = Parser(Sender.ADAPTER), time.monotonic()
        self._sound_at = start
        while not self._over:
            due = start + (self._number + 1) / FPS
            while select.select([self._link], [], [], max(0.0, due - time.monotonic()))[0]:
                data = self._link.recv(1 << 16)
                for message in parser.feed(data):
                    self._take(message)
                if not data or self._over:
                    return
            self._number += 1
            self._step(time.monotonic())

    def _take(self, message: Message) -> None:
        match message:
            case Welcome():
                self._begin(message)
            case Bye():
                self._over = self._odd != "stays"
            case Audio():
                self._over = self._odd == "dies of sound"
            case React() | Stop():
                self._react(message)
            case Walk() | Drive() | Halt():
                self._move(message)
            case Demand():
                self._heed(message)
            case Input() | Quit():
                self._over = isinstance(message, Quit) or self._odd == "dies of input"

    def _begin(self, welcome: Welcome) -> None:
        if welcome.ring is not None:
            self._ring = RingWriter(welcome.ring)
        if self._odd != "has no place":
            self._send(self._place)

    def _heed(self, demand: Demand) -> None:
        slept = not self._wanted
        self._wanted = demand.consumers > 0 or self._odd == "sleeps with open eyes"
        if slept and self._odd == "sleeps for ever":
            self._wanted = False
        if slept and self._odd == "sleeps and shows its dream":
            self._send(self._old_picture())

    def _react(self, command: Command) -> None:
        now = time.monotonic()
        if isinstance(command, Stop):
            if self._reaction is not None and self._odd != "does not stop":
                self._send(Completed(self._reaction[0], "ERROR" if self._odd == "stops with ERROR" else "ABORT"))
                self._reaction = None
        elif isinstance(command, React):
            if command.reaction == "nod":
                self._reaction = command.id, now + {"nods for ever": 100.0, "does not stop": 0.9}.get(self._odd, 0.1)
            elif self._odd == "knows everything":
                self._send(Completed(command.id, "OK"))
            elif self._odd != "ignores what it does not know":
                self._send(Completed(command.id, "ERROR"))

    def _move(self, command: Command) -> None:
        if isinstance(command, Walk):
            self._walk = command, 0
            return
        if self._walk is not None and self._odd != "does not halt":
            self._send(Completed(self._walk[0].id, "ABORT"))
            self._walk = None
        if isinstance(command, Drive):
            self._driven_until = time.monotonic() + (9.0 if self._odd == "drives for ever" else 0.2)
        else:
            self._driven_until = 0.0

    def _step(self, now: float) -> None:
        if self._reaction is not None and self._reaction[1] <= now:
            self._send(*[Completed(self._reaction[0], "OK")] * (2 if self._odd == "nods twice" else 1))
            self._reaction = None
        if self._walk is not None and self._number % 5 == 0:
            walk, index = self._walk
            point = walk.path[index]
            self._place = Place(point.x, point.y, self._place.th)
            self._send(self._place, *([] if self._odd == "does not tell" else [Reached(walk.id, index)]))
            self._walk = (walk, index + 1) if index + 1 < len(walk.path) else None
            if self._walk is None:
                self._send(Completed(walk.id, "OK"))
        if now < self._driven_until and self._odd != "does not drive":
            self._place = replace(self._place, th=self._place.th + 0.05)
            self._send(self._place)
        if self._odd == "pauses":
            self._send(*([Pause(True)] if self._number == 0 else []))
        elif self._wanted:
            self._show(now)
        elif self._number % (FPS // 2) == 0 and self._odd != "sleeps like the dead":
            self._send(Idle())
        self._sound()

    def _show(self, now: float) -> None:
        if self._odd == "loses the first" and self._number < 2:
            return
        if self._odd == "shows nothing" or (self._odd == "is slow" and self._number % 5):
            return
        moment = {
            "has no time": 0.0,
            "has the time of day": time.time(),
            "is late": now - 2.0,
            "is ahead": now + 0.2,
            "stands still": self._sound_at - self._number / FPS,
        }.get(self._odd, now)
        number = {"counts on": self._number + 1000, "does not count": 0}.get(self._odd, self._number)
        width = WIDTH // 2 if self._odd == "is small" else WIDTH
        shape = number, round(moment * 1e9), width, HEIGHT, 4 * width, PixelFormat.BGRA
        if self._ring is not None and self._odd != "ring unused":
            slot = self._ring.write(self._number, memoryview(PIXELS))
            assert slot is not None
            if self._odd == "ring with wrong locks":
                self._ring._locks[slot * self._ring._place.slot_bytes // 8] = 1
            self._send(Doorbell(*shape, slot))
        else:
            self._send(Video(*shape, PIXELS[: width * HEIGHT * 4]))

    def _old_picture(self) -> Video:
        moment = time.monotonic() - 0.8
        return Video(self._number, round(moment * 1e9), WIDTH, HEIGHT, 4 * WIDTH, PixelFormat.BGRA, PIXELS)

    def _sound(self) -> None:
        if self._odd in {"can nothing", "is mute"}:
            return
        seconds, channels = 1 / FPS, 2 if self._odd == "is stereo" else 1
        moment = self._sound_at
        self._sound_at += seconds
        moment += {"sounds late": -0.5, "sounds of the past": -5.0}.get(self._odd, 0.06)
        if self._odd == "stumbles":
            moment += 0.05 * (self._number % 2)
        number = 7 if self._odd == "counts no sound" else self._number
        self._send(Audio(number, round(moment * 1e9), channels, bytes(2 * channels * 48_000 // FPS)))


@contextmanager
def odd_engine(address: str, secret: str, odd: str) -> Iterator[None]:
    """An engine in a thread, for as long as the context lasts, or until the other side ends it."""
    thread = threading.Thread(target=OddEngine(address, secret, odd).run, daemon=True)
    thread.start()
    yield
    thread.join(10)
