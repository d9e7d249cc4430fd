"""Scripted applications: what a program made with an SDK asks of a gateway, without the SDK."""

import asyncio
import json
from collections import Counter
from collections.abc import Coroutine
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.transport.stream import MessageStream, StreamClosed
from openrois_bench.simulation.bodies import BURST_EVENT, BURST_SOURCE, EVENT, EVENT_SOURCE, SDP, Body
from openrois_bench.simulation.door import Door, PeerStream
from openrois_bench.simulation.mix import COMMAND_SECONDS

__all__ = ["Application"]

PATIENCE: Final = 30.0
"""Virtual seconds that an answer may take."""

SHOWN: Final = 20
"""Bodies that an application shows of those that it sees."""

PIPELINED: Final = 16
"""Questions that an application asks before the first answer, where it asks several together."""

_EVENT: Final = '"rois.event.notify_event"'


class Lost(Exception):
    """The connection ended before the answer."""


class Application:
    """One application, which works with one body.

    Args:
        number: of the application.
        front: the gateway that it dials.
        body: the body.
        sees_all: whether every body is in its scope, or this one alone.
        counts: what happened, by name; shared.
        tasks: owns its reading.

    Attributes:
        body: what it works with.
    """

    def __init__(
        self, number: int, front: Door, body: Body, *, sees_all: bool, counts: Counter[str], tasks: TaskScope
    ) -> None:
        self._subject = f"subject-{number:06}"
        self._front = front
        self.body = body
        self._scope = "*" if sees_all else f"{body.engine_id}/*"
        self._counts = counts
        self._tasks = tasks
        self._stream: PeerStream | None = None
        self._asked = 0
        self._subscribed = ""
        self._receives = "deliveries"
        self._waiting: dict[str | int, asyncio.Future[Any]] = {}

    async def enter(self) -> None:
        """Connect, say hello, and read what is shown."""
        self._stream = await self._front.dial_application(self.body.gateway, self._subject, self._scope)
        self._tasks.start(self._read(self._stream))
        await self._ask("rois.system.connect", {})
        await self._ask("openrois.hello", {"version": "1", "extensions": ["openrois.directory", "openrois.lease"]})
        await self._ask("openrois.directory.list", {"limit": SHOWN})
        self._counts["sessions"] += 1

    async def come_back(self) -> None:
        """Lose the connection, and connect again."""
        assert self._stream is not None
        self._stream.abort()
        await asyncio.sleep(1)
        await self.enter()
        self._counts["returns"] += 1

    async def leave(self) -> None:
        """Close the connection in good order."""
        assert self._stream is not None
        await self._stream.close()

    async def query(self) -> None:
        """Ask the body something."""
        await self._query(1)
        self._counts["queries"] += 1

    async def query_together(self) -> None:
        """Ask the body several things before the first answer."""
        await self._query(PIPELINED)
        self._counts["pipelined queries"] += PIPELINED

    async def _query(self, times: int) -> None:
        condition = f"component_ref = '{self.body.engine_id}/navigation'"
        await self._ask("rois.query.query", {"query_type": "component_status", "condition": condition}, times)

    async def command(self, component: str) -> None:
        """Bind a component, run a command of it to its end, and release it; skip it while another one has it."""
        ref = f"{self.body.engine_id}/{component}"
        bound = await self._ask("rois.command.bind", {"component_ref": ref})
        if bound["return_code"] != "OK":
            self._counts["refused binds"] += 1
            return
        command_id = f"command {self._asked}"
        completed = self._expect(command_id)
        unit = {"component_ref": ref, "command_type": "start", "command_id": command_id}
        await self._ask("rois.command.execute", {"command_unit_list": [unit]})
        await self._arrived(completed, COMMAND_SECONDS + PATIENCE)
        await self._ask("rois.command.release", {"component_ref": ref})
        self._counts["commands"] += 1

    async def subscribe(self) -> None:
        """Subscribe to the body's events, until `unsubscribe`."""
        self._receives = "deliveries"
        await self._subscribe(EVENT_SOURCE, EVENT)

    async def subscribe_to_bursts(self) -> None:
        """Subscribe to the body's events that come in bursts, until `unsubscribe`."""
        self._receives = "burst deliveries"
        await self._subscribe(BURST_SOURCE, BURST_EVENT)

    async def listen_in_vain(self) -> None:
        """Subscribe for a moment to an event that does not happen meanwhile."""
        await self.subscribe_to_bursts()
        await self.unsubscribe()

    async def _subscribe(self, component: str, event_type: str) -> None:
        condition = f"component_ref = '{self.body.engine_id}/{component}'"
        told = await self._ask("rois.event.subscribe", {"event_type": event_type, "condition": condition})
        self._subscribed = told["subscribe_id"]
        self._counts["subscriptions"] += 1

    async def unsubscribe(self) -> None:
        """Receive no more events."""
        await self._ask("rois.event.unsubscribe", {"subscribe_id": self._subscribed})

    async def watch(self, seconds: float) -> None:
        """Receive the body's events for a while."""
        await self.subscribe()
        await asyncio.sleep(seconds)
        await self.unsubscribe()

    async def stream(self, seconds: float) -> None:
        """Connect a stream, negotiate its peer connection, and end it after a while."""
        told = await self._ask(
            "rois.stream.connect_stream", {"component_ref": f"{self.body.engine_id}/video_streaming"}
        )
        stream_id = told["stream_id"]
        if told["return_code"] != "OK":
            self._counts["refused streams"] += 1
            return
        offered, running = self._expect(f"offer of {stream_id}"), self._expect(f"status of {stream_id}")
        await self._arrived(offered, PATIENCE)
        del self._waiting[f"offer of {stream_id}"]
        peer = {"peer_id": stream_id, "generation": 1}
        await self._ask("signaling.answer", {**peer, "sdp": SDP})
        for number in range(2):
            line = f"candidate:{number} 1 udp 1 192.0.2.1 50000 typ host"
            await self._ask("signaling.candidate", {**peer, "candidate": line, "sdp_mid": "0"})
        await self._arrived(running, PATIENCE)
        await asyncio.sleep(seconds)
        await self._ask("rois.stream.disconnect_stream", {"stream_id": stream_id})
        self._counts["streams"] += 1

    async def attempt(self, *acts: Coroutine[Any, Any, None]) -> None:
        """Do some things at the same time, of which each may fail with the body's adapter or the connection."""
        for outcome in await asyncio.gather(*acts, return_exceptions=True):
            if isinstance(outcome, Lost | TimeoutError):
                self._counts["lost with an adapter"] += 1
            elif isinstance(outcome, BaseException):
                raise outcome

    def _expect(self, key: str | int) -> asyncio.Future[Any]:
        answer = self._waiting.get(key)
        if answer is None:
            answer = self._waiting[key] = asyncio.get_running_loop().create_future()
        return answer

    async def _arrived(self, answer: asyncio.Future[Any], seconds: float) -> Any:
        async with asyncio.timeout(seconds):
            return await answer

    async def _ask(self, method: str, params: dict[str, Any], times: int = 1) -> dict[str, Any]:
        """Ask so many times at once, and return the last answer."""
        numbers = range(self._asked + 1, self._asked + times + 1)
        self._asked += times
        answers = [self._expect(number) for number in numbers]
        asked = f'"method":"{method}","params":{json.dumps(params)}'
        assert self._stream is not None
        try:
            await self._stream.send_many([f'{{"jsonrpc":"2.0","id":{number},{asked}}}' for number in numbers])
        except StreamClosed as closed:
            raise Lost(method) from closed
        self._counts["requests"] += times
        result: dict[str, Any] = {}
        for answer in answers:
            result = await self._arrived(answer, PATIENCE)
        return result

    async def _read(self, stream: MessageStream) -> None:
        try:
            while True:
                # Nothing keeps the last message: there are a hundred thousand applications.
                self._take_text(await stream.receive())
        except StreamClosed:
            waiting, self._waiting = self._waiting, {}
            for answer in waiting.values():
                if not answer.done():
                    answer.set_exception(Lost("the connection ended"))
                    # Its task may have ended already with another answer.
                    answer.exception()

    def _take_text(self, text: str) -> None:
        self._counts["bytes to applications"] += len(text)
        if _EVENT in text[:60]:
            self._counts[self._receives] += 1
            return
        message = json.loads(text)
        if "id" in message:
            self._settle(message["id"], message["result"])
            return
        params = message["params"]
        match message["method"]:
            case "rois.command.completed":
                self._settle(params["command_id"], params["status"])
            case "signaling.offer":
                # It may be read before the task that asked for the stream goes on with the reply.
                self._expect(f"offer of {params['peer_id']}").set_result(params)
            case "rois.stream.notify_stream_status":
                self._settle(f"status of {params['stream_id']}", params["status"])
            case "openrois.directory.changed":
                self._counts["changes"] += 1

    def _settle(self, key: str | int, value: Any) -> None:
        answer = self._waiting.pop(key, None)
        if answer is not None and not answer.done():
            answer.set_result(value)
