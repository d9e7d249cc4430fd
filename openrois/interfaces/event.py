"""The Event interface (RoIS_HRI::EventIF): subscribe, unsubscribe, get_event_detail."""

from collections.abc import Mapping
from typing import Final

from openrois.errors import BadParameter
from openrois.interfaces import stream
from openrois.interfaces.operation import shared_operation
from openrois.interfaces.selection import observed_component
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.jsonrpc.session import Reply
from openrois.session.session import ApplicationSession
from openrois.types.messages import (
    DetailParams,
    ResultsResult,
    ReturnResult,
    SubscribeParams,
    SubscribeResult,
    UnsubscribeParams,
)

__all__ = ["methods"]


async def _subscribe(app: ApplicationSession, params: SubscribeParams) -> Reply:
    component_ref = observed_component(app.engine, params.event_type, params.condition)
    of_streams = stream.has_streams(app, component_ref)
    return await app.events.subscribe(component_ref, params.event_type, of_streams=of_streams)


async def _unsubscribe(app: ApplicationSession, params: UnsubscribeParams) -> ReturnResult:
    await app.events.unsubscribe(params.subscribe_id)
    return ReturnResult()


async def _get_event_detail(app: ApplicationSession, params: DetailParams) -> ResultsResult:
    if params.condition:
        raise BadParameter("the condition of get_event_detail must be empty")
    return ResultsResult(results=app.events.details(params.event_id, app.engine.sees))


_METHODS: Final[Mapping[str, SharedMethod]] = {
    "rois.event.subscribe": shared_operation(SubscribeParams, SubscribeResult, _subscribe),
    "rois.event.unsubscribe": shared_operation(UnsubscribeParams, ReturnResult, _unsubscribe),
    "rois.event.get_event_detail": shared_operation(DetailParams, ResultsResult, _get_event_detail),
}


def methods(app: ApplicationSession) -> BoundMethods:
    """Return the interface's methods."""
    return BoundMethods((_METHODS, app))
