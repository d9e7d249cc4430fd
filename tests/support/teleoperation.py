"""Controls without a figure, and input messages for them."""

import itertools
import json
from collections.abc import Mapping
from typing import Any

from openrois_body.teleoperation.steering import Velocity
from openrois_streaming.input.messages import Held, Key, Message, Release, State

from openrois.errors import ComponentFailed
from tests.support.streaming import VirtualClock

W = Held(frozenset({"KeyW"}))


class LoggedControls:
    """Notes what is done, and when."""

    def __init__(self, clock: VirtualClock) -> None:
        self.done: list[tuple[float, str, object]] = []
        self.passed: list[Mapping[str, Any]] = []
        self.failure = ""
        """Why the game engine does nothing, if it does not."""
        self._clock = clock

    def drive(self, velocity: Velocity) -> None:
        self._do("drive", velocity)

    def halt(self, reason: str) -> None:
        self.done.append((self._clock.now(), "halt", reason))

    def turn_eyes(self, x: float, y: float) -> None:
        self._do("look", (x, y))

    def pass_on(self, message: Mapping[str, Any]) -> None:
        self.passed.append(message)

    def _do(self, what: str, how: object) -> None:
        if self.failure:
            raise ComponentFailed(self.failure)
        self.done.append((self._clock.now(), what, how))

    @property
    def words(self) -> list[str]:
        """What was done, without how."""
        return [what for _, what, _ in self.done]


class Hand:
    """Makes messages, each with the next number."""

    def __init__(self) -> None:
        self._numbers = itertools.count(1)

    def state(self, held: Held = W) -> State:
        return State(next(self._numbers), 0.0, held)

    def key(self, code: str = "KeyW", *, down: bool = True) -> Key:
        return Key(next(self._numbers), 0.0, code, down)

    def release(self, why: Any = "hidden") -> Release:
        return Release(next(self._numbers), 0.0, why)


def text(message: Message) -> str:
    return json.dumps(message.to_json())
