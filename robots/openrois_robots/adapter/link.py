"""The link to a robot: judged by signs of life, and the end of what waits for a robot that is gone."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine, Iterable
from typing import Any, Final, TypeVar

from openrois_streaming.clock import MediaClock

from openrois.adapter import ComponentFailed, ComponentStatus
from openrois.aio.listeners import Listeners
from openrois.component.component import Component
from openrois.errors import RoISError
from openrois.types.codes import ErrorType

__all__ = ["PATIENCE", "PERIOD", "Linked", "RobotLink", "RobotNotReady", "report_losses"]

_log = logging.getLogger(__name__)

PERIOD: Final = 0.5
"""Seconds between two questions for a sign of life."""

PATIENCE: Final = 1.0
"""Seconds that a robot has for one: with `PERIOD` what waits for a robot that hangs ends within 1.5 s."""

_T = TypeVar("_T")


class RobotNotReady(ComponentFailed):
    """The robot answers, and cannot work; the text continues the sentence `the robot at ...`."""


class RobotLink:
    """The link to one robot.

    A robot is asked for a sign of life all the time: a connection may stand while the robot behind it hangs, or sleeps.

    Args:
        robot: what is linked, for sentences: `the robot at 192.0.2.7:26400`.
        probe: asks for a sign of life; `ComponentFailed` or `OSError` says why there is none, `RobotNotReady` why the
            robot cannot work although it answers.
        clock: the media clock.

    Attributes:
        changed: called when the robot is linked or lost.
    """

    def __init__(self, robot: str, probe: Callable[[], Awaitable[None]], clock: MediaClock) -> None:
        self.robot = robot
        self.changed: Listeners[()] = Listeners()
        self._probe = probe
        self._clock = clock
        self._status = ComponentStatus.UNINITIALIZED
        self._problem = f"{robot} has not answered yet"
        self._waiting: set[asyncio.Future[None]] = set()

    @property
    def is_up(self) -> bool:
        """Whether the robot has given its last sign of life."""
        return self._status is ComponentStatus.READY

    @property
    def status(self) -> ComponentStatus:
        """READY; UNINITIALIZED until the robot is linked for the first time; ERROR while it is lost."""
        return self._status

    @property
    def problem(self) -> str:
        """Why the robot is not linked; empty while it is."""
        return self._problem

    async def run(self) -> None:
        """Ask for signs of life until cancelled."""
        while True:
            begun = self._clock.now()
            self._judge(await self._ask())
            await self._clock.sleep_until(begun + PERIOD)

    async def during(self, work: Coroutine[Any, Any, _T]) -> _T:
        """Return the result of `work`, which is cancelled when the robot is lost.

        Raises:
            ComponentFailed: the robot is not linked, or was lost meanwhile; the sentence says why.
        """
        if not self.is_up:
            work.close()
            raise ComponentFailed(self._problem)
        lost: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.add(lost)
        working = asyncio.ensure_future(work)
        try:
            await asyncio.wait((working, lost), return_when=asyncio.FIRST_COMPLETED)
            if working.done():
                return await working
            raise ComponentFailed(self._problem)
        finally:
            self._waiting.discard(lost)
            working.cancel()
            await asyncio.wait((working,))
            # What ends so is told to nothing that waits: the loop would complain of an error that was not seen.
            working.cancelled() or working.exception()

    async def _ask(self) -> str:
        """Return why there is no sign of life; empty where there is one."""
        asked = asyncio.ensure_future(self._probe())
        late = asyncio.ensure_future(self._clock.sleep_until(self._clock.now() + PATIENCE))
        try:
            await asyncio.wait((asked, late), return_when=asyncio.FIRST_COMPLETED)
            if not asked.done():
                return f"{self.robot} has not answered for {PATIENCE:g} s"
            await asked
        except RobotNotReady as error:
            return f"{self.robot} {error}"
        except (RoISError, OSError) as error:
            return f"{self.robot} cannot be reached: {error}"
        except Exception as error:  # What robots tell may be anything, and the link has to outlive it.
            problem = f"{self.robot} tells what this adapter does not understand: {type(error).__name__}: {error}"
            if problem != self._problem:
                _log.exception("the answers of %s", self.robot)
            return problem
        finally:
            asked.cancel()
            late.cancel()
            await asyncio.wait((asked, late))
        return ""

    def _judge(self, problem: str) -> None:
        was_up, before = self.is_up, self._problem
        self._problem = problem
        if not problem:
            self._status = ComponentStatus.READY
        elif was_up:
            self._status = ComponentStatus.ERROR
        if problem != before:
            _log.log(logging.WARNING if problem else logging.INFO, "%s", problem or f"{self.robot} is linked")
        if was_up is self.is_up:
            return
        for lost in () if self.is_up else tuple(self._waiting):
            if not lost.done():
                lost.set_result(None)
        self.changed.notify_all()


class Linked:
    """Mixin of a component that needs its robot; it stands before the standard's base class.

    Args:
        link: to the robot.
    """

    def __init__(self, link: RobotLink) -> None:
        super().__init__()
        self.link = link

    def condition(self) -> ComponentStatus:
        """Return the status of the link."""
        return self.link.status

    def problem(self) -> str:
        """Return why the robot is not linked."""
        return self.link.problem


def report_losses(link: RobotLink, components: Iterable[Component]) -> None:
    """Report to the applications that have bound a component when the robot is lost."""
    chosen = tuple(components)

    def note() -> None:
        if not link.is_up:
            for component in chosen:
                component.report(ErrorType.COMPONENT_NOT_RESPONDING, link.problem)

    link.changed.add(note)
