"""Rights of an application to streams, given beforehand: media do not pass the gateway."""

import json
from collections.abc import Iterable
from typing import Any

from openrois.auth.principal import LOCAL, Role
from openrois.errors import BadParameter, OutOfResources, Unsupported
from openrois.session.session import ApplicationSession
from openrois.session.stream_rights import StreamRight
from openrois.types.codes import ComponentFunction
from openrois.types.messages import Parameter
from openrois.types.references import engine_of

__all__ = ["consent_stated", "may_be_uplink", "require_right", "use_stated"]

_RECEIVED = "recvonly"


def may_be_uplink(parameters: Iterable[Parameter]) -> bool:
    """Tell whether a stream with these parameters could be one that the application sends.

    Another reader may parse them differently: only what every reader takes for `recvonly` is received.
    """
    return _may_be_sent(_transport_members(parameters))


def _may_be_sent(members: dict[str, Any] | None) -> bool:
    return members is None or members.get("direction", _RECEIVED) != _RECEIVED


def _transport_members(parameters: Iterable[Parameter]) -> dict[str, Any] | None:
    """Return the members of `transport_parameters`; None where two readers may understand them differently."""
    texts = [parameter.value for parameter in parameters if parameter.name == "transport_parameters"]
    if len(texts) > 1:
        return None
    try:
        members = json.loads(texts[0], object_pairs_hook=_unambiguous) if any(texts) else {}
    except (ValueError, RecursionError):
        return None
    return members if isinstance(members, dict) else None


def _unambiguous(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    members = dict(pairs)
    if len(members) < len(pairs):
        raise ValueError("a member stands twice")
    return members


def require_right(app: ApplicationSession, component_ref: str, parameters: tuple[Parameter, ...]) -> StreamRight:
    """Return by which right the application may have a stream of a component with these parameters.

    Every reader may receive what the component gives. What visitors send is for the role listener. An application
    sends by its role visitor, where it states its consent, or while it operates the engine: it holds one of the
    actuation components of the engine that are in its scope. An engine without any has no operator; there the role is
    enough. A gateway without authentication does not ask.

    Raises:
        Unsupported: no role of the application allows the stream.
        BadParameter: the application is a visitor, and states no consent.
        OutOfResources: the application has to bind an actuation component first.
    """
    read = _transport_members(parameters)
    members = read or {}
    if _may_be_sent(read):
        return _right_to_send(app, component_ref, states_consent=isinstance(members.get("consent"), list))
    if "visitor_ref" not in members or app.trusted:
        return StreamRight()
    if not app.principal.is_listener:
        raise Unsupported("only the role listener allows receiving what visitors send: use a token that has it")
    return StreamRight(role=Role.LISTENER, needs_role=True)


def _right_to_send(app: ApplicationSession, component_ref: str, *, states_consent: bool) -> StreamRight:
    if app.trusted:
        return StreamRight()
    role = Role.VISITOR if states_consent else None
    if app.principal is LOCAL:
        return StreamRight(role=role)
    if app.principal.is_visitor and states_consent:
        return StreamRight(role=role, needs_role=True)
    engine_id = engine_of(component_ref)
    may_bind = app.principal.may_call("rois.command.bind")
    exclusive = [
        ref
        for ref in app.engine.tree.refs_of(engine_id)
        if app.engine.components[ref].function is ComponentFunction.ACTUATION
    ]
    if may_bind and (not exclusive or any(app.may_operate(ref) for ref in exclusive)):
        return StreamRight(operated=bool(exclusive), role=role)
    if app.principal.is_visitor:
        raise BadParameter("a visitor states what it consents to before it sends: set consent in transport_parameters")
    if may_bind:
        raise OutOfResources(f"sending to {engine_id} needs control of it: bind one of its actuation components first")
    raise Unsupported(
        "the roles of this application only allow receiving streams: sending needs the role visitor, or operator"
    )


def use_stated(right: StreamRight, parameters: tuple[Parameter, ...]) -> str:
    """Return what a visitor has consented to, or what a listener uses a stream for, for the audit trail."""
    members = _transport_members(parameters) or {}
    if right.role is Role.VISITOR:
        return consent_stated(_texts(members.get("consent")))
    if right.role is Role.LISTENER:
        return f"of {members.get('visitor_ref')} for {' '.join(_texts(members.get('purposes')))}"
    return ""


def consent_stated(purposes: Iterable[str]) -> str:
    """Return all that a visitor consents to as text."""
    return f"consents to {' '.join(purposes) or 'nothing'}"


def _texts(member: Any) -> list[str]:
    return [str(each) for each in member] if isinstance(member, list) else []
