"""Streams whose engine is gone: nobody is left there to announce their end."""

from collections.abc import Mapping

from openrois.contract import Directory
from openrois.types.codes import StreamStatus
from openrois.types.streams import StreamStatusNotification
from openrois.types.values import date_time

__all__ = ["lost_streams"]


def lost_streams(streams: Mapping[str, str], directory: Directory, now: float) -> list[StreamStatusNotification]:
    """Return the announcement of the end of each stream whose component is not in the tree any more.

    Args:
        streams: the component_ref of each stream, by stream_id.
        directory: what there is now.
        now: epoch seconds.
    """
    return [
        StreamStatusNotification(
            stream_id=stream_id,
            component_ref=component_ref,
            status=StreamStatus.STREAMING_NOT_CONNECTED,
            timestamp=date_time(now),
        )
        for stream_id, component_ref in streams.items()
        if component_ref not in directory.component_profiles
    ]
