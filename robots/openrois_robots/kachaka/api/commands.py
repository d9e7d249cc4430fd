"""Commands at the robot: started, awaited and cancelled by their ids, beside those of other programs."""

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any, Final

from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_streaming.clock import MediaClock

from openrois.adapter import ComponentFailed, OutOfResources, RoISError
from openrois.aio.tasks import TaskScope
from openrois.errors import Aborted
from openrois_robots.adapter.link import RobotLink
from openrois_robots.kachaka.api.calls import KachakaApi, RobotSilent, RobotUnreachable
from openrois_robots.kachaka.api.error_texts import ErrorTexts
from openrois_robots.kachaka.api.polling import Poll
from openrois_robots.kachaka.api.tracking import Tracking

__all__ = ["CommandFigures", "Commands"]

_log = logging.getLogger(__name__)

_CANCELLING: Final = 1.0
"""Seconds that the robot has to tell the end of a command that was cancelled."""
_JUDGING: Final = 0.2
"""Seconds between two looks at a command that should run and does not."""
_RETRY: Final = 0.2
"""Seconds after a poll that failed: whether the robot is gone the link tells."""
_DOUBT: Final = 10.0
"""Seconds within which the robot may begin what it was sent, where its answer was not seen."""
_ABANDONED: Final = 20
"""Commands that are remembered although they could not be cancelled."""


@dataclass(slots=True)
class CommandFigures:
    """Counts of commands since the adapter began.

    Attributes:
        begun: that the robot has accepted.
        cancelled: by this adapter.
        lost: whose result the robot has not told.
    """

    begun: int = 0
    cancelled: int = 0
    lost: int = 0


@dataclass(eq=False, slots=True)
class _Running:
    """A command of a component.

    Attributes:
        owner: name of the component.
        doing: what the robot does, for sentences: `go to the kitchen`.
        command: as it was sent.
        ended: how it ended.
        id: by which the robot knows it; empty until it was accepted.
        reason: why this adapter has ended it; empty: it has not.
        doubt_until: time until which it may begin, where it was sent and has no id.
    """

    owner: str
    doing: str
    command: pb2.Command
    ended: "asyncio.Future[None]" = field(default_factory=lambda: asyncio.get_running_loop().create_future())
    id: str = ""
    reason: str = ""
    doubt_until: float = 0.0

    def is_told(self, state: pb2.GetCommandStateResponse) -> bool:
        """Tell whether it is the command that the robot carries out; without an id, whether it is one like it."""
        return bool(state.command_id) and (
            self.id == state.command_id or (not self.id and self.command == state.command)
        )

    def finish(self, error: RoISError | None) -> None:
        """End it, once."""
        if not self.ended.done():
            if self.reason:
                error = Aborted(self.reason)
            if error is None:
                self.ended.set_result(None)
            else:
                self.ended.set_exception(error)
                self.ended.exception()


