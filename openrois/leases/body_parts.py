"""The parts of the bodies in an engine's tree: components of one engine whose profiles name the same part."""

from collections.abc import Collection

from openrois.engine.engine import Engine
from openrois.leases.lease_notifications import session_of
from openrois.leases.parts import PART_MARK
from openrois.types.references import engine_of

__all__ = ["BodyParts"]


class BodyParts:
    """Which components belong together, as their profiles say it now.

    Args:
        engine: whose components they are.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def part_of(self, component_ref: str) -> str:
        """Return `<engine_id>//<part>` for a component of a part, and the reference itself for any other."""
        profile = self._engine.components.get(component_ref)
        if profile is None or not profile.part:
            return component_ref
        return f"{engine_of(component_ref)}{PART_MARK}{profile.part}"

    def members(self, part: str, holder: object) -> Collection[str]:
        """Return the components of a part that are in the scope of a session."""
        engine_id, mark, _ = part.partition(PART_MARK)
        refs = self._engine.acting_of(engine_id) if mark else [part]
        sees = session_of(holder).principal.sees
        return [ref for ref in refs if self.part_of(ref) == part and ref in self._engine.components and sees(ref)]
