"""The Command interface (RoIS_HRI::CommandIF): find, reserve, parametrise and run components."""

import asyncio
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from openrois.commands.history import MAX_ID, STOP_RESERVE
from openrois.commands.pending import PendingCommand
from openrois.commands.sequence import commands_of, run_sequence, size_of
from openrois.component.authoring.parameters import check_arguments
from openrois.errors import (
    Aborted,
    BadParameter,
    OutOfResources,
    RoISError,
    StoreUnreachable,
    TimedOut,
    Unsupported,
)
from openrois.interfaces import stream
from openrois.interfaces.operation import shared_operation
from openrois.interfaces.overload_rules import is_stop
from openrois.interfaces.selection import found_by
from openrois.journal.former import FormerCommand
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.jsonrpc.session import Reply
from openrois.session.session import ApplicationSession
from openrois.types.codes import CompletedStatus, ComponentFunction
from openrois.types.messages import (
    Argument,
    CommandResultParams,
    CommandUnit,
    ComponentParams,
    ConditionParams,
    ExecuteParams,
    ParametersResult,
    ReferenceResult,
    Result,
    ResultsResult,
    ReturnResult,
    SearchResult,
    SequenceItem,
    SetParameterParams,
    SetParameterResult,
)
from openrois.types.profiles import HRIComponentProfile
from openrois.types.references import engine_of, new_id
from openrois.types.streams import STREAM_METHODS

__all__ = ["methods"]

_log = logging.getLogger(__name__)

MAX_BOUND: Final = 256
"""Components that one application has bound at a time."""

_LOOKS_ELSEWHERE: Final = 20
_LOOK_AGAIN: Final = 0.25
"""Seconds between two looks whether a command that runs at another gateway has ended."""


@dataclass(slots=True)
class _Sequence:
    """Commands that were accepted together: how many have not ended, and the task that runs them."""

    left: int
    task: asyncio.Task[None] | None = None

    def leave(self) -> None:
        """Count a command that has ended; after the last one delays are cut short."""
        self.left -= 1
        if not self.left and self.task is not None:
            self.task.cancel()


