"""A simulated Reachy Mini and the tasks of its daemon, as they were measured on the vendor's. Pure.

Tasks that overlap fight each other, targets are ignored during a task, and a task that was stopped has finished.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from openrois_robots.reachy.postures.posture import ASLEEP, NEUTRAL, Posture

__all__ = ["GO_TO_SLEEP", "WAKE_UP", "Leg", "SimulatedReachy", "Task"]


@dataclass(frozen=True, slots=True)
class Leg:
    """A part of a task: a posture, and the seconds that the way to it takes."""

    goal: Posture
    duration: float


WAKE_UP: Final = (Leg(NEUTRAL, 1.0), Leg(Posture(roll=0.349), 0.2), Leg(NEUTRAL, 0.2))
GO_TO_SLEEP: Final = (Leg(NEUTRAL, 1.0), Leg(ASLEEP, 2.0))


@dataclass(slots=True)
class Task:
    """A task of the daemon.

    Attributes:
        id: by which it is known.
        legs: that are left.
        start: where the first of them began.
        begun: when.
        is_listed: whether the daemon lists it as a running move: those that came by REST.
        ends_asleep: whether the motors are off afterwards.
    """

    id: str
    legs: list[Leg]
    start: Posture
    begun: float
    is_listed: bool = False
    ends_asleep: bool = False

    def target(self, now: float) -> Posture:
        """Return where it wants the robot to be."""
        leg = self.legs[0]
        share = min(1.0, (now - self.begun) / leg.duration) if leg.duration > 0 else 1.0
        eased = share**3 * (10 - 15 * share + 6 * share**2)
        pairs = zip(self.start.numbers, leg.goal.numbers, strict=True)
        return Posture(*(one + (other - one) * eased for one, other in pairs))

    def advance(self, now: float) -> bool:
        """Go on to the next leg where one is over; tell whether all are."""
        while self.legs and now - self.begun >= self.legs[0].duration:
            leg = self.legs.pop(0)
            self.start, self.begun = leg.goal, self.begun + leg.duration
        return not self.legs


@dataclass(slots=True)
class SimulatedReachy:
    """A robot and its daemon.

    Attributes:
        posture: where the robot is.
        target: where it is to be.
        motors: their mode.
        state: of the daemon.
        has_media: whether a sound is heard.
        is_held: whether something holds the head: it moves nowhere.
        sound_from: angle of the sound that its microphones hear: 0 is left, half a turn right; None: it has none.
        tasks: that run.
        finished: tasks that have ended, and were not told yet.
        ignored: targets that came during a task.
        stops: times at which its own stop was called.
    """

    posture: Posture = NEUTRAL
    target: Posture | None = None
    motors: str = "enabled"
    state: str = "running"
    has_media: bool = False
    is_held: bool = False
    sound_from: float | None = None
    tasks: list[Task] = field(default_factory=list)
    finished: list[Task] = field(default_factory=list)
    ignored: int = 0
    stops: list[float] = field(default_factory=list)
    _steps: int = 0

    def begin(
        self, task_id: str, legs: Sequence[Leg], now: float, *, is_listed: bool = False, ends_asleep: bool = False
    ) -> None:
        """Begin a task where the robot is, whatever else runs."""
        self.tasks.append(Task(task_id, list(legs), self.posture, now, is_listed, ends_asleep))

    def set_target(self, target: Posture) -> None:
        """Want the robot to be somewhere at once; ignored without a word during a task."""
        if self.tasks:
            self.ignored += 1
        else:
            self.target = target

    def stop(self, now: float) -> None:
        """End all tasks; they have finished."""
        self.stops.append(now)
        self._end(self.tasks)

    def cancel(self, task_id: str) -> bool:
        """End one task, and tell whether there was one."""
        chosen = [task for task in self.tasks if task.id == task_id]
        self._end(chosen)
        return bool(chosen)

    def step(self, now: float) -> None:
        """Let one control step pass."""
        self._steps += 1
        if self.tasks:
            # Each writes its target all the time: the last one counts, and that is now this one, now another.
            self.target = self.tasks[self._steps % len(self.tasks)].target(now)
        if self.target is not None and self.motors == "enabled" and not self.is_held:
            self.posture = self.target
        over = [task for task in self.tasks if task.advance(now)]
        if any(task.ends_asleep for task in over):
            self.motors = "disabled"
        self._end(over)

    def _end(self, tasks: Sequence[Task]) -> None:
        self.finished += tasks
        self.tasks = [task for task in self.tasks if task not in tasks]
