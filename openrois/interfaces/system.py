"""The System interface (RoIS_HRI::SystemIF): connect, disconnect, get_profile, get_error_detail."""

from openrois.engine.condition import parse_condition
from openrois.errors import BadParameter
from openrois.interfaces.operation import operation
from openrois.interfaces.selection import COMPONENT_PROPERTIES, matching
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
from openrois.types.profiles import HRIEngineProfile

__all__ = ["methods"]


def methods(app: ApplicationSession) -> dict[str, Handler]:
    """Return the interface's method table."""

    async def connect(_params: NoParams) -> ReturnResult:
        app.connected = True
        return ReturnResult()

    async def disconnect(_params: NoParams) -> ReturnResult:
        await app.leave()
        return ReturnResult()

    async def get_profile(params: ConditionParams) -> ProfileResult:
        condition = parse_condition(params.condition, COMPONENT_PROPERTIES)
        kept = set(matching(app.engine, condition))
        directory = app.engine.directory
        return ProfileResult(
            profile=_restrict(directory.profile, kept) if condition.comparisons else directory.profile,
            component_profiles={ref: profile for ref, profile in directory.component_profiles.items() if ref in kept},
        )

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


def _restrict(profile: HRIEngineProfile, kept: set[str]) -> HRIEngineProfile:
    """Return the tree of engines with only the components in `kept`; sub-engines without any are left out."""
    below = (_restrict(sub_profile, kept) for sub_profile in profile.sub_profiles)
    return HRIEngineProfile(
        identifier=profile.identifier,
        sub_profiles=tuple(sub_profile for sub_profile in below if sub_profile.component_ids),
        component_ids=tuple(ref for ref in profile.component_ids if ref in kept),
        parameter_profiles=profile.parameter_profiles,
    )
