"""Components that take what an application sends or speaks."""

import json
from typing import Final

from openrois_signaling.messages import MediaKind

from openrois.catalog.component_type import ComponentType
from openrois.client import BadParameter, Client, ComponentProxy, Unsupported
from openrois.client.components import AudioStreaming, VideoStreaming
from openrois.types.codes import ComponentFunction
from openrois.types.references import engine_of

__all__ = ["SPEECH_STREAM", "STREAMING_TYPES", "find_carrier", "find_speaker", "find_uplink"]

STREAMING_TYPES: Final[dict[MediaKind, type[VideoStreaming] | type[AudioStreaming]]] = {
    "video": VideoStreaming,
    "audio": AudioStreaming,
}
SPEECH_STREAM: Final = ComponentType(
    "SpeechStream",
    "speech_stream",
    "The body speaks sound that an application sends.",
    "",
    ComponentFunction.ACTUATION,
    authority="OpenRoIS",
)
"""The type of components that speak by sound."""


async def find_speaker(client: Client, to: str | ComponentProxy | None) -> ComponentProxy:
    """Return the component that speaks by sound."""
    ref = None if to is None else to if isinstance(to, str) else to.component_ref
    known = await client.find_all(SPEECH_STREAM)
    found = [each for each in known if ref is None or engine_of(each.component_ref) in (ref, engine_of(ref))]
    if not found:
        raise Unsupported(
            f"no component{'' if ref is None else f' of {ref}'} speaks by sound: there is no SpeechStream; send texts "
            "to a SpeechSynthesis"
        )
    if len(found) > 1:
        names = ", ".join(each.component_ref for each in found)
        raise BadParameter(f"several components speak by sound, say which: {names}")
    return found[0]


async def find_carrier(client: Client, component_ref: str) -> tuple[str, MediaKind]:
    """Return a streaming component of the same body, and its kind: sound rather than pictures."""
    kinds: tuple[MediaKind, ...] = ("audio", "video")
    for kind in kinds:
        for each in await client.find_all(STREAMING_TYPES[kind]):
            if engine_of(each.component_ref) == engine_of(component_ref):
                return each.component_ref, kind
    raise Unsupported(f"the body of {component_ref} streams nothing, so there is no way to it")


async def find_uplink(client: Client, kind: MediaKind, to: str | ComponentProxy | None) -> str:
    """Return the component that takes what an application sends."""
    known = await client.find_all(STREAMING_TYPES[kind])
    if to is not None:
        ref = to if isinstance(to, str) else to.component_ref
        exact = [each for each in known if each.component_ref == ref]
        known = exact or [each for each in known if engine_of(each.component_ref) == (engine_of(ref) or ref)]
    taking = [each.component_ref for each in known if await _takes(each)]
    where = "" if to is None else f" of {to if isinstance(to, str) else to.component_ref}"
    if not taking:
        raise Unsupported(f"no component{where} takes the {kind} of an application")
    if len(taking) > 1:
        raise BadParameter(f"several components take the {kind} of an application, say which: {', '.join(taking)}")
    return taking[0]


async def _takes(component: ComponentProxy) -> bool:
    """Tell whether a component says that applications may send to it."""
    parameters = await component.client.get_parameter(component.component_ref)
    text = next((each.value for each in parameters if each.name == "available_transports"), "")
    try:
        transports = json.loads(text) if text else {}
        directions = transports.get("direction", [])
    except (ValueError, AttributeError):
        return False
    return "sendonly" in directions
