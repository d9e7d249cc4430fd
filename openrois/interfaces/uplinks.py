"""Permission of an application to send media to an engine, given beforehand: media do not pass the gateway."""

import json
from collections.abc import Iterable
from typing import Any

from openrois.auth.principal import LOCAL
from openrois.errors import OutOfResources, Unsupported
from openrois.session.session import ApplicationSession
from openrois.types.codes import ComponentFunction
from openrois.types.messages import Parameter
from openrois.types.references import engine_of

__all__ = ["may_be_uplink", "require_may_send"]

_RECEIVED = "recvonly"


def may_be_uplink(parameters: Iterable[Parameter]) -> bool:
    """Tell whether a stream with these parameters could be one that the application sends.

    Another reader may parse them differently: only what every reader takes for `recvonly` is received.
    """
    texts = [parameter.value for parameter in parameters if parameter.name == "transport_parameters"]
    return len(texts) > 1 or any(text and not _is_received(text) for text in texts)


def _is_received(text: str) -> bool:
    try:
        members = json.loads(text, object_pairs_hook=_unambiguous)
    except (ValueError, RecursionError):
        return False
    return isinstance(members, dict) and members.get("direction", _RECEIVED) == _RECEIVED


def _unambiguous(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    members = dict(pairs)
    if len(members) < len(pairs):
        raise ValueError("a member stands twice")
    return members


def require_may_send(app: ApplicationSession, component_ref: str) -> bool:
    """Return whether the application may send into a component's engine only as long as it operates that one.

    It does where it holds one of the actuation components of the engine that are in its scope. An engine without any
    has no operator; there the role is enough. A gateway without authentication does not ask.

    Raises:
        Unsupported: the role does not operate anything.
        OutOfResources: the application has to bind an actuation component first.
    """
    if app.principal is LOCAL or app.trusted:
        return False
    if not app.principal.may_call("rois.command.bind"):
        raise Unsupported("the roles of this application only allow receiving streams")
    engine_id = engine_of(component_ref)
    exclusive = [
        ref
        for ref in app.engine.tree.refs_of(engine_id)
        if app.engine.components[ref].function is ComponentFunction.ACTUATION
    ]
    if exclusive and not any(app.may_operate(ref) for ref in exclusive):
        raise OutOfResources(f"sending to {engine_id} needs control of it: bind one of its actuation components first")
    return bool(exclusive)
