"""What the adapter knows of its robot: its daemon's state, its motors, its sound, and the posture it tells."""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

from openrois_streaming.clock import MediaClock

from openrois.adapter import ComponentStatus
from openrois_robots.adapter.link import RobotLink, RobotNotReady
from openrois_robots.reachy.daemon.rest import Daemon
from openrois_robots.reachy.daemon.socket import SILENCE, DaemonSocket
from openrois_robots.reachy.postures.posture import Posture

__all__ = ["ENABLED", "Reachy", "Seen", "Told"]

ENABLED: Final = "enabled"
_DISABLED: Final = "disabled"
"""Modes of the motors."""
_RUNNING: Final = "running"
_FIRST: Final = 0.5
"""Seconds that a sign of life waits for the first posture."""


@dataclass(frozen=True, slots=True)
class Told:
    """What the daemon tells of itself.

    Attributes:
        name: of the robot.
        version: of the daemon.
        motors: their mode: `enabled`, `disabled` or `gravity_compensation`.
        sound_problem: why nothing that it plays is heard; empty: it is.
    """

    name: str = ""
    version: str = ""
    motors: str = ""
    sound_problem: str = "its daemon has not told whether it has sound"


@dataclass(frozen=True, slots=True)
class Seen:
    """A posture that the robot has told.

    Attributes:
        posture: of the robot.
        at: time of the media clock when it came: the daemon tells none.
    """

    posture: Posture
    at: float


class Reachy:
    """The state of one robot; its link and its socket have to run.

    Args:
        daemon: of the robot.
        clock: the media clock.

    Attributes:
        link: to the robot.
        socket: to its daemon.
        told: by the daemon, with its last sign of life.
        posture_told: set with each posture that the robot tells.
    """

    def __init__(self, daemon: Daemon, clock: MediaClock) -> None:
        self.link = RobotLink(f"the Reachy Mini at {daemon.address.text}", self._probe, clock)
        self.daemon = daemon
        self.socket = DaemonSocket(daemon, clock, self._handle)
        self.told = Told()
        self._clock = clock
        self._body_and_antennas: tuple[float, list[float]] | None = None
        self._seen: Seen | None = None
        self.posture_told = asyncio.Event()
        self.link.changed.add(self._on_link_changed)

    @property
    def seen(self) -> Seen | None:
        """The posture that the robot has told last; None while it is lost."""
        return self._seen if self.link.is_up else None

    def motion_status(self) -> ComponentStatus:
        """Return the status of what moves the robot: ERROR also while its motors are off."""
        if not self.link.is_up:
            return self.link.status
        return ComponentStatus.ERROR if self.motor_problem() else ComponentStatus.READY

    def motion_problem(self) -> str:
        """Return why the robot does not move; empty while it does."""
        return self.link.problem or self.motor_problem()

    def motor_problem(self) -> str:
        """Return why its motors do not obey; empty while they do."""
        if self.told.motors == ENABLED:
            return ""
        if self.told.motors == _DISABLED:
            return "the robot's motors are off, as while it sleeps: the reaction wake_up switches them on"
        return f"the robot's motors are in the mode {self.told.motors!r}, in which they take no targets"

    async def refresh(self) -> None:
        """Ask the daemon for its state.

        Raises:
            RobotNotReady: it does not run.
            ComponentFailed: it does not answer.
        """
        status, media = await asyncio.gather(
            self.daemon.get_object("/api/daemon/status"), self.daemon.get_object("/api/media/status")
        )
        self.told = _read(status, media)
        if problem := _not_running(status):
            raise RobotNotReady(problem)

    async def _probe(self) -> None:
        """Ask for a sign of life; raises as `refresh`, and `RobotNotReady` where the robot tells no postures."""
        await self.refresh()
        if self._seen is None:
            # The socket is connected at the same time.
            with suppress(TimeoutError):
                async with asyncio.timeout(_FIRST):
                    await self.posture_told.wait()
        if self._seen is None or self._clock.now() - self._seen.at > SILENCE:
            raise RobotNotReady("runs, and tells no postures")

    def _handle(self, message: Mapping[str, Any]) -> None:
        """Note what the socket tells."""
        kind = message.get("type")
        if kind == "joint_positions":
            self._body_and_antennas = message["head_joint_positions"][0], message["antennas_joint_positions"]
        elif kind == "head_pose" and self._body_and_antennas is not None:
            posture = Posture.from_matrix(message["head_pose"], *self._body_and_antennas)
            self._seen = Seen(posture, self._clock.now())
            self.posture_told.set()

    def _on_link_changed(self) -> None:
        if not self.link.is_up:
            self._seen = None
            self.posture_told.clear()


def _read(status: Mapping[str, Any], media: Mapping[str, Any]) -> Told:
    backend = _backend(status)
    return Told(
        str(status.get("robot_name") or ""),
        str(status.get("version") or ""),
        str(backend.get("motor_control_mode") or ""),
        _sound_problem(media),
    )


def _backend(status: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return what the daemon tells of the robot behind it; empty while there is none."""
    backend = status.get("backend_status")
    return backend if isinstance(backend, dict) else {}


def _not_running(status: Mapping[str, Any]) -> str:
    """Return why the robot does not run, as the daemon says: it continues `the Reachy Mini at ...`."""
    state, backend = status.get("state"), _backend(status)
    error = backend.get("error") or status.get("error")
    reason = f": {error}" if error else ""
    if state != _RUNNING:
        return f"does not run: its daemon is in the state {str(state)!r}{reason}"
    if error:
        return f"does not work{reason}"
    return "is not ready yet" if backend.get("ready") is False else ""


def _sound_problem(media: Mapping[str, Any]) -> str:
    """Return why nothing is heard. The daemon answers `play_sound` with success all the same."""
    if media.get("no_media"):
        return "the robot's daemon runs without media (--no-media): nothing that it plays is heard"
    if media.get("released"):
        return "another program has the robot's loudspeaker (its media are released)"
    return "" if media.get("available") else "the robot's daemon has no media server: nothing that it plays is heard"
