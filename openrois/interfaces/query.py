"""The Query interface (RoIS_HRI::QueryIF)."""

from collections.abc import Mapping
from typing import Final

from openrois.engine.condition import parse_condition
from openrois.errors import BadParameter
from openrois.interfaces import stream
from openrois.interfaces.operation import shared_operation
from openrois.interfaces.selection import COMPONENT_PROPERTIES, STREAM_STATUS, queried_component
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.session.session import ApplicationSession
from openrois.types.codes import ComponentStatus
from openrois.types.messages import QueryParams, Result, ResultsResult

__all__ = ["FAILING", "STATUS_QUERY", "methods"]

STATUS_QUERY: Final = "component_status"
FAILING: Final = Result(name="status", data_type_ref="Component_Status", value=ComponentStatus.ERROR.value)
"""The status of a component whose engine was lost: it cannot answer itself."""


async def _query(app: ApplicationSession, params: QueryParams) -> ResultsResult:
    name = params.query_type
    if name == STREAM_STATUS:
        return ResultsResult(results=await _stream_status(app, params.condition))
    if name == STATUS_QUERY:
        condition = parse_condition(params.condition, COMPONENT_PROPERTIES)
        if app.engine.has_lost(condition.value_of("component_ref")):
            return ResultsResult(results=(FAILING,))
    component_ref = queried_component(app.engine, name, params.condition)
    return ResultsResult(results=await app.engine.query(component_ref, name))


_METHODS: Final[Mapping[str, SharedMethod]] = {"rois.query.query": shared_operation(QueryParams, ResultsResult, _query)}


def methods(app: ApplicationSession) -> BoundMethods:
    """Return the interface's methods."""
    return BoundMethods((_METHODS, app))


async def _stream_status(app: ApplicationSession, text: str) -> tuple[Result, ...]:
    """Answer get_stream_status; a query has no arguments, so the stream_id stands in the condition."""
    stream_id = parse_condition(text, COMPONENT_PROPERTIES | {"stream_id"}).value_of("stream_id")
    component_ref = queried_component(app.engine, STREAM_STATUS, text)
    if not stream.has_streams(app, component_ref):
        if stream_id is not None:
            raise BadParameter("the component's engine cannot tell one stream from another")
        return await app.engine.query(component_ref, STREAM_STATUS)
    if stream_id is None:
        raise BadParameter("the condition has to name the stream: ... AND stream_id = '...'")
    status = await stream.query_status(app, stream_id, component_ref)
    return (Result(name="status", data_type_ref="Stream_Status", value=status.value),)
