"""By which right an application has a stream that not every reader may have, and with what it loses that. Pure."""

from collections.abc import Collection
from dataclasses import dataclass

from openrois.auth.principal import Principal, Role
from openrois.types.references import engine_of

__all__ = ["StreamRight", "StreamRights"]


@dataclass(frozen=True, slots=True)
class StreamRight:
    """Right of an application to one stream.

    Attributes:
        operated: it may have the stream only as long as it operates the engine.
        role: the application takes part as one of this role, of which the engine is told; None for neither.
        needs_role: it may have the stream only as long as it has that role.
    """

    operated: bool = False
    role: Role | None = None
    needs_role: bool = False


class StreamRights:
    """The streams of one application that it has by a right of its own."""

    def __init__(self) -> None:
        self._rights: dict[str, tuple[str, StreamRight]] = {}
        """The component_ref and the right, by stream_id."""

    def note_stream(self, stream_id: str, component_ref: str, right: StreamRight) -> None:
        """Note by which right the application has a stream."""
        if right != StreamRight():
            self._rights[stream_id] = component_ref, right

    def forget_stream(self, stream_id: str) -> StreamRight:
        """Forget a stream that has ended, and return by which right it was had; an unknown one is ignored."""
        _, right = self._rights.pop(stream_id, ("", StreamRight()))
        return right

    def lost_with(self, component_ref: str, held: Collection[str]) -> list[str]:
        """Return the ids of the streams that are lost with the lease of a component: no other of its engine is held.

        Args:
            component_ref: the component.
            held: the components that are held still.
        """
        engine_id = engine_of(component_ref)
        if any(engine_of(ref) == engine_id for ref in held):
            return []
        return [
            stream_id
            for stream_id, (ref, right) in self._rights.items()
            if right.operated and engine_of(ref) == engine_id
        ]

    def lost_without(self, principal: Principal) -> list[str]:
        """Return the ids of the streams that an application of this principal has no right to."""
        return [
            stream_id
            for stream_id, (_, right) in self._rights.items()
            if right.needs_role and right.role not in principal.roles
        ]