class _Commands:
    """The operations of one application."""

    def __init__(self, app: ApplicationSession) -> None:
        self._app = app
        self._accepted: dict[str, PendingCommand] = {}
        self._unreplied: set[str] = set()
        self._sequences: dict[str, _Sequence] = {}

    async def search(self, params: ConditionParams) -> SearchResult:
        return SearchResult(component_ref_list=tuple(found_by(self._app.engine.tree, params.condition)))

    async def bind(self, params: ComponentParams) -> ReturnResult:
        self._bind(params.component_ref)
        return ReturnResult()

    def _bind(self, component_ref: str) -> None:
        if len(self._app.bound) >= MAX_BOUND and component_ref not in self._app.bound:
            raise OutOfResources(f"one application has at most {MAX_BOUND} components bound")
        if self._app.engine.require(component_ref).function is ComponentFunction.ACTUATION:
            self._app.host.leases.bind(component_ref, self._app)
        self._app.bound.add(component_ref)
        self._acted("rois.command.bind", component_ref)

    def _acted(self, method: str, component_ref: str, detail: str = "") -> None:
        self._app.host.audit.acted(self._app.principal, method, component_ref, detail)

    async def bind_any(self, params: ConditionParams) -> ReferenceResult:
        refs = found_by(self._app.engine.tree, params.condition)
        if not refs:
            raise Unsupported("no component satisfies the condition")
        for component_ref in refs:
            try:
                self._bind(component_ref)
            except OutOfResources:
                continue
            return ReferenceResult(component_ref=component_ref)
        raise OutOfResources("every component that satisfies the condition is bound by another application")

    async def release(self, params: ComponentParams) -> ReturnResult:
        self._app.engine.require(params.component_ref)
        self._app.give_back(params.component_ref)
        self._app.bound.discard(params.component_ref)
        self._acted("rois.command.release", params.component_ref)
        return ReturnResult()

    async def get_parameter(self, params: ComponentParams) -> ParametersResult:
        self._app.engine.require(params.component_ref)
        return ParametersResult(parameters=await stream.get_parameters(self._app, params.component_ref))

    async def set_parameter(self, params: SetParameterParams) -> Reply:
        unit = CommandUnit(
            component_ref=params.component_ref,
            command_type="set_parameter",
            command_id=new_id(engine_of(params.component_ref)),
            arguments=tuple(Argument.model_validate(p.model_dump()) for p in params.parameters),
        )
        self._check_operable(unit)
        await self._accept((unit,), (unit,))
        return Reply(
            SetParameterResult(command_id=unit.command_id),
            lambda: self._start(ExecuteParams(command_unit_list=(unit,))),
        )

    async def execute(self, params: ExecuteParams) -> Reply:
        units = commands_of(params.command_unit_list)
        if not units:
            raise BadParameter("there is no command in the sequence")
        seen: set[str] = set()
        for unit in units:
            self._check_operable(unit)
            self._check_id(unit.command_id, seen)
        await self._accept(params.command_unit_list, units)
        return Reply(ReturnResult(), lambda: self._start(params))

    async def _accept(self, items: Sequence[SequenceItem], units: Sequence[CommandUnit]) -> None:
        app = self._app
        commands = {unit.command_id: unit.component_ref for unit in units}
        beyond = STOP_RESERVE if all(is_stop(unit.command_type) for unit in units) else 0
        app.commands.accept(commands, beyond, text=size_of(items), subject=app.sharer)
        sequence = app.host.pending.next_sequence()
        self._sequences |= dict.fromkeys(commands, _Sequence(len(units)))
        for unit in units:
            starts = unit.command_type == "start"
            command = PendingCommand(unit.component_ref, app, partial(self._end_early, unit), sequence, starts)
            self._accepted[unit.command_id] = command
            app.host.pending.add(command)
        self._unreplied.update(commands)
        try:
            await app.host.journal.accepted(app.client_id, app.principal.subject, commands)
        except asyncio.CancelledError:
            # The connection ended before the reply, so that nothing was promised.
            for unit in units:
                self._unreplied.discard(unit.command_id)
                self._finish(unit, CompletedStatus.ABORT, (), "the application went before the command was accepted")
            raise

    def _end_early(self, unit: CommandUnit, reason: str) -> None:
        """End a command before its turn, but not before the reply that accepts it."""
        if unit.command_id not in self._unreplied:
            self._finish(unit, CompletedStatus.ABORT, (), reason)

    def _check_operable(self, unit: CommandUnit) -> None:
        profile = self._app.engine.require(unit.component_ref)
        if unit.command_type == "set_parameter":
            known = bool(profile.parameter_profiles)
        else:
            known = profile.command(unit.command_type) is not None
        if not known:
            raise Unsupported(f"{unit.component_ref} has no command {unit.command_type[:200]!r}")
        if profile.function is ComponentFunction.ACTUATION and not self._app.may_operate(unit.component_ref):
            raise OutOfResources(self._app.host.leases.why_not(unit.component_ref, self._app))
        if unit.command_type != "stop":
            self._app.host.require_staying()
            if reason := _reason_to_wait(self._app, unit, profile):
                self._app.host.stops.refused += 1
                raise OutOfResources(reason)
        command = profile.command(unit.command_type)
        check_arguments(profile.parameter_profiles if command is None else command.arguments, unit.arguments)

    def _check_id(self, command_id: str, seen: set[str]) -> None:
        if not command_id or command_id in seen or command_id in self._app.commands:
            raise BadParameter(f"the command_id {command_id[:200]!r} is empty or taken")
        if len(command_id) > MAX_ID:
            raise BadParameter(f"a command_id has at most {MAX_ID} characters")
        if self._app.engine.tree.has_engine(engine_of(command_id)) and not self._app.trusted:
            raise BadParameter("a command_id cannot begin with the id of an engine and a slash")
        seen.add(command_id)

    def _start(self, params: ExecuteParams) -> None:
        units = commands_of(params.command_unit_list)
        sequence = self._sequences[units[0].command_id]
        for unit in units:
            self._unreplied.discard(unit.command_id)
            if reason := self._accepted[unit.command_id].aborted:
                self._finish(unit, CompletedStatus.ABORT, (), reason)
        if sequence.left:
            running = run_sequence(params.command_unit_list, self._run, self._skip, self._app.host.sleep)
            sequence.task = self._app.host.tasks.start(running)

    async def _run(self, unit: CommandUnit) -> CompletedStatus:
        if unit.command_type not in STREAM_METHODS:
            return await self._run_to_completed(unit)
        # Of a streaming verb `completed` is the reply: what the stream's engine says comes after it.
        replied = self._app.order.asked(engine_of(unit.component_ref))
        try:
            return await self._run_to_completed(unit)
        finally:
            replied()

    async def _run_to_completed(self, unit: CommandUnit) -> CompletedStatus:
        command = self._accepted.get(unit.command_id)
        if command is None:
            # It was ended before its turn came.
            return CompletedStatus.ABORT
        command.task = asyncio.current_task()
        status = CompletedStatus.OK
        reason = ""
        results: tuple[Result, ...] = ()
        try:
            results = await self._outcome(unit)
        except asyncio.CancelledError:
            if not command.takes_back_cancellation():
                raise
            status, reason = CompletedStatus.ABORT, command.aborted
        except RoISError as error:
            status, reason = error.completed_status, str(error)
            if status is CompletedStatus.ABORT and command.stopping:
                reason = command.stopping
            _log.info("%s of %s ended %s: %s", unit.command_type, unit.component_ref, status, error)
        except Exception:
            # Whatever went wrong inside, the application is owed its one `completed`.
            status, reason = CompletedStatus.ERROR, f"{unit.command_type} failed inside the engine"
            _log.exception("%s of %s failed", unit.command_type, unit.component_ref)
            self._app.host.crashed(f"{unit.command_type} of {unit.component_ref}")
        self._finish(unit, status, results, reason)
        return status

    async def _outcome(self, unit: CommandUnit) -> tuple[Result, ...]:
        _require_still(self._app, unit)
        if unit.command_type == "stop":
            self._app.host.pending.stop(unit.component_ref, self._accepted[unit.command_id].sequence)
        self._acted("rois.command.execute", unit.component_ref, f"{unit.command_type} {unit.command_id}")
        if stream.is_verb(unit.command_type) and stream.has_streams(self._app, unit.component_ref):
            return await stream.run_verb(self._app, unit)
        return await self._app.engine.invoke(unit.component_ref, unit.command_type, unit.arguments, unit.command_id)

    def _skip(self, unit: CommandUnit, status: CompletedStatus) -> None:
        if unit.command_id in self._accepted:
            self._finish(unit, CompletedStatus.ABORT, (), f"an earlier command of the sequence ended {status}")

    def _finish(
        self, unit: CommandUnit, status: CompletedStatus, results: tuple[Result, ...], reason: str = ""
    ) -> None:
        command = self._accepted.pop(unit.command_id, None)
        if command is not None:
            self._app.host.pending.remove(command)
            if command.starts:
                self._app.host.leases.note_ended(unit.component_ref, self._app.present())
            self._sequences.pop(unit.command_id).leave()
        self._app.commands.finish(unit.command_id, results, status, reason)
        self._app.host.journal.ended(self._app.client_id, unit.command_id, status, reason, results)
        self._app.completed(unit.command_id, status, reason)

    async def get_command_result(self, params: CommandResultParams) -> ResultsResult | Reply:
        if params.condition:
            raise BadParameter("the condition of get_command_result must be empty")
        if params.command_id not in self._app.commands:
            former = await _former_command(self._app, params.command_id)
            if former is not None:
                return former
        return ResultsResult(results=self._app.commands.results(params.command_id, self._app.engine.sees))


