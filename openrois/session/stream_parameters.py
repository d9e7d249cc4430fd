"""Streams of one application: the parameters that it has set for those to come, and notices of those that are lost.

Pure.
"""

from collections.abc import Container, Iterable, Mapping
from typing import Final

from openrois.types.codes import StreamStatus
from openrois.types.messages import Argument, Parameter, Result
from openrois.types.profiles import HRIComponentProfile
from openrois.types.streams import StreamStatusNotification
from openrois.types.values import date_time

__all__ = ["STREAM_PARAMETERS", "StreamParameters", "lost_streams"]

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

    def keep_only(self, component_refs: Container[str]) -> None:
        """Forget what was set on components that are no longer there."""
        self._set = {ref: own for ref, own in self._set.items() if ref in component_refs}


def lost_streams(streams: Mapping[str, str], there: Container[str], now: float) -> list[StreamStatusNotification]:
    """Return the announcement of the end of each stream whose component is not in the tree any more.

    Args:
        streams: the component_ref of each stream, by stream_id.
        there: the components that are there now.
        now: epoch seconds.
    """
    return [
        StreamStatusNotification(
            stream_id=stream_id,
            component_ref=component_ref,
            status=StreamStatus.STREAMING_NOT_CONNECTED,
            timestamp=date_time(now),
        )
        for stream_id, component_ref in streams.items()
        if component_ref not in there
    ]
