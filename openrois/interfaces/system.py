"""The System interface (RoIS_HRI::SystemIF): connect, disconnect, get_profile, get_error_detail."""

from typing import Any

from openrois.engine.condition import parse_condition
from openrois.engine.tree import Tree
from openrois.errors import BadParameter
from openrois.interfaces.operation import operation
from openrois.interfaces.selection import COMPONENT_PROPERTIES
from openrois.jsonrpc.session import Handler
from openrois.session.session import ApplicationSession
from openrois.types.messages import (
    ConditionParams,
    ErrorDetailParams,
    NoParams,
    ProfileResult,
    ResultsResult,
    ReturnResult,
)

__all__ = ["methods", "profile_of"]


def profile_of(tree: Tree[Any], params: ConditionParams) -> ProfileResult:
    """Return the profile of a tree of engines, with the components that satisfy a condition.

    Raises:
        BadParameter: the condition cannot be read.
    """
    condition = parse_condition(params.condition, COMPONENT_PROPERTIES)
    if not condition.comparisons:
        whole = tree.directory
        return ProfileResult(profile=whole.profile, component_profiles=dict(whole.component_profiles))
    kept = tree.search(condition)
    return ProfileResult(profile=tree.restricted(kept), component_profiles={ref: tree.components[ref] for ref in kept})


def methods(app: ApplicationSession) -> dict[str, Handler]:
    """Return the interface's method table."""

    async def connect(_params: NoParams) -> ReturnResult:
        app.connected = True
        return ReturnResult()

    async def disconnect(_params: NoParams) -> ReturnResult:
        await app.leave()
        return ReturnResult()

    async def get_profile(params: ConditionParams) -> ProfileResult:
        return profile_of(app.engine.tree, params)

    async def get_error_detail(params: ErrorDetailParams) -> ResultsResult:
        if params.condition:
            raise BadParameter("the condition of get_error_detail must be empty")
        return ResultsResult(results=app.errors.details(params.error_id, app.engine.sees))

    return {
        "rois.system.connect": operation(NoParams, ReturnResult, connect),
        "rois.system.disconnect": operation(NoParams, ReturnResult, disconnect),
        "rois.system.get_profile": operation(ConditionParams, ProfileResult, get_profile),
        "rois.system.get_error_detail": operation(ErrorDetailParams, ResultsResult, get_error_detail),
    }
