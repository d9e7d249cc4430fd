"""Cases of the corpus that do not follow from the types: whole profiles, and rules that a schema cannot express."""

from openrois_signaling.messages import ID_LIMIT

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
from openrois.types.references import reference
from openrois_codegen.corpus import Case

__all__ = ["by_hand"]

_LONG = "鍵" * (ID_LIMIT // 2)
"""Fewer characters than an identifier may have, and more bytes."""


def by_hand() -> dict[str, tuple[Case, ...]]:
    """Return the cases by the type that they are of."""
    candidate = {"peer_id": "robot/0", "generation": 1, "candidate": "candidate:1 1 udp 1 192.0.2.1 9 typ host"}
    return {
        "HRIComponentProfile": tuple(
            Case(found.code, found.profile().model_dump(mode="json")) for found in BASIC_COMPONENTS
        ),
        "HRIEngineProfile": (Case("engines eight deep", _tree(8).model_dump(mode="json")),),
        "ProfileResult": (Case("a robot behind a gateway", _profiles()),),
        "Candidate": (
            Case("a candidate of no section", candidate, "rule"),
            Case("a candidate of a section by its number", {**candidate, "sdp_m_line_index": 0}),
            Case("no candidate, and of no section", {**candidate, "candidate": ""}),
            Case("peer_id: too many bytes", {**candidate, "sdp_mid": "0", "peer_id": _LONG}, "rule"),
        ),
        "Restart": (Case("peer_id: too many bytes", {"peer_id": _LONG}, "rule"),),
    }


def _tree(depth: int) -> HRIEngineProfile:
    below = (_tree(depth - 1),) if depth > 1 else ()
    return HRIEngineProfile(identifier=RoISIdentifier(code=f"engine {depth}"), sub_profiles=below)


def _profiles() -> dict[str, object]:
    components = {reference("robot", found.name): found.profile() for found in BASIC_COMPONENTS[:2]}
    robot = HRIEngineProfile(identifier=RoISIdentifier(code="robot"), component_ids=tuple(components))
    gateway = HRIEngineProfile(identifier=RoISIdentifier(code="gateway"), sub_profiles=(robot,))
    return {
        "return_code": "OK",
        "profile": gateway.model_dump(mode="json"),
        "component_profiles": {ref: profile.model_dump(mode="json") for ref, profile in components.items()},
    }
