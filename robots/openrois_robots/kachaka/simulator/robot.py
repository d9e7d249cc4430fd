"""The simulated robot: its queue of commands, manual control, battery and errors. Time is an argument."""

from collections import deque
from dataclasses import dataclass, field
from itertools import count
from typing import Final

from kachaka_api.generated import kachaka_api_pb2 as pb2

from openrois.aio.listeners import Listeners
from openrois_robots.kachaka.simulator.errors import ErrorCode
from openrois_robots.kachaka.simulator.house import HOUSE, House
from openrois_robots.kachaka.simulator.motion import ANGULAR, LINEAR, Blocked, Body, Leg
from openrois_robots.kachaka.simulator.plans import Premises, plan
from openrois_robots.kachaka.simulator.topics import Topics

__all__ = ["TOPICS", "Ended", "Job", "ManualControl", "RobotSettings", "SimulatedKachaka"]

TOPICS: Final = (
    *("battery", "detection", "error", "history", "manual", "moving_shelf", "pose"),
    *("result", "shelves", "state", "still", "volume"),
)
"""What requests with cursors wait for; `still` never changes."""

_STEP: Final = 0.05
"""Most seconds of one step of the simulation."""
_MANUAL: Final = 10.0
"""Seconds without a velocity after which manual control ends by itself."""
_VELOCITY: Final = 0.5
"""Seconds for which a velocity holds."""
_POSES: Final = 0.05
"""Seconds between two poses that are told."""
_DETECTIONS: Final = 0.2
"""Seconds between two detections."""
_DRIVING, _STANDING, _CHARGING = 0.02, 0.002, 0.1
"""Per cent of the battery in a second."""
_HISTORY: Final = 20
_REMEMBERED: Final = 1000
"""Stops and sounds that are remembered."""


@dataclass(frozen=True, slots=True)
class RobotSettings:
    """What is simulated.

    Attributes:
        battery: per cent at the beginning.
        speaks_while_driving: whether a text that cancels nothing is spoken at once beside a command that runs, instead
            of after it.
        torches: whether it has lights.
    """

    battery: float = 80.0
    speaks_while_driving: bool = False
    torches: bool = True


@dataclass(slots=True)
class Job:
    """A command between acceptance and end."""

    id: str
    command: pb2.Command
    legs: deque[Leg] = field(default_factory=deque)
    has_begun: bool = False


@dataclass(frozen=True, slots=True)
class Ended:
    """A command that has ended."""

    id: str
    command: pb2.Command
    error: ErrorCode
    at: float


class ManualControl:
    """Manual control: velocities that hold for half a second, while it is enabled."""

    def __init__(self) -> None:
        self.sent = 0
        """Velocities that were taken."""
        self._until = self._holds_until = -1.0
        self._linear = self._angular = 0.0

    def is_on(self, now: float) -> bool:
        """Tell whether it is enabled."""
        return now < self._until

    def switch(self, enable: bool, now: float) -> None:
        """Switch it on or off; the robot stands."""
        self._until = now + _MANUAL if enable else -1.0
        self._holds_until = -1.0

    def has_expired(self, now: float) -> bool:
        """Tell whether it has to be switched off."""
        return self._until > 0 and not self.is_on(now)

    def set(self, linear: float, angular: float, now: float) -> bool:
        """Take a normalised velocity, from -1 to 1, and return whether it is one of standing."""
        self.sent += 1
        self._linear, self._angular = (max(-1.0, min(1.0, each)) for each in (linear, angular))
        self._until, self._holds_until = now + _MANUAL, now + _VELOCITY
        return not (self._linear or self._angular)

    def velocity(self, now: float) -> tuple[float, float]:
        """Return m/s ahead and rad/s to the left."""
        return (self._linear * LINEAR, self._angular * ANGULAR) if now < self._holds_until else (0.0, 0.0)


