"""Media that applications send to a body, as sources for its components."""

from typing import ClassVar

from openrois_signaling.messages import MediaKind
from openrois_streaming.source.shared_inlet import SharedInlet
from openrois_streaming.source.source import RawAudio, RawVideo

__all__ = ["AudioUplink", "VideoUplink"]


class VideoUplink(SharedInlet[RawVideo]):
    """Camera that an application sends; a `MediaSource[RawVideo]` that waits while there is none.

        async with camera.subscribe(1) as pictures:
            picture = await pictures.get()

    Its pictures are decoded while there is a reader, and only then.

    Args:
        name: its name in the log.
    """

    kind: ClassVar[MediaKind] = "video"

    def __init__(self, name: str = "camera of an application") -> None:
        super().__init__(name)


class AudioUplink(SharedInlet[RawAudio]):
    """Microphone that an application sends; as `VideoUplink`.

    Args:
        name: its name in the log.
    """

    kind: ClassVar[MediaKind] = "audio"

    def __init__(self, name: str = "microphone of an application") -> None:
        super().__init__(name)
