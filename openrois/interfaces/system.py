"""The System interface (RoIS_HRI::SystemIF): connect, disconnect, get_profile, get_error_detail."""

from collections.abc import Mapping
from typing import Any, Final

from openrois.engine.condition import parse_condition
from openrois.engine.tree import Tree
from openrois.errors import BadParameter
from openrois.interfaces.operation import shared_operation
from openrois.interfaces.selection import COMPONENT_PROPERTIES
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
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


async def _connect(app: ApplicationSession, _params: NoParams) -> ReturnResult:
    app.connected = True
    return ReturnResult()


async def _disconnect(app: ApplicationSession, _params: NoParams) -> ReturnResult:
    await app.leave()
    return ReturnResult()


async def _get_profile(app: ApplicationSession, params: ConditionParams) -> ProfileResult:
    return profile_of(app.engine.tree, params)


async def _get_error_detail(app: ApplicationSession, params: ErrorDetailParams) -> ResultsResult:
    if params.condition:
        raise BadParameter("the condition of get_error_detail must be empty")
    return ResultsResult(results=app.errors.details(params.error_id, app.engine.sees))


_METHODS: Final[Mapping[str, SharedMethod]] = {
    "rois.system.connect": shared_operation(NoParams, ReturnResult, _connect),
    "rois.system.disconnect": shared_operation(NoParams, ReturnResult, _disconnect),
    "rois.system.get_profile": shared_operation(ConditionParams, ProfileResult, _get_profile),
    "rois.system.get_error_detail": shared_operation(ErrorDetailParams, ResultsResult, _get_error_detail),
}


def methods(app: ApplicationSession) -> BoundMethods:
    """Return the interface's methods."""
    return BoundMethods((_METHODS, app))
