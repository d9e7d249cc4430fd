"""Visitors of a body as an application meets them: who sends, and microphone and camera of each."""

from collections.abc import Mapping
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, TypedDict

import numpy as np
from numpy.typing import NDArray
from openrois_signaling.messages import MediaKind
from openrois_streaming.source.av_frames import FrameFormat

from openrois.client import Client, Unsupported, where
from openrois.types.codes import Purpose
from openrois.types.references import reference
from openrois.types.values import decode_value
from openrois_media.client.readers import Block, Frame, StreamReader

__all__ = ["Visitor", "VisitorCamera", "VisitorDevice", "VisitorMicrophone", "read_visitors"]


class _Media(Protocol):
    """What a device needs of `Media`."""

    def frames(
        self, camera: "VisitorDevice", format: FrameFormat = ...
    ) -> AbstractAsyncContextManager[StreamReader[Frame]]: ...

    def blocks(self, microphone: "VisitorDevice") -> AbstractAsyncContextManager[StreamReader[Block]]: ...

    async def snapshot(self, camera: "VisitorDevice", format: Any = ...) -> Any: ...


@dataclass(frozen=True, slots=True)
class VisitorDevice:
    """Microphone or camera of a visitor; `Media.blocks`, `Media.frames` and `Media.snapshot` take it too.

    Attributes:
        component_ref: the streaming component that it is sent to, and received from.
        visitor_ref: the visitor.
        purposes: what this application uses it for.
    """

    kind: ClassVar[MediaKind]
    name: ClassVar[str]

    component_ref: str
    visitor_ref: str
    purposes: frozenset[Purpose]
    media: _Media = field(repr=False, compare=False)

    @property
    def transport(self) -> Mapping[str, Any]:
        """Members of the `transport_parameters` of its streams."""
        return {"visitor_ref": self.visitor_ref, "purposes": sorted(self.purposes)}


class VisitorMicrophone(VisitorDevice):
    """Microphone of a visitor."""

    __slots__ = ()
    kind = "audio"
    name = "microphone"

    def blocks(self) -> AbstractAsyncContextManager[StreamReader[Block]]:
        """Yield its sound; as `Media.blocks`."""
        return self.media.blocks(self)


class VisitorCamera(VisitorDevice):
    """Camera of a visitor."""

    __slots__ = ()
    kind = "video"
    name = "camera"

    def frames(self, format: FrameFormat = "rgb24") -> AbstractAsyncContextManager[StreamReader[Frame]]:
        """Yield its pictures; as `Media.frames`."""
        return self.media.frames(self, format)

    async def snapshot(self) -> bytes:
        """Return one picture as a JPEG file; as `Media.snapshot`."""
        picture: bytes = await self.media.snapshot(self, "jpeg")
        return picture

    async def picture(self, format: FrameFormat = "rgb24") -> NDArray[np.uint8]:
        """Return one picture as an array; as `Media.snapshot`."""
        pixels: NDArray[np.uint8] = await self.media.snapshot(self, format)
        return pixels


@dataclass(frozen=True, slots=True)
class Visitor:
    """A visitor of a body, as it was when asked for.

    Attributes:
        visitor_ref: its name until it leaves.
        devices: what it sent: `microphone`, `camera`.
        consent: what it consented to.
        is_attended: whether the body's senses followed it.
    """

    visitor_ref: str
    devices: frozenset[str]
    consent: frozenset[str]
    is_attended: bool
    microphone: VisitorMicrophone
    camera: VisitorCamera


class Present(TypedDict):
    """What a body tells of a visitor."""

    visitor_ref: str
    devices: frozenset[str]
    consent: frozenset[str]
    is_attended: bool


async def read_visitors(client: Client, engine_id: str) -> tuple[Present, ...]:
    """Ask a body who sends to it.

    Raises:
        Unsupported: it tells no visitors apart.
        RoISError: it did not answer.
    """
    component_ref = reference(engine_id, "visitors")
    try:
        results = await client.query("visitors", where(component_ref=component_ref))
    except Unsupported as error:
        raise Unsupported(f"{engine_id} tells no visitors apart: it has no {component_ref}") from error
    told = {each.name: decode_value(each.data_type_ref, each.value) for each in results}
    rows = zip(told["visitor_ref"], told["devices"], told["consent"], strict=True)
    return tuple(
        Present(
            visitor_ref=ref,
            devices=frozenset(devices.split()),
            # A newer body may know more purposes than this program.
            consent=frozenset(consent.split()),
            is_attended=ref == told["attended"],
        )
        for ref, devices, consent in rows
    )
