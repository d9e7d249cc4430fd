"""What one application wants of the streams it will connect: kept apart from what others want of the same component."""

from collections.abc import Collection, Iterable
from typing import Final

from openrois.types.messages import Argument, Parameter, Result
from openrois.types.profiles import HRIComponentProfile

__all__ = ["STREAM_PARAMETERS", "StreamParameters"]

STREAM_PARAMETERS: Final = ("encoding_parameters", "transport_parameters")
"""The parameters of a streaming component that are about a stream to come."""


class StreamParameters:
    """The stream parameters that one application has set, by component."""

    def __init__(self) -> None:
        self._set: dict[str, dict[str, Parameter]] = {}

    def keep(self, component_ref: str, profile: HRIComponentProfile, arguments: Iterable[Argument]) -> None:
        """Keep what the application has set, with the types of the profile."""
        own = self._set.setdefault(component_ref, {})
        for argument in arguments:
            promised = profile.parameter(argument.name)
            data_type_ref = argument.data_type_ref if promised is None else promised.data_type_ref.code
            own[argument.name] = Parameter(name=argument.name, data_type_ref=data_type_ref, value=argument.value)

    def over(self, component_ref: str, stored: Iterable[Result]) -> tuple[Parameter, ...]:
        """Return a component's parameters as the application sees them: its own instead of those that are `stored`."""
        seen = {p.name: Parameter(name=p.name, data_type_ref=p.data_type_ref, value=p.value) for p in stored}
        seen |= self._set.get(component_ref, {})
        return tuple(parameter for parameter in seen.values() if parameter.value)

    def keep_only(self, component_refs: Collection[str]) -> None:
        """Forget what was set on components that are no longer there."""
        self._set = {ref: own for ref, own in self._set.items() if ref in component_refs}
