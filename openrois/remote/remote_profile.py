"""The profile of a remote engine, and whether its results fit it."""

import logging
from collections.abc import Mapping
from typing import Final, Literal

from openrois.contract import Directory
from openrois.errors import ComponentFailed
from openrois.observability.logs import Tally
from openrois.types.messages import Result
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    ParameterProfile,
    QueryMessageProfile,
)
from openrois.types.references import engine_of
from openrois.types.values import check_value

__all__ = ["Kind", "RemoteProfile", "first_misfit", "promise_of"]

Kind = Literal["command", "query", "event", "parameters"]

_log = logging.getLogger(__name__)

_MILLISECOND: Final = 0.001
_LONGEST: Final = 10**10
"""Milliseconds that a command may take by its profile; higher values count as none."""


class RemoteProfile:
    """The latest profile of a remote engine. Ids of other engines are refused; results that do not fit are counted."""

    def __init__(self) -> None:
        self._directory: Directory | None = None
        self._engine_ids: frozenset[str] = frozenset()
        self._promises: dict[tuple[str, Kind, str], Mapping[str, str]] = {}
        self._misfits = Tally(_log, "results that do not fit their component's profile")

    @property
    def directory(self) -> Directory | None:
        """The engine's directory; None before it was read."""
        return self._directory

    @directory.setter
    def directory(self, directory: Directory) -> None:
        self._directory = directory
        self._engine_ids = frozenset(directory.profile.engine_ids())
        self._promises.clear()

    def is_own(self, reference: str) -> bool:
        """Tell whether a reference or id is led by the engine or one below it."""
        return engine_of(reference) in self._engine_ids

    def require_own(self, minted: str) -> None:
        """Raise `ComponentFailed` where the engine minted an id that is led by another."""
        if not self.is_own(minted):
            raise ComponentFailed(f"the engine minted the id {minted[:200]!r}, which does not begin with its own")

    def profile(self, component_ref: str) -> HRIComponentProfile | None:
        """Return the profile of a component, or None where it has none."""
        return self.directory.component_profiles.get(component_ref) if self.directory is not None else None

    def seconds_for(self, component_ref: str, command_type: str) -> float | None:
        """Return how long a command may take by its profile, or None where that has no time."""
        profile = self.profile(component_ref)
        command = profile.command(command_type) if profile is not None else None
        if command is None or command.timeout is None:
            return None
        return min(max(command.timeout, 0), _LONGEST) * _MILLISECOND

    def note(self, component_ref: str, kind: Kind, message: str, results: tuple[Result, ...]) -> None:
        """Count results of a message that are not what the component's profile promised."""
        if (promise := self._promise(component_ref, kind, message)) is None:
            return
        if (misfit := first_misfit(promise, results)) is not None:
            self._misfits.note(f"{component_ref} {message}: {misfit}")

    def _promise(self, component_ref: str, kind: Kind, message: str) -> Mapping[str, str] | None:
        """Return the results of a message and their types; what the profile does not name is not kept."""
        promise = self._promises.get((component_ref, kind, message))
        if promise is None and (profile := self.profile(component_ref)) is not None:
            promise = promise_of(profile, kind, message)
            if promise:
                self._promises[component_ref, kind, message] = promise
        return promise


def first_misfit(types: Mapping[str, str], results: tuple[Result, ...]) -> str | None:
    """Return what is wrong with the first result that does not fit its type, or None; one may be missing."""
    for result in results:
        if result.name not in types:
            return f"a result {result.name[:80]!r} that the profile does not name"
        try:
            check_value(types[result.name], result.value)
        except ValueError as error:
            return f"{result.name[:80]}: {error}"
    return None


def promise_of(profile: HRIComponentProfile, kind: Kind, message: str) -> dict[str, str]:
    """Return the results of a message and their types; none where the profile does not name the message."""
    return {each.name: each.data_type_ref.code for each in _promised(profile, kind, message)}


def _promised(profile: HRIComponentProfile, kind: Kind, message: str) -> tuple[ParameterProfile, ...]:
    entries: tuple[CommandMessageProfile | QueryMessageProfile | EventMessageProfile, ...]
    match kind:
        case "parameters":
            return profile.parameter_profiles
        case "command":
            entries = profile.command_profiles
        case "query":
            entries = profile.query_profiles
        case "event":
            entries = profile.event_profiles
    for entry in entries:
        if entry.name == message:
            return entry.results
    return ()
