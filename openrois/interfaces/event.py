"""The Event interface (RoIS_HRI::EventIF): subscribe, unsubscribe, get_event_detail."""

from openrois.errors import BadParameter
from openrois.interfaces import stream
from openrois.interfaces.operation import operation
from openrois.interfaces.selection import observed_component
from openrois.jsonrpc.session import Handler, Reply
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


def methods(app: ApplicationSession) -> dict[str, Handler]:
    """Return the interface's method table."""

    async def subscribe(params: SubscribeParams) -> Reply:
        component_ref = observed_component(app.engine, params.event_type, params.condition)
        of_streams = stream.has_streams(app, component_ref)
        return await app.events.subscribe(component_ref, params.event_type, of_streams=of_streams)

    async def unsubscribe(params: UnsubscribeParams) -> ReturnResult:
        await app.events.unsubscribe(params.subscribe_id)
        return ReturnResult()

    async def get_event_detail(params: DetailParams) -> ResultsResult:
        if params.condition:
            raise BadParameter("the condition of get_event_detail must be empty")
        return ResultsResult(results=app.events.details(params.event_id, app.engine.sees))

    return {
        "rois.event.subscribe": operation(SubscribeParams, SubscribeResult, subscribe),
        "rois.event.unsubscribe": operation(UnsubscribeParams, ReturnResult, unsubscribe),
        "rois.event.get_event_detail": operation(DetailParams, ResultsResult, get_event_detail),
    }