_METHODS: Final[Mapping[str, SharedMethod]] = {
    "rois.command.search": shared_operation(ConditionParams, SearchResult, _Commands.search),
    "rois.command.bind": shared_operation(ComponentParams, ReturnResult, _Commands.bind),
    "rois.command.bind_any": shared_operation(ConditionParams, ReferenceResult, _Commands.bind_any),
    "rois.command.release": shared_operation(ComponentParams, ReturnResult, _Commands.release),
    "rois.command.get_parameter": shared_operation(ComponentParams, ParametersResult, _Commands.get_parameter),
    "rois.command.set_parameter": shared_operation(SetParameterParams, SetParameterResult, _Commands.set_parameter),
    "rois.command.execute": shared_operation(ExecuteParams, ReturnResult, _Commands.execute),
    "rois.command.get_command_result": shared_operation(
        CommandResultParams, ResultsResult, _Commands.get_command_result
    ),
}


def methods(app: ApplicationSession) -> BoundMethods:
    """Return the interface's methods."""
    return BoundMethods((_METHODS, _Commands(app)))


def _require_still(app: ApplicationSession, unit: CommandUnit) -> None:
    """Do nothing where a command may run that was accepted a while ago.

    Raises:
        Aborted: its application may have been told that it is lost, or a person has stopped the engine for programs.
        Unsupported: the application in whose place this one goes on may not run it.
        OutOfResources: another application has its component by now.
    """
    if app.is_cut():
        raise Aborted(f"the stream to the application's gateway was lost before {unit.command_type} began")
    present = app.present()
    error: type[RoISError] = Unsupported
    if not (present.principal.may_call("rois.command.execute") and present.engine.sees(unit.component_ref)):
        reason = f"the application may not run {unit.command_type} of {unit.component_ref} any more"
    elif app.is_barred_from(unit.component_ref):
        reason, error = f"{unit.component_ref} is bound by another application by now", OutOfResources
    elif waiting := _reason_to_wait(app, unit, present.engine.components.get(unit.component_ref)):
        reason, error = waiting, Aborted
    else:
        return
    app.host.audit.refused(present.principal, unit.command_type, unit.component_ref, reason)
    raise error(reason)


