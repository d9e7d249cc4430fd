"""Components that meet a condition."""

from collections.abc import Callable
from typing import Any, Final

from openrois.engine.condition import Condition, parse_condition
from openrois.engine.tree import Tree
from openrois.errors import BadParameter, Unsupported
from openrois.scope.scoped_tree import ScopedTree
from openrois.types.profiles import HRIComponentProfile

__all__ = ["COMPONENT_PROPERTIES", "STREAM_STATUS", "found_by", "observed_component", "queried_component", "the_one"]

COMPONENT_PROPERTIES: Final = frozenset({"component_ref", "component_type"})
"""The properties of a component that a condition can ask for; `component_type` is the URN of authority and code."""

STREAM_STATUS: Final = "get_stream_status"
"""The query whose condition names a stream: a query has no arguments."""


def found_by(tree: Tree[Any], text: str) -> list[str]:
    """Return the refs of the components of a tree that satisfy a condition.

    Raises:
        BadParameter: it cannot be read.
    """
    return tree.search(parse_condition(text, COMPONENT_PROPERTIES))


def the_one(engine: ScopedTree, condition: Condition, declares: Callable[[HRIComponentProfile], bool]) -> str:
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


def queried_component(engine: ScopedTree, query_type: str, text: str) -> str:
    """Return the ref of the component that a query is for.

    Args:
        engine: what the application sees.
        query_type: the query.
        text: its condition.

    Raises:
        Unsupported: no component satisfies the condition and has this query.
        BadParameter: several do, or the condition cannot be read.
    """
    properties = COMPONENT_PROPERTIES | {"stream_id"} if query_type == STREAM_STATUS else COMPONENT_PROPERTIES
    condition = parse_condition(text, properties).without("stream_id")
    return the_one(engine, condition, lambda profile: profile.has_query(query_type))


def observed_component(engine: ScopedTree, event_type: str, text: str) -> str:
    """Return the ref of the component whose event a subscription is for.

    Args:
        engine: what the application sees.
        event_type: the event.
        text: the condition of the subscription.

    Raises:
        Unsupported: no component satisfies the condition and has this event.
        BadParameter: several do, or the condition cannot be read.
    """
    return the_one(engine, parse_condition(text, COMPONENT_PROPERTIES), lambda profile: profile.has_event(event_type))
