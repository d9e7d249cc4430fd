"""STOP by persons at work: the latch, the notifications of it, and what adapters are told of programs meanwhile."""

from collections.abc import Iterable, Mapping
from typing import Final

from openrois.aio.listeners import Listeners
from openrois.auth.principal import Principal
from openrois.auth.ranks import Ranks
from openrois.commands.stop_latch import StopLatch
from openrois.contract import LatchKeeper
from openrois.engine.engine import Engine
from openrois.errors import OutOfResources
from openrois.leases.keeper import LeaseKeeper
from openrois.leases.lease_notifications import Holder, session_of
from openrois.types.references import engine_of
from openrois.types.stops import MAX_STOP_ID, Stopped, StoppedNotification

__all__ = ["StopKeeper", "waiting_reason"]

_MAX_NAME: Final = 128
"""Characters of a person's name that an adapter says: as many as a subject has."""

_NOT_STOPPED: Final = Stopped(engine_id="", by="")


def waiting_reason(engine_id: str, by: str) -> str:
    """Return the sentence for programs that have to wait."""
    return f"{engine_id} was stopped by {by}: programs wait until a person hands it back"


class StopKeeper:
    """Keeps programs from engines that a person has stopped.

    Args:
        engine: whose engines these are.
        leases: the holders of their components.
        latch: which of them are stopped; the leases know it, too.
        ranks: tell persons from programs.

    Attributes:
        refused: how many commands of programs were refused.
        changes: called with each change; they must not block.
    """

    def __init__(self, engine: Engine, leases: LeaseKeeper, latch: StopLatch, ranks: Ranks) -> None:
        self.refused = 0
        self.changes: Listeners[StoppedNotification] = Listeners()
        self._engine = engine
        self._leases = leases
        self._latch = latch
        self._ranks = ranks
        self._attached: set[str] = set()

    def reason_to_wait(self, component_ref: str, principal: Principal) -> str:
        """Return why a principal may not command a component now; empty text where it may."""
        by = self._latch.by(engine_of(component_ref))
        return waiting_reason(engine_of(component_ref), by) if by and self._ranks.is_program(principal) else ""

    def stop(self, engine_id: str, principal: Principal, stop_id: str) -> bool:
        """Latch an engine that a principal stops; tell whether it is a person, which alone does that.

        Each STOP is told, also of a person that has stopped the engine already: its body may move again meanwhile.
        Only a copy, with the id of the STOP that holds, is not.
        """
        if not self._ranks.is_person(principal):
            return False
        self._handle_stop(engine_id, principal.subject, stop_id)
        self._tell_adapter(engine_id)
        return True

    def release(self, engine_id: str, principal: Principal, stop_id: str = "") -> str:
        """Hand an engine back to programs; return who had stopped it, empty text where it was not stopped.

        Args:
            engine_id: the engine.
            principal: the person that hands it back.
            stop_id: of the STOP that is to end; any, where it is empty.

        Raises:
            OutOfResources: a later STOP than the named one holds.
        """
        by = self._latch.by(engine_id)
        if not self._latch.may_be(engine_id, stop_id):
            raise OutOfResources(f"{engine_id} was stopped again meanwhile, by {by}: hand it back anew")
        if by:
            ended = self._latch.stop_id(engine_id)
            self._handle_release(engine_id, f"{engine_id} was handed back to programs by {principal.subject}")
            self._tell_adapter(engine_id, ended)
        return by

    def handle_notice(self, notice: StoppedNotification) -> None:
        """Note what a parent says of an engine of this tree, and tell it on."""
        if self._engine.tree.has_engine(notice.engine_id):
            self.handle_report(notice)
            self._tell_adapter(notice.engine_id, notice.stop_id)

    def handle_report(self, notice: StoppedNotification) -> None:
        """Note what an engine of this tree says of itself: further below a person has stopped it, or handed it back."""
        if notice.by:
            self._handle_stop(notice.engine_id, notice.by[:_MAX_NAME], notice.stop_id[:MAX_STOP_ID])
        elif self._latch.by(notice.engine_id) and self._latch.may_be(notice.engine_id, notice.stop_id):
            self._handle_release(notice.engine_id, notice.reason)

    def attach(self, engine_ids: Iterable[str], told: Mapping[str, Stopped] | None, instance: str) -> None:
        """Note engines that have come, and by whom they are stopped, as their adapter says.

        Args:
            engine_ids: all engines of the adapter; those that were attached before are passed over.
            told: what persons have stopped of them, by engine; None where the adapter keeps no latch.
            instance: of the adapter.
        """
        for engine_id in engine_ids:
            if engine_id in self._attached:
                continue
            if told is not None:
                self._attached.add(engine_id)
            stopped = None if told is None else told.get(engine_id, _NOT_STOPPED)
            by = None if stopped is None else stopped.by[:_MAX_NAME]
            stop_id = "" if stopped is None else stopped.stop_id[:MAX_STOP_ID]
            if self._latch.attach(engine_id, by, instance, stop_id):
                self._tell_adapter(engine_id)
            if by:
                self._tell_programs_to_wait(engine_id)

    def detach(self, engine_ids: Iterable[str], instance: str) -> None:
        """Note that engines have gone with their adapter."""
        for engine_id in engine_ids:
            self._attached.discard(engine_id)
            self._latch.detach(engine_id, instance)

    def handle_principal(self, holder: Holder) -> None:
        """Tell adapters whether a session whose principal is another one now still operates what is stopped."""
        for component_ref, epoch in self._leases.model.holding.held_by(holder).items():
            if self._latch.by(engine_of(component_ref)):
                holds = not self._ranks.is_program(holder.principal)
                self._leases.notifications.adapter(component_ref, holder, epoch, holds=holds)

    def _handle_stop(self, engine_id: str, subject: str, stop_id: str) -> None:
        if not stop_id or stop_id != self._latch.stop_id(engine_id):
            self._latch.latch(engine_id, subject, stop_id)
            self._tell_programs_to_wait(engine_id)

    def _handle_release(self, engine_id: str, reason: str) -> None:
        stop_id = self._latch.stop_id(engine_id)
        self._latch.release(engine_id)
        self._tell_programs_back(engine_id, reason, stop_id)

    def _tell_programs_to_wait(self, engine_id: str) -> None:
        by, stop_id = self._latch.by(engine_id), self._latch.stop_id(engine_id)
        for component_ref, holder, epoch in self._held_by_programs(engine_id):
            self._leases.notifications.adapter(component_ref, holder, epoch, holds=False)
        reason = waiting_reason(engine_id, by)
        self._notify(StoppedNotification(engine_id=engine_id, by=by, reason=reason, stop_id=stop_id))

    def _tell_programs_back(self, engine_id: str, reason: str, stop_id: str) -> None:
        for component_ref, holder, epoch in self._held_by_programs(engine_id):
            # Of one that is being handed over the adapter is told when that is done.
            if self._leases.is_held(component_ref, holder):
                self._leases.notifications.adapter(component_ref, holder, epoch, holds=True)
        self._notify(StoppedNotification(engine_id=engine_id, reason=reason, stop_id=stop_id))

    def _held_by_programs(self, engine_id: str) -> list[tuple[str, Holder, int]]:
        model, found = self._leases.model, []
        for component_ref in self._engine.acting_of(engine_id):
            held = model.holding.holder(component_ref)
            if held is not None and held[0] not in model.absent:
                holder = session_of(held[0])
                if self._ranks.is_program(holder.principal):
                    found.append((component_ref, holder, held[1]))
        return found

    def _notify(self, notice: StoppedNotification) -> None:
        self._leases.notifications.of_stop(notice, self._engine.acting_of(notice.engine_id))
        self.changes.notify_all(notice)

    def _tell_adapter(self, engine_id: str, ended: str = "") -> None:
        bus: object = self._engine.tree.bus_of(engine_id)
        if isinstance(bus, LatchKeeper):
            by = self._latch.by(engine_id)
            stop_id = self._latch.stop_id(engine_id) if by else ended
            bus.keep_stop(StoppedNotification(engine_id=engine_id, by=by, stop_id=stop_id))
