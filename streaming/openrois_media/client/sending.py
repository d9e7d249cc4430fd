"""What an application sends, and its consent to what that may be used for."""

from collections.abc import Collection, Mapping
from typing import Any

from openrois.client import Client
from openrois.types.codes import Purpose, StreamStatus
from openrois_media.client.stream import SentStream
from openrois_media.client.stream_state import Desire

__all__ = ["Sending", "consenting"]


def consenting(purposes: Collection[Purpose]) -> Mapping[str, Any]:
    """Return the member of `transport_parameters` that states consent."""
    return {"consent": sorted(purposes)}


class Sending:
    """What an application sends, inside its `async with` block.

    Attributes:
        component_refs: the components that it is sent to.
    """

    def __init__(self, streams: list[SentStream], client: Client) -> None:
        self.component_refs = tuple(stream.component_ref for stream in streams)
        self._streams = streams
        self.visitor_ref = ""
        """Name of the visitor that this application is to others; known once `consent` was called."""
        self._client = client

    @property
    def status(self) -> dict[str, StreamStatus | None]:
        """Status of each stream by its component; None without a connection to the gateway."""
        return {stream.component_ref: stream.state.status for stream in self._streams}

    @property
    def problem(self) -> str:
        """What keeps a stream from running, in a sentence; it is tried again. Empty for nothing."""
        return next((each.problem for each in self._streams if each.problem), "")

    async def suspend(self) -> None:
        """Stop reading the sources, and sending, until `resume`."""
        await self._want(Desire.SUSPENDED)

    async def resume(self) -> None:
        """Go on."""
        await self._want(Desire.RUNNING)

    async def consent(self, *purposes: Purpose) -> None:
        """Consent to these purposes, and to no other, from now on; without any everything is withdrawn.

        It holds for all that this application sends to the body, also after it was connected again. Nothing is sent
        until the body knows it.

        Raises:
            RoISError: the engine refuses.
            ConnectionLost, TimeoutError: the engine was not told; it is when the streams are connected again.
        """
        stated = consenting(purposes)
        connected = None
        for stream in self._streams:
            stream.transport = stated
            connected = connected or stream.state.stream_id
        if connected is not None:
            told = await self._client.call("rois.stream.set_consent", stream_id=connected, **stated)
            self.visitor_ref = told.get("visitor_ref", "")
            for stream in self._streams:
                # Of one that is connected at this moment `connect` notes it.
                if stream.transport is stated and stream.state.stream_id is not None:
                    stream.known_transport = stated

    async def finished(self) -> None:
        """Wait until every source has ended, such as one that plays a file.

        Raises:
            Exception: what a source has raised.
        """
        for stream in self._streams:
            await stream.news.until(lambda stream=stream: stream.ended)  # type: ignore[misc]
            if stream.failure is not None:
                raise stream.failure

    async def _want(self, desire: Desire) -> None:
        for stream in self._streams:
            stream.want(desire)
        for stream in self._streams:
            await stream.settled()
