"""The streaming verbs of a component, over the extension where the gateway has it and in strict RoIS elsewhere."""

import asyncio
import json
import logging
from collections.abc import Coroutine, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any

from openrois.catalog.streaming import ConnectStreamResults, NotifyStreamStatus, StreamStatusResults
from openrois.client.component import ComponentProxy
from openrois.client.errors import ConnectionLost
from openrois.client.feed import BUFFER
from openrois.client.rpc_call import read_result
from openrois.client.subscription import Subscription
from openrois.client.values import read, where
from openrois.errors import BadParameter, RoISError, Unsupported
from openrois.types.codes import StreamStatus
from openrois.types.messages import Parameter
from openrois.types.streams import MAX_PLAYOUT, StreamStatusResult

__all__ = ["Streaming"]

_log = logging.getLogger(__name__)

_kept: set[asyncio.Task[None]] = set()
"""The loop itself keeps no task; these end with the connection of their client at the latest."""


class Streaming(ComponentProxy):
    """A component with streams. Media do not pass through RoIS: their negotiation is in `Client.notifications`."""

    async def connect_stream(
        self, *, encoding: Mapping[str, Any] | None = None, transport: Mapping[str, Any] | None = None
    ) -> str:
        """Connect a stream and return its id, which stands for it until it ends.

        In strict RoIS `encoding` and `transport` are the component's and are set before, for every application; over
        the extension they are this stream's alone.

        Args:
            encoding: what the application can decode, such as `{"codecs": ["video/H264"]}`.
            transport: such as `{"direction": "recvonly"}`.

        Raises:
            Unsupported: there is nothing that both sides can do.
            RoISError: the component refused.
        """
        given = {"encoding_parameters": encoding, "transport_parameters": transport}
        chosen = {name: json.dumps(value) for name, value in given.items() if value is not None}
        if self._extension:
            parameters = [Parameter(name=name, data_type_ref="string", value=text) for name, text in chosen.items()]
            with suppress(Unsupported):
                return await self.client.connect_stream(self.component_ref, parameters)
        if chosen:
            if self._extension:
                raise Unsupported(f"{self.component_ref} has no stream with these parameters")
            await self.set_parameter(**chosen)
        connecting = asyncio.ensure_future(self.command("connect_stream", ConnectStreamResults))
        try:
            return (await asyncio.shield(connecting)).stream_id
        except asyncio.CancelledError:
            # The command goes on, and its stream would belong to an application that never learns its id.
            _keep(self._give_back(connecting))
            raise

    async def _give_back(self, connecting: asyncio.Future[ConnectStreamResults]) -> None:
        try:
            await self.disconnect_stream((await connecting).stream_id)
        except (RoISError, ConnectionLost) as error:
            _log.debug("a stream that is not waited for any more is not given back: %s", error)

    async def disconnect_stream(self, stream_id: str) -> None:
        """End a stream.

        Raises:
            Unsupported: there is no such stream.
        """
        await self._act_on("disconnect_stream", stream_id)

    async def suspend_stream(self, stream_id: str) -> None:
        """Suspend a stream; it stays connected, and no media arrive.

        Raises:
            Unsupported: there is no such stream.
        """
        await self._act_on("suspend_stream", stream_id)

    async def resume_stream(self, stream_id: str) -> None:
        """Resume a stream that was suspended.

        Raises:
            Unsupported: there is no such stream.
        """
        await self._act_on("resume_stream", stream_id)

    async def _act_on(self, verb: str, stream_id: str) -> None:
        if await self._extended(verb, stream_id=stream_id) is None:
            with self._unknown_otherwise(stream_id):
                await self.command(verb, None, stream_id=stream_id)

    async def get_stream_status(self, stream_id: str) -> StreamStatus:
        """Return the status of a stream (RoIS 2.0, table 8.10).

        Raises:
            Unsupported: there is no such stream.
        """
        result = await self._extended("query_stream_status", stream_id=stream_id)
        if result is not None:
            return read_result("rois.stream.query_stream_status", StreamStatusResult, result).status
        condition = where(component_ref=self.component_ref, stream_id=stream_id)
        with self._unknown_otherwise(stream_id):
            try:
                results = await self.client.query("get_stream_status", condition)
            except BadParameter:
                # A query has no arguments, and not every gateway takes one in the condition.
                return (await self.query("get_stream_status", StreamStatusResults)).status
        given: StreamStatusResults = read(f"get_stream_status of {self.component_ref}", StreamStatusResults, results)
        return given.status

    async def report_playout(self, stream_id: str, seconds: float) -> None:
        """Report how long media of a stream wait here until they are played: only the player knows that delay.

        Worth saying again when it has changed, every two seconds at most.

        Args:
            stream_id: a stream that this application receives.
            seconds: from the arrival of a packet to its being played; at most 60.

        Raises:
            Unsupported: there is no such stream, or the gateway does not have the extension.
            OutOfResources: this was said too often.
        """
        milliseconds = min(max(round(seconds * 1000), 0), MAX_PLAYOUT)
        if await self._extended("report_playout", stream_id=stream_id, milliseconds=milliseconds) is None:
            raise Unsupported(f"{self.component_ref} takes no playout reports for {stream_id}")

    def notify_stream_status(self, *, buffer: int = BUFFER) -> Subscription[NotifyStreamStatus]:
        """Return status changes of streams from now on; a gateway with the extension reports this application's own."""
        return self.event("notify_stream_status", NotifyStreamStatus, buffer=buffer)

    @property
    def _extension(self) -> bool:
        return "rois.stream" in self.client.extensions

    async def _extended(self, verb: str, **params: Any) -> dict[str, Any] | None:
        """Call a verb as a method, or return None where it has to be sent in strict RoIS.

        That is where the gateway lacks the extension, and where the engine behind it does: it answers UNSUPPORTED then.
        """
        if not self._extension:
            return None
        try:
            return await self.client.call(f"rois.stream.{verb}", **params)
        except Unsupported:
            return None

    @contextmanager
    def _unknown_otherwise(self, stream_id: str) -> Iterator[None]:
        """Try in strict RoIS what the extension does not know; where that fails too there is no such stream."""
        try:
            yield
        except RoISError as error:
            if not self._extension:
                raise
            raise Unsupported(f"{self.component_ref} has no stream {stream_id}") from error


def _keep(work: Coroutine[Any, Any, None]) -> None:
    task = asyncio.ensure_future(work)
    _kept.add(task)
    task.add_done_callback(_kept.discard)
