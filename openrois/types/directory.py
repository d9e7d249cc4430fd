"""Params and results of `openrois.directory.*`: a directory of many engines, read in pages and by what has changed."""

from typing import Annotated, ClassVar, Final

from pydantic import Field

from openrois.types.codes import ComponentFunction
from openrois.types.messages import ReturnResult
from openrois.types.model import Model
from openrois.types.profiles import HRIComponentProfile, ParameterProfile, RoISIdentifier

__all__ = [
    "DIRECTORY",
    "MAX_CHANGED",
    "MAX_PAGE",
    "MAX_PROFILES",
    "ComponentEntry",
    "DirectoryChangedNotification",
    "DirectoryListParams",
    "DirectoryListResult",
    "DirectoryProfilesParams",
    "DirectoryProfilesResult",
    "DirectoryReadParams",
    "DirectoryReadResult",
    "EngineEntry",
]

DIRECTORY: Final = "openrois.directory"
"""The name of the extension in `openrois.hello`."""

MAX_PAGE: Final = 100
"""Engines of one reply."""

MAX_PROFILES: Final = 256
"""Components about whose profiles one request may ask."""

MAX_CHANGED: Final = 256
"""Engines that one notification names; of more the directory has to be listed again."""


class ComponentEntry(Model):
    """A component in short.

    Attributes:
        component_ref: the component.
        component_type: the URN of its type.
        function: of its profile.
        profile_version: of its profile; components with equal profiles have the same.
    """

    component_ref: str
    component_type: str
    function: ComponentFunction | None = Field(default=None, strict=False)
    profile_version: str


class EngineEntry(Model):
    """An engine in short.

    Attributes:
        engine_id: the engine.
        parent_id: the engine right above it; empty for the main one.
        version: another one whenever anything of this entry is.
        extensions: those of the base wire that it speaks, such as `rois.stream`.
        components: those that it owns, not those of engines below it.
        identifier: of its profile, where that says more than `engine_id`.
        parameter_profiles: of its profile.
    """

    engine_id: str
    parent_id: str
    version: str
    extensions: tuple[str, ...] = Field(default=(), strict=False)
    components: tuple[ComponentEntry, ...] = Field(default=(), strict=False)
    identifier: RoISIdentifier | None = None
    parameter_profiles: tuple[ParameterProfile, ...] = Field(default=(), strict=False)


class DirectoryListParams(Model):
    """Params of `openrois.directory.list`: the engines behind `after`, in the order of their ids.

    `component_types` leaves out engines that do not own a component of each of these types.
    """

    after: str = ""
    limit: Annotated[int, Field(ge=1, le=MAX_PAGE)] = MAX_PAGE
    component_types: tuple[str, ...] = Field(default=(), max_length=64, strict=False)


class DirectoryListResult(ReturnResult):
    """Result of `openrois.directory.list`: `next` is the `after` of the next page, empty where there is none."""

    engines: tuple[EngineEntry, ...] = Field(default=(), strict=False)
    next: str = ""
    count: Annotated[int, Field(ge=0)] = 0
    """How many engines there are in all, of whatever types."""


class DirectoryReadParams(Model):
    """Params of `openrois.directory.read`: the engines to be told of."""

    engine_ids: tuple[str, ...] = Field(max_length=MAX_PAGE, strict=False)


class DirectoryReadResult(ReturnResult):
    """Result of `openrois.directory.read`: those that do not exist are absent; `left` are those that found no room."""

    engines: tuple[EngineEntry, ...] = Field(default=(), strict=False)
    left: tuple[str, ...] = Field(default=(), strict=False)


class DirectoryProfilesParams(Model):
    """Params of `openrois.directory.profiles`: components whose profiles are wanted, one for each version suffices."""

    component_refs: tuple[str, ...] = Field(max_length=MAX_PROFILES, strict=False)


class DirectoryProfilesResult(ReturnResult):
    """Result of `openrois.directory.profiles`: profiles by `profile_version`; `left` are refs that found no room."""

    profiles: dict[str, HRIComponentProfile] = Field(default={}, strict=False)
    left: tuple[str, ...] = Field(default=(), strict=False)


class DirectoryChangedNotification(Model):
    """Which engines came or are others now, and which have gone; in the place of `rois.system.profile_changed`.

    `unnamed` is 1 or more where more has changed than is named: the directory has to be listed again.
    """

    method: ClassVar[str] = "openrois.directory.changed"

    changed: tuple[str, ...] = Field(default=(), strict=False)
    gone: tuple[str, ...] = Field(default=(), strict=False)
    unnamed: Annotated[int, Field(ge=0)] = 0
