"""Narrows a tree of engines and its faults to the scope of a principal: what is out of scope is absent. Pure."""

from collections.abc import Collection
from dataclasses import replace
from typing import Any

from openrois.auth.principal import Principal
from openrois.contract import Directory, Fault
from openrois.engine.tree import Tree
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile
from openrois.types.references import engine_of

__all__ = ["scoped_directory", "scoped_fault"]

_UNNAMED = "the engine has a fault"


def scoped_directory(directory: Directory, principal: Principal) -> Directory:
    """Return a directory without what is out of scope.

    An engine without a component in scope, its own or below it, is not there either; the root always is. Where
    everything is in scope the directory is returned as it is.
    """
    if principal.sees_everything:
        return directory
    components = {
        ref: _shown_component(profile, principal)
        for ref, profile in directory.component_profiles.items()
        if principal.sees(ref)
    }
    return Directory(_shown_engine(directory.profile, components.keys()), components)


def _shown_component(profile: HRIComponentProfile, principal: Principal) -> HRIComponentProfile:
    """Return a component's profile without the refs of parts that are out of scope; nothing is copied in vain."""
    named = tuple(ref for ref in profile.sub_component_profiles if "/" not in ref or principal.sees(ref))
    if len(named) == len(profile.sub_component_profiles):
        return profile
    return profile.model_copy(update={"sub_component_profiles": named})


def _shown_engine(profile: HRIEngineProfile, components: Collection[str]) -> HRIEngineProfile:
    below = (_shown_engine(sub_profile, components) for sub_profile in profile.sub_profiles)
    return profile.model_copy(
        update={
            "sub_profiles": tuple(sub_profile for sub_profile in below if sub_profile.component_refs()),
            "component_ids": tuple(ref for ref in profile.component_ids if ref in components),
        }
    )


def scoped_fault(fault: Fault, tree: Tree[Any], shown: Tree[Any], principal: Principal) -> Fault | None:
    """Return a fault as the principal may see it, None where it may not.

    The sentence about a fault of an engine may name any component: a principal that sees only some reads another.

    Args:
        fault: what happened.
        tree: all there is.
        shown: what the principal is shown of that.
        principal: that is notified.
    """
    if fault.component_ref:
        return fault if principal.sees(fault.component_ref) else None
    if not shown.has_engine(engine_of(fault.error_id)):
        return None
    whole = len(shown.components) == len(tree.components)
    return fault if whole else replace(fault, description=_UNNAMED)