class SimulatedKachaka:
    """The robot; `advance` lets time pass.

    Args:
        settings: what is simulated.
        house: where.

    Attributes:
        topics: of its state, by the clock that `advance` gets.
        premises: where it is, and what it carries.
        battery: per cent.
        jobs: the command that runs, and those behind it.
        last: the command that ended last, which is all that the robot tells of.
        history: the last ones.
        errors: that it has.
        manual: control by hand.
        volume: from 0 to 10.
        stops: the times at which it was stopped by a velocity of 0, a cancellation or an emergency stop.
        stopped: called when it is stopped so.
        sounds: ids of sounds that were played.
        lights: intensities of the torches.
    """

    def __init__(self, settings: RobotSettings, house: House = HOUSE) -> None:
        self.settings = settings
        self.house = house
        self.topics = Topics(TOPICS, 0.0)
        self.premises = Premises(house, Body(house, house.locations[0].pose), self.note_change)
        self.battery = settings.battery
        self.jobs: deque[Job] = deque()
        self.last: Ended | None = None
        self.history: deque[Ended] = deque(maxlen=_HISTORY)
        self.errors: tuple[ErrorCode, ...] = ()
        self.manual = ManualControl()
        self.volume = 5
        self.stops: deque[float] = deque(maxlen=_REMEMBERED)
        self.stopped: Listeners[()] = Listeners()
        self.sounds: deque[str] = deque(maxlen=_REMEMBERED)
        self.lights = {"front": 0, "back": 0}
        self._beside: list[Job] = []
        self._now: float | None = None
        self._ids = count(1)
        self._told_pose = (self.body.pose, 0.0)
        self._detected_at = 0.0
        self._told_battery = (round(self.battery), True)

    @property
    def body(self) -> Body:
        """What moves."""
        return self.premises.body

    @property
    def now(self) -> float:
        """The time up to which it was advanced."""
        return self._now or 0.0

    def note_change(self, topic: str) -> None:
        """Note that a topic has changed."""
        self.topics.note_change(topic, self.now)

    def advance(self, now: float) -> None:
        """Let time pass up to now; the first call begins it."""
        at = now if self._now is None else self._now
        while at < now:
            seconds = min(_STEP, now - at)
            before = self.body.pose
            self._now = at = min(now, at + seconds)
            self._run_jobs(seconds)
            self._drive_by_hand(seconds)
            self._drain(seconds, self.body.pose != before)
        self._now = at
        self._tell()

    def start(self, command: pb2.Command, *, cancel_all: bool) -> tuple[ErrorCode, str]:
        """Accept a command, or tell why not; with its id."""
        if error := self._refusal(command):
            return error, ""
        job = Job(f"command-{next(self._ids)}", command)
        if cancel_all:
            self.cancel_all()
        is_speech = command.HasField("speak_command")
        if is_speech and self.settings.speaks_while_driving and self.jobs:
            self._beside.append(job)
        else:
            self.jobs.append(job)
            self.note_change("state")
        return ErrorCode.NONE, job.id

    def cancel(self) -> Job | None:
        """Cancel the command that runs, whichever it is; return it."""
        if not self.jobs:
            return None
        job = self.jobs.popleft()
        self._note_stop()
        self._end(job, ErrorCode.CANCELLED)
        self.note_change("state")
        return job

    def cancel_all(self) -> None:
        """Cancel the command that runs, those behind it, and speech beside it."""
        jobs, self.jobs = [*self.jobs, *self._beside], deque()
        self._beside = []
        for job in jobs:
            self._end(job, ErrorCode.CANCELLED)

    def stop_in_emergency(self) -> None:
        """Stand until a person releases it: `release`."""
        self.errors = (ErrorCode.EMERGENCY_STOP,)
        self.note_change("error")
        self._note_stop()
        self.cancel_all()
        self.note_change("state")
        self.set_manual(False)

    def release(self) -> None:
        """Let a person release the emergency stop."""
        self.errors = ()
        self.note_change("error")

    def set_manual(self, enable: bool) -> ErrorCode:
        """Switch manual control."""
        if enable and self.errors:
            return self.errors[0]
        if enable and self.jobs:
            return ErrorCode.COMMAND_RUNS
        self.manual.switch(enable, self.now)
        self.note_change("manual")
        return ErrorCode.NONE

    def set_velocity(self, linear: float, angular: float) -> ErrorCode:
        """Go with a normalised velocity, from -1 to 1, for half a second."""
        if not self.manual.is_on(self.now):
            return ErrorCode.MANUAL_CONTROL_OFF
        if self.manual.set(linear, angular, self.now):
            self._note_stop()
        return ErrorCode.NONE

    def set_volume(self, volume: int) -> None:
        """Set the volume, from 0 to 10."""
        self.volume = max(0, min(10, volume))
        self.note_change("volume")

    def _note_stop(self) -> None:
        self.stops.append(self.now)
        self.stopped.notify_all()

    def _refusal(self, command: pb2.Command) -> ErrorCode:
        if self.errors:
            return self.errors[0]
        if self.manual.is_on(self.now):
            return ErrorCode.MANUAL_CONTROL_ON
        if self.battery < 1 and not command.HasField("return_home_command"):
            return ErrorCode.EMPTY_BATTERY
        return ErrorCode.NONE

    def _run_jobs(self, seconds: float) -> None:
        left: float | None = seconds
        while self.jobs and left is not None:
            job = self.jobs[0]
            left = self._advance_job(job, left)
            if left is not None:
                self.jobs.popleft()
                self.note_change("state")
        self._beside = [job for job in self._beside if self._advance_job(job, seconds) is None]

    def _advance_job(self, job: Job, seconds: float) -> float | None:
        """Return the seconds that are left when a command has ended; None while it has not."""
        if not job.has_begun:
            job.has_begun = True
            legs = plan(self.premises, job.command)
            if isinstance(legs, ErrorCode):
                self._end(job, legs)
                return seconds
            job.legs.extend(legs)
        left: float | None = seconds
        try:
            while job.legs and left is not None:
                left = job.legs[0].advance(self.body, left)
                if left is not None:
                    job.legs.popleft()
        except Blocked:
            self._end(job, ErrorCode.BLOCKED)
            return seconds
        if left is not None:
            self._end(job, ErrorCode.NONE)
        return left

    def _end(self, job: Job, error: ErrorCode) -> None:
        self.last = Ended(job.id, job.command, error, self.now)
        self.history.append(self.last)
        self.note_change("result")
        self.note_change("history")

    def _drive_by_hand(self, seconds: float) -> None:
        if self.manual.has_expired(self.now):
            self.set_manual(False)
        linear, angular = self.manual.velocity(self.now)
        if linear or angular:
            try:
                self.body.move(linear * seconds, angular * seconds)
            except Blocked:
                self.manual.set(0.0, 0.0, self.now)

    def _drain(self, seconds: float, moves: bool) -> None:
        if moves:
            self.premises.is_docked = False
        rate = _CHARGING if self.premises.is_docked else -(_DRIVING if moves else _STANDING)
        self.battery = max(0.0, min(100.0, self.battery + rate * seconds))

    def _tell(self) -> None:
        """Note what has changed, as often as it is told."""
        pose, at = self._told_pose
        if self.body.pose != pose and self.now >= at + _POSES:
            self._told_pose = self.body.pose, self.now
            self.note_change("pose")
        if self.now >= self._detected_at + _DETECTIONS:
            self._detected_at = self.now
            self.note_change("detection")
        level = round(self.battery), self.premises.is_docked
        if level != self._told_battery:
            self._told_battery = level
            self.note_change("battery")
