"""The components of the suite's own adapter: some of every class, and one of each type of the standard."""

from typing import Any, Final

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.types.codes import ComponentFunction
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    HRIEngineProfile,
    ParameterProfile,
    QueryMessageProfile,
    RoISIdentifier,
    component_urn,
)

__all__ = ["FATES", "PARAMETERS", "URN", "component_profiles", "engine_profile", "profile_result", "sample"]

PROBE: Final = RoISIdentifier(code="Probe", authority="Conformance")
URN: Final = component_urn(PROBE.code, PROBE.authority)
"""The type of the suite's own components that can be reserved."""

FATES: Final = {
    "fail": "ERROR",
    "abort": "ABORT",
    "time_out": "TIMEOUT",
    "overload": "OUT_OF_RESOURCES",
}
"""Commands of the probes that end badly, and how; all others end OK."""

_SAMPLES: Final = {
    "int": "-7",
    "double": "2.5",
    "bool": "true",
    "string": "日本",
    "datetime": "2026-11-21T00:00:00+00:00",
    "component_status": "READY",
    "stream_status": "STREAMING_RUNNING",
    "roisidentifier": "urn:example:1",
    "string[]": '["a","b"]',
    "int[]": "[1,-2]",
    "roisidentifier[]": '["urn:example:1"]',
}

PARAMETERS: Final = (
    ("count", "int", "5"),
    ("ratio", "double", "0.5"),
    ("on", "bool", "false"),
    ("label", "string", "plain"),
    ("since", "DateTime", ""),
    ("labels", "string[]", '["x"]'),
    ("counts", "int[]", "[1]"),
)
"""The parameters of the probes: name, type and default; one has no value."""


def sample(code: str) -> str:
    """Return a value of a type, as text."""
    return _SAMPLES.get(code.lower(), "text")


def _value(name: str, code: str, default: str = "") -> ParameterProfile:
    return ParameterProfile(name=name, data_type_ref=RoISIdentifier(code=code), default_value=default)


def _probe(name: str, function: ComponentFunction | None) -> HRIComponentProfile:
    everything = tuple(_value(name, code) for name, code, _ in PARAMETERS)
    return HRIComponentProfile(
        identifier=PROBE,
        name=name,
        function=function,
        command_profiles=(
            *(command.profile() for command in ROIS_COMMON.commands),
            CommandMessageProfile(name="echo", arguments=everything, results=everything),
            CommandMessageProfile(name="hang"),
            CommandMessageProfile(name="refuse"),
            CommandMessageProfile(name="crash"),
            CommandMessageProfile(name="ignore"),
            *(CommandMessageProfile(name=fate) for fate in FATES),
        ),
        query_profiles=(
            *(query.profile() for query in ROIS_COMMON.queries),
            QueryMessageProfile(name=f"view_of_{name}", results=everything),
            QueryMessageProfile(name=f"hang_of_{name}"),
            QueryMessageProfile(name=f"crash_of_{name}"),
            QueryMessageProfile(name="view", results=(_value("label", "string"),)),
        ),
        event_profiles=(
            EventMessageProfile(name=f"happened_to_{name}", results=everything),
            EventMessageProfile(name="happened", results=(_value("label", "string"),)),
        ),
        parameter_profiles=tuple(_value(*parameter) for parameter in PARAMETERS),
    )


def component_profiles(engine_id: str) -> dict[str, HRIComponentProfile]:
    """Return the components of the adapter and of the engine below it, by component_ref."""
    actuation, sensing, function = ComponentFunction
    probes = (
        _probe("arm", actuation),
        _probe("leg", actuation),
        _probe("eye", sensing),
        _probe("tool", function),
        _probe("thing", None),
    )
    profiles = {f"{engine_id}/{profile.name}": profile for profile in probes}
    profiles.update({f"{engine_id}/{kind.name}": kind.profile() for kind in BASIC_COMPONENTS})
    deep = _probe("deep", sensing)
    return {**profiles, f"{engine_id}-below/{deep.name}": deep}


def engine_profile(engine_id: str, refs: tuple[str, ...], *below: HRIEngineProfile) -> HRIEngineProfile:
    """Return the profile of an engine: those of `refs` that it owns are its components."""
    own = tuple(ref for ref in refs if ref.startswith(f"{engine_id}/"))
    return HRIEngineProfile(identifier=RoISIdentifier(code=engine_id), component_ids=own, sub_profiles=below)


def profile_result(engine_id: str, profiles: dict[str, HRIComponentProfile]) -> dict[str, Any]:
    """Return the result of get_profile."""
    refs = tuple(profiles)
    below = engine_profile(f"{engine_id}-below", refs)
    tree = engine_profile(engine_id, refs, *((below,) if below.component_ids else ()))
    return {
        "return_code": "OK",
        "profile": tree.model_dump(mode="json"),
        "component_profiles": {ref: profile.model_dump(mode="json") for ref, profile in profiles.items()},
    }
