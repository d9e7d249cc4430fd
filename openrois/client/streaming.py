"""The streaming verbs of a component, over the extension where the gateway has it and in strict RoIS elsewhere."""

import json
from collections.abc import Mapping
from typing import Any, Final

from openrois.catalog.streaming import ConnectStreamResults, NotifyStreamStatus, StreamStatusResults
from openrois.client.component import ComponentProxy
from openrois.client.conditions import where
from openrois.client.feed import BUFFER
from openrois.client.subscription import Subscription
from openrois.errors import BadParameter
from openrois.types.codes import StreamStatus
from openrois.types.streams import STREAM_METHODS, ConnectStreamResult, StreamStatusResult

__all__ = ["Streaming"]

_EXTENSION: Final = "rois.stream"


class Streaming(ComponentProxy):
    """A component with streams. Their media flow beside RoIS: what negotiates them is in `Client.notifications`."""

    async def connect_stream(
        self, *, encoding: Mapping[str, Any] | None = None, transport: Mapping[str, Any] | None = None
    ) -> str:
        """Connect a stream and return its id, which stands for it until it ends.

        Args:
            encoding: what the application can decode, such as `{"codecs": ["video/H264"]}`.
            transport: such as `{"direction": "recvonly"}`.

        Raises:
            Unsupported: there is nothing that both sides can do.
            RoISError: the component refused.
        """
        chosen = {
            name: json.dumps(value)
            for name, value in (("encoding_parameters", encoding), ("transport_parameters", transport))
            if value is not None
        }
        if _EXTENSION in self.client.extensions:
            parameters = [{"name": name, "data_type_ref": "string", "value": text} for name, text in chosen.items()]
            result = await self.client.call(
                STREAM_METHODS["connect_stream"], component_ref=self.component_ref, parameters=parameters
            )
            return ConnectStreamResult.model_validate(result).stream_id
        if chosen:
            await self.set_parameter(**chosen)
        return (await self.command("connect_stream", ConnectStreamResults)).stream_id

    async def disconnect_stream(self, stream_id: str) -> None:
        """End a stream."""
        await self._act_on("disconnect_stream", stream_id)

    async def suspend_stream(self, stream_id: str) -> None:
        """Pause a stream."""
        await self._act_on("suspend_stream", stream_id)

    async def resume_stream(self, stream_id: str) -> None:
        """Go on with a stream."""
        await self._act_on("resume_stream", stream_id)

    async def _act_on(self, verb: str, stream_id: str) -> None:
        if _EXTENSION in self.client.extensions:
            await self.client.call(STREAM_METHODS[verb], stream_id=stream_id)
        else:
            await self.command(verb, None, stream_id=stream_id)

    async def get_stream_status(self, stream_id: str) -> StreamStatus:
        """Return what a stream does."""
        if _EXTENSION in self.client.extensions:
            result = await self.client.call("rois.stream.query_stream_status", stream_id=stream_id)
            return StreamStatusResult.model_validate(result).status
        condition = where(component_ref=self.component_ref, stream_id=stream_id)
        try:
            results = await self.client.query("get_stream_status", condition)
        except BadParameter:
            # A query has no arguments, and not every gateway takes one in the condition.
            return (await self.query("get_stream_status", StreamStatusResults)).status
        return StreamStatusResults.from_results(results).status

    def notify_stream_status(self, *, buffer: int = BUFFER) -> Subscription[NotifyStreamStatus]:
        """Iterate over what the streams do from now on; the gateway tells of this application's own."""
        return self.event("notify_stream_status", NotifyStreamStatus, buffer=buffer)
