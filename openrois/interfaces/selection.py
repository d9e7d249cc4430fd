"""Components that meet a condition."""

from collections.abc import Callable
from typing import Final

from openrois.engine.condition import Condition
from openrois.errors import BadParameter, Unsupported
from openrois.scope.scoped_engine import ScopedEngine
from openrois.types.profiles import HRIComponentProfile

__all__ = ["COMPONENT_PROPERTIES", "the_one"]

COMPONENT_PROPERTIES: Final = frozenset({"component_ref", "component_type"})
"""The properties of a component that a condition can ask for; `component_type` is the URN of authority and code."""


def the_one(engine: ScopedEngine, condition: Condition, declares: Callable[[HRIComponentProfile], bool]) -> str:
    """Return the ref of the only component that satisfies a condition and declares a message.

    Raises:
        Unsupported: no component does.
        BadParameter: several do; the condition has to name one.
    """
    refs = [ref for ref in engine.tree.search(condition) if declares(engine.components[ref])]
    if not refs:
        raise Unsupported("no component that satisfies the condition has this message")
    if len(refs) > 1:
        raise BadParameter(f"{len(refs)} components have this message: name one with component_ref = '...'")
    return refs[0]
