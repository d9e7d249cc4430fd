"""The settings of an avatar adapter."""

from dataclasses import dataclass, field
from typing import Final

from openrois_body.speech_options import EarsChoice, VoiceChoice
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.publish.encoder_limit import ENCODERS_LIMIT

from openrois.component.component import Component
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois_avatar.options.picture_size import PictureSize
from openrois_avatar.options.pixel_streaming import PixelStreaming

__all__ = ["DEFAULT_FACADE", "DEFAULT_LINK", "DRAWN", "ENGINES", "AvatarSettings"]

ENGINES: Final = ("auto", "panda3d", "puppet", "godot", "external", "unreal", "unity-render-streaming", "synthetic")
"""The engines that may render the avatar: `auto` is Panda3D where it runs and else the puppet; `external` is an engine
that is started elsewhere and connects by itself; so do `unreal` and `unity-render-streaming`, which send their pictures
to the viewers themselves; `synthetic` is a test picture."""
DRAWN: Final = ("auto", "panda3d", "puppet")
"""The engines that draw the avatar in its room, and have the options size and visitor."""
DEFAULT_LINK: Final = "tcp:127.0.0.1:8766"
DEFAULT_FACADE: Final = "127.0.0.1:8888"


@dataclass(frozen=True, slots=True)
class AvatarSettings:
    """The settings of one avatar adapter.

    Attributes:
        gateways: `ws://host:port/adapter` of each gateway that it may serve, one at a time.
        engine_id: leads every ref of this avatar; unique behind its gateway.
        engine: one of `ENGINES`.
        stamp: whether a test picture shows its number and the time of its capture, to be measured.
        size: of the pictures that an embedded engine draws; None: as large as the machine carries.
        visitor: whether a person walks about in its room.
        link: where an external engine is awaited, `tcp:host:port` or `unix:/path`, on this machine.
        facade: where an engine that sends its pictures itself finds its signaling server, `host:port` on this machine.
        link_secret: that an engine has to send; empty: any engine will do.
        metrics: host and port of the metrics for Prometheus; None for nowhere.
        network: how its streams use the network.
        max_viewer_bitrate: bit/s that an application is sent at most of each video stream, whatever it asks for; None:
            as much as its path carries.
        max_encoders: encoders of the picture at a time, of all sizes, paces and codecs.
        pixel_streaming: the signaling server of Pixel Streaming that it also serves; None for none.
        credentials: for the gateways.
        voice: what speaks.
        ears: what recognises speech.
        components: the classes of those that the user adds.
    """

    gateways: tuple[str, ...] = ("ws://127.0.0.1:8765/adapter",)
    engine_id: str = "avatar"
    engine: str = "auto"
    stamp: bool = False
    size: PictureSize = None
    visitor: bool = False
    link: str = DEFAULT_LINK
    facade: str = DEFAULT_FACADE
    link_secret: str = field(default="", repr=False)
    metrics: tuple[str, int] | None = None
    network: NetworkSettings = field(default_factory=NetworkSettings)
    max_viewer_bitrate: int | None = None
    max_encoders: int = ENCODERS_LIMIT
    pixel_streaming: PixelStreaming | None = None
    credentials: Credentials = NO_CREDENTIALS
    voice: VoiceChoice = field(default_factory=VoiceChoice)
    ears: EarsChoice = field(default_factory=EarsChoice)
    components: tuple[type[Component], ...] = ()