class Commands:
    """The commands of this adapter at one robot; `run` has to run.

    One motion at a time: a new one ends the one before it. Commands of other programs are neither cancelled nor
    replaced: `cancel_all` is never used, and `CancelCommand`, which names no command, is called only while one of ours
    runs. A command that could not be cancelled, because the robot was gone, is cancelled when it is back.

    Args:
        api: of the robot.
        link: to it.
        texts: of its errors.
        clock: the media clock.
        release: ends the control by hand, which the robot does not have beside commands.
    """

    def __init__(
        self,
        api: KachakaApi,
        link: RobotLink,
        texts: ErrorTexts,
        clock: MediaClock,
        release: Callable[[], Awaitable[None]],
    ) -> None:
        self.figures = CommandFigures()
        self._api = api
        self._link = link
        self._texts = texts
        self._clock = clock
        self._release = release
        self._states = Poll(api, "GetCommandState", clock)
        self._results = Poll(api, "GetLastCommandResult", clock)
        self._tracking = Tracking()
        self._last = pb2.GetLastCommandResultResponse()
        self._running: dict[str, _Running] = {}
        self._motion: _Running | None = None
        self._abandoned: deque[_Running] = deque(maxlen=_ABANDONED)
        self._starting = asyncio.Lock()
        self._wanted = asyncio.Event()

    async def run(self) -> None:
        """Follow what the robot tells of commands, while there is one, until cancelled."""
        async with TaskScope() as tasks:
            leave = self._link.changed.add(self._restart)
            try:
                tasks.start(self._follow(self._states, self._note_state))
                tasks.start(self._follow(self._results, self._note_result))
                await self._judge()
            finally:
                leave()

    async def perform(self, command: pb2.Command, owner: str, doing: str, *, moves: bool = True) -> None:
        """Let the robot carry out a command, and return when it says that it has.

        Args:
            command: for the robot.
            owner: name of the component, for `cancel`; it has one command at a time.
            doing: what the robot does, for sentences: `go to the kitchen`.
            moves: whether the robot moves. Another command may wait until it stands: the robot decides that.

        Raises:
            OutOfResources: the robot carries out a command of another program.
            Aborted: `cancel` or another motion ended it.
            ComponentFailed: the robot did not do it, was lost, or has not told the result; the sentence says why.
        """
        await self._link.during(self._perform(_Running(owner, doing, command), moves))

    async def cancel(self, owner: str, reason: str) -> None:
        """Cancel the command of a component; without one, or where another program's runs, nothing is cancelled."""
        running = self._running.get(owner)
        if running is not None:
            await self._end(running, reason)

    async def end_motion(self, reason: str) -> None:
        """Cancel the motion that runs, whichever component began it."""
        if self._motion is not None:
            await self._end(self._motion, reason)

    async def _perform(self, running: _Running, moves: bool) -> None:
        try:
            async with self._starting:
                if moves:
                    await self.end_motion(f"{running.owner} has begun to {running.doing}")
                    await self._require_free()
                    await self._release()
                    self._motion = running
                self._running[running.owner] = running
                await self._start(running)
            if running.reason:
                # It was ended before it had an id.
                await self._give_up(running)
                running.finish(None)
            # Not the future itself: a cancellation would end it too, and its end at the robot is waited for yet.
            await asyncio.wait((running.ended,))
            running.ended.result()
        except asyncio.CancelledError:
            await self._give_up(running)
            raise
        finally:
            if self._motion is running:
                self._motion = None
            if self._running.get(running.owner) is running:
                del self._running[running.owner]
            self._tracking.note_end(running.id)

    async def _require_free(self) -> None:
        state: pb2.GetCommandStateResponse = await self._api.call("GetCommandState")
        ours = {each.id for each in (*self._running.values(), *self._abandoned)}
        if state.command_id and state.command_id not in ours:
            kind = (state.command.WhichOneof("command") or "unknown").removesuffix("_command")
            raise OutOfResources(
                f"the robot carries out a command of another program ({kind}): wait for its end, or stop it there"
            )

    async def _start(self, running: _Running) -> None:
        request = pb2.StartCommandRequest(command=running.command, cancel_all=False, title=running.doing)
        starting = asyncio.ensure_future(self._api.call("StartCommand", request))
        try:
            await asyncio.wait((starting,))
        except asyncio.CancelledError:
            # The robot may have it already, and only with its id it can be cancelled; there is a deadline.
            await asyncio.wait((starting,))
            if starting.exception() is None:
                self._begin(running, starting.result())
            raise
        finally:
            if starting.done() and isinstance(starting.exception(), RobotSilent | RobotUnreachable):
                self._abandon(running)
        response: pb2.StartCommandResponse = starting.result()
        self._texts.require_success(response.result, running.doing)
        if not response.command_id:
            self._abandon(running)
            raise ComponentFailed(
                f"the robot has accepted to {running.doing}, and told no id of it: it is cancelled, as its end"
                " could not be noticed"
            )
        self._begin(running, response)

    def _begin(self, running: _Running, response: pb2.StartCommandResponse) -> None:
        if response.result.success and response.command_id:
            self.figures.begun += 1
            running.id = response.command_id
            self._tracking.begin(running.id, self._clock.now())
            self._wanted.set()
            # Its result may have been told before its id.
            self._apply(self._last)

    async def _end(self, running: _Running, reason: str) -> None:
        running.reason = reason
        if running.id:
            await self._give_up(running)
            running.finish(None)
        else:
            await asyncio.wait((running.ended,), timeout=_CANCELLING)

    async def _give_up(self, running: _Running) -> None:
        """Cancel a command at the robot, and wait for its end for a while; what cannot be cancelled is abandoned."""
        if running.ended.done() or not running.id:
            return
        try:
            if self._link.is_up and await self._cancel_running(running):
                await asyncio.wait((running.ended,), timeout=_CANCELLING)
                return
        except RoISError as error:
            _log.warning("%s could not be cancelled at the robot: %s", running.doing, error)
        self._abandon(running)

    async def _cancel_running(self, running: _Running) -> bool:
        """Cancel a command if it is the one that runs; tell whether it was."""
        state: pb2.GetCommandStateResponse = await self._api.call("GetCommandState")
        if state.command_id != running.id:
            return False
        response: pb2.CancelCommandResponse = await self._api.call("CancelCommand", pb2.EmptyRequest())
        self.figures.cancelled += 1
        if response.command != running.command:
            _log.warning("a command of another program has begun in this moment, and was cancelled")
        return True

    def _abandon(self, running: _Running) -> None:
        if not running.ended.done():
            running.doubt_until = self._clock.now() + (0.0 if running.id else _DOUBT)
            self._abandoned.append(running)
            self._wanted.set()

    def _restart(self) -> None:
        self._states.restart()
        self._results.restart()

    async def _follow(self, poll: Poll, handle: Callable[[Any], Awaitable[None]]) -> None:
        while True:
            await self._wanted.wait()
            try:
                await handle(await poll.next())
            except RoISError:
                poll.restart()
                await self._clock.sleep_until(self._clock.now() + _RETRY)

    async def _note_state(self, state: pb2.GetCommandStateResponse) -> None:
        self._tracking.note_current(state.command_id, self._clock.now())
        for running in tuple(self._abandoned):
            if not state.command_id and self._clock.now() >= running.doubt_until:
                self._abandoned.remove(running)
            elif running.is_told(state):
                _log.warning("the robot still does what was given up: %s; it is cancelled", running.doing)
                self._abandoned.remove(running)
                running.id = state.command_id
                try:
                    await self._cancel_running(running)
                except RoISError:
                    self._abandon(running)
                    raise

    async def _note_result(self, response: pb2.GetLastCommandResultResponse) -> None:
        self._last = response
        self._apply(response)

    def _apply(self, response: pb2.GetLastCommandResultResponse) -> None:
        for running in tuple(self._running.values()):
            if running.id and running.id == response.command_id:
                self._finish(running, response.result.success, response.result.error_code)

    def _finish(self, running: _Running, success: bool, code: int) -> None:
        self._tracking.note_end(running.id)
        failure = f"the robot did not {running.doing}: {self._texts.sentence(code)}"
        running.finish(None if success else ComponentFailed(failure))

    async def _judge(self) -> None:
        """Look after commands that should run and do not, and rest while there is none."""
        while True:
            await self._wanted.wait()
            await self._clock.sleep_until(self._clock.now() + _JUDGING)
            if (self._tracking.misses or self._abandoned) and self._link.is_up:
                try:
                    await self._look()
                except RoISError as error:
                    _log.info("commands: %s", error)
            if not self._tracking and not self._abandoned:
                self._wanted.clear()

    async def _look(self) -> None:
        """Ask for the present state, cancel what was given up, and let commands end that are lost."""
        await self._note_result(await self._api.call("GetLastCommandResult"))
        await self._note_state(await self._api.call("GetCommandState"))
        lost = self._tracking.lost(self._clock.now())
        if not lost:
            return
        history: pb2.GetHistoryListResponse = await self._api.call("GetHistoryList")
        told = {each.id: each for each in history.histories}
        for running in [each for each in self._running.values() if each.id in lost]:
            if (entry := told.get(running.id)) is not None:
                self._finish(running, entry.success, entry.error_code)
            else:
                self.figures.lost += 1
                self._tracking.note_end(running.id)
                running.finish(
                    ComponentFailed(
                        f"the robot has ended to {running.doing}, and told only the result of another command:"
                        " whether it did is not known"
                    )
                )