def _reason_to_wait(app: ApplicationSession, unit: CommandUnit, profile: HRIComponentProfile | None) -> str:
    """Return why a command may not run on an engine that a person has stopped; empty text where it may."""
    is_acting = profile is not None and profile.function is ComponentFunction.ACTUATION
    if app.trusted or not is_acting or unit.command_type == "stop":
        return ""
    return app.host.stops.reason_to_wait(unit.component_ref, app.present().principal)


async def _former_command(app: ApplicationSession, command_id: str) -> Reply | None:
    """Return the reply of `get_command_result`, or None where the journal knows no such command of this principal's.

    A notification of its end follows the reply, unless that was notified before. For the end of a command that runs at
    another gateway, and for a journal that does not answer, the application waits a while: no reply without an end
    would be followed by `completed`.

    Raises:
        TimedOut: it still runs there, or the journal did not answer.
    """
    journal, subject, clock = app.host.journal, app.principal.subject, asyncio.get_running_loop().time
    looks, why = 0.0, ""
    while looks < _LOOKS_ELSEWHERE:
        began = clock()
        try:
            former = await journal.find(subject, command_id)
            if former is None or not app.principal.sees(former.component_ref):
                return None
            if not former.is_running:
                told = await journal.deliver_outcome(subject, command_id)
                return _former_reply(app, command_id, former, is_told=told is None)
            why = "the command still runs, at another gateway"
        except StoreUnreachable as error:
            why = f"how the command ended is not known yet: {error}"
        # A store that is silent takes as long as several looks.
        looks += 1 + (clock() - began) // _LOOK_AGAIN
        await app.host.sleep(_LOOK_AGAIN)
    raise TimedOut(f"{why}: ask again")


def _former_reply(app: ApplicationSession, command_id: str, former: FormerCommand, *, is_told: bool) -> Reply:
    then = None if is_told else lambda: app.completed(command_id, former.completed_status, former.reason)
    try:
        return Reply(ResultsResult(results=former.results()), then)
    except RoISError as error:
        return Reply(ResultsResult(return_code=error.return_code), then, str(error))
