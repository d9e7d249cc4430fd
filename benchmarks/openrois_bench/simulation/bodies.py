"""Scripted bodies: adapters of 17 components that answer the wire and do nothing else."""

import asyncio
import json
from collections import Counter
from collections.abc import Callable
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.transport.stream import StreamClosed
from openrois_bench.gateway.fleet.stubs import body_name, body_profile
from openrois_bench.simulation.door import Door, PeerStream
from openrois_bench.simulation.mix import COMMAND_SECONDS

__all__ = ["BURST", "BURST_EVENT", "BURST_SOURCE", "EVENT", "EVENT_SOURCE", "MOVING", "SDP", "Body"]

EVENT_SOURCE: Final = "person_detecter"
EVENT: Final = "person_detected"

BURST_SOURCE: Final = "face_detecter"
BURST_EVENT: Final = "face_detected"
"""An event that happens in bursts alone."""

BURST: Final = 32
"""Events of a burst."""


MOVING: Final = "navigation"
"""The component whose commands want signs of life while they run."""

RESTART_SECONDS: Final = 1.0
"""How long an adapter that restarts is away."""

SDP: Final = "v=0\r\n" + "a=candidate:1 1 udp 2130706431 192.0.2.1 50000 typ host\r\n" * 50
"""Stands for a session description: three thousand characters, which no gateway reads."""

_GOING_AWAY: Final = 1001

_HELLO: Final = (
    '{"return_code":"OK","version":"1","extensions":["rois.stream","signaling","openrois.lease"],"engines":[]}'
)
_STATUS: Final = '{"return_code":"OK","results":[{"name":"status","data_type_ref":"Component_Status","value":"READY"}]}'
_OK: Final = '{"return_code":"OK"}'
_EVENT: Final = "rois.event.notify_event"
_TIME: Final = "2027-01-15T08:00:00.000000+00:00"
_RESULTS: Final = (
    {"name": "number", "data_type_ref": "int", "value": "1"},
    {"name": "timestamp", "data_type_ref": "DateTime", "value": _TIME},
)


class Body:
    """One body.

    Args:
        number: of the body.
        gateway: where it dials.
        rate: events a second while there is a subscription.
        counts: what happened, by name; shared.
        tasks: owns what the body does.

    Attributes:
        attached: set while the gateway has it in its tree.
    """

    def __init__(self, number: int, gateway: Door, rate: float, counts: Counter[str], tasks: TaskScope) -> None:
        self.engine_id = body_name(number)
        self.gateway = gateway
        self.attached = asyncio.Event()
        self._rate = rate
        self._counts = counts
        self._tasks = tasks
        self._minted = 0
        self._subscriptions: dict[str, None] = {}
        self._burst_subscriptions: dict[str, None] = {}
        self._ticking: asyncio.Task[None] | None = None
        self._stream: PeerStream | None = None
        self._answers: dict[str, Callable[[dict[str, Any]], str]] = {
            "rois.system.get_profile": lambda _params: body_profile(self.engine_id),
            "openrois.hello": lambda _params: _HELLO,
            "rois.query.query": lambda _params: _STATUS,
            "rois.command.execute": self._execute,
            "rois.event.subscribe": self._subscribe,
            "rois.event.unsubscribe": self._unsubscribe,
            "rois.stream.connect_stream": self._connect_stream,
            "rois.stream.disconnect_stream": self._disconnect_stream,
            "signaling.answer": self._start_stream,
            "signaling.candidate": lambda _params: _OK,
        }

    async def run(self) -> None:
        """Be attached, and dial again whenever the connection has ended."""
        while True:
            self._stream = await self.gateway.dial_adapter(self.engine_id)
            try:
                while True:
                    await self._take(await self._stream.receive())
            except StreamClosed:
                self._subscriptions.clear()
                self._burst_subscriptions.clear()
                self._stop_ticking()
            await asyncio.sleep(RESTART_SECONDS)

    async def restart(self) -> None:
        """Close the connection in good order, and wait until the body is attached again."""
        assert self._stream is not None
        self.attached.clear()
        await self._stream.close(_GOING_AWAY, "the adapter restarts")
        await self.attached.wait()
        self._counts["restarts"] += 1

    async def be_lost(self) -> None:
        """End the connection as a process that is killed does, and wait until the body is attached again."""
        assert self._stream is not None
        self.attached.clear()
        self._stream.abort()
        await self.attached.wait()
        self._counts["losses"] += 1

    async def move(self, seconds: float) -> None:
        """Want signs of life for a while."""
        await self._tell("openrois.watch", {"wanted": True})
        await asyncio.sleep(seconds)
        await self._tell("openrois.watch", {"wanted": False})

    async def burst(self) -> None:
        """Announce events at once, to those that are subscribed to bursts."""
        for subscribe_id in tuple(self._burst_subscriptions):
            self._counts["burst events"] += BURST
            await self._tell(_EVENT, *(self._event(subscribe_id, BURST_EVENT) for _ in range(BURST)))

    async def _take(self, text: str) -> None:
        message = json.loads(text)
        method = message["method"]
        if "id" in message:
            result = self._answers[method](message["params"])
            assert self._stream is not None
            await self._stream.send(f'{{"jsonrpc":"2.0","id":{message["id"]},"result":{result}}}')
        elif method == "openrois.attached":
            self._counts["attached"] += 1
            self.attached.set()
        elif method == "openrois.alive":
            self._counts["signs of life"] += 1

    def _mint(self) -> str:
        self._minted += 1
        return f"{self.engine_id}/{self._minted:08x}"

    async def _tell(self, method: str, *params: dict[str, Any]) -> None:
        """Send notifications at once."""
        told = f'{{"jsonrpc":"2.0","method":"{method}","params":'
        try:
            assert self._stream is not None
            await self._stream.send_many([f"{told}{json.dumps(each)}}}" for each in params])
        except StreamClosed:
            # It restarts meanwhile.
            self._counts["lost with an adapter"] += 1

    def _execute(self, params: dict[str, Any]) -> str:
        for unit in params["command_unit_list"]:
            self._tasks.start(self._carry_out(unit["component_ref"], unit["command_id"]))
        return _OK

    async def _carry_out(self, component_ref: str, command_id: str) -> None:
        if component_ref.endswith(MOVING):
            await self.move(COMMAND_SECONDS)
        else:
            await asyncio.sleep(COMMAND_SECONDS)
        await self._tell("rois.command.completed", {"command_id": command_id, "status": "OK"})

    def _subscribe(self, params: dict[str, Any]) -> str:
        subscribe_id = self._mint()
        subscriptions = self._subscriptions if params["event_type"] == EVENT else self._burst_subscriptions
        subscriptions[subscribe_id] = None
        if self._subscriptions and self._ticking is None:
            self._ticking = self._tasks.start(self._announce())
        return json.dumps({"return_code": "OK", "subscribe_id": subscribe_id})

    def _unsubscribe(self, params: dict[str, Any]) -> str:
        self._subscriptions.pop(params["subscribe_id"], None)
        self._burst_subscriptions.pop(params["subscribe_id"], None)
        if not self._subscriptions:
            self._stop_ticking()
        return _OK

    def _stop_ticking(self) -> None:
        if self._ticking is not None:
            self._ticking.cancel()
            self._ticking = None

    async def _announce(self) -> None:
        while True:
            await asyncio.sleep(1 / self._rate)
            for subscribe_id in tuple(self._subscriptions):
                self._counts["events"] += 1
                await self._tell(_EVENT, self._event(subscribe_id, EVENT))

    def _event(self, subscribe_id: str, event_type: str) -> dict[str, Any]:
        event = {"event_id": self._mint(), "event_type": event_type, "subscribe_id": subscribe_id}
        return {**event, "expire": "", "results": _RESULTS}

    def _connect_stream(self, params: dict[str, Any]) -> str:
        stream_id = self._mint()
        self._tasks.start(self._offer(stream_id, params["component_ref"], params["client_id"]))
        return json.dumps({"return_code": "OK", "stream_id": stream_id})

    async def _offer(self, stream_id: str, component_ref: str, client_id: str) -> None:
        await asyncio.sleep(0)
        # A peer connection is named as its stream is, so that an answer says which stream it starts.
        section = {"mid": "0", "stream_id": stream_id, "component_ref": component_ref, "kind": "video"}
        offer = {"generation": 1, "sdp": SDP, "streams": [{**section, "direction": "recvonly"}]}
        peer = {"peer_id": stream_id, "client_id": client_id}
        await self._tell("signaling.offer", {**peer, **offer})
        for number in range(2):
            candidate = {"generation": 1, "candidate": f"candidate:{number} 1 udp 1 192.0.2.1 50000 typ host"}
            await self._tell("signaling.candidate", {**peer, **candidate, "sdp_mid": "0"})

    def _start_stream(self, params: dict[str, Any]) -> str:
        self._tasks.start(self._tell_status(params["peer_id"], params["client_id"], "STREAMING_RUNNING"))
        return _OK

    def _disconnect_stream(self, params: dict[str, Any]) -> str:
        self._tasks.start(self._tell_status(params["stream_id"], params["client_id"], "STREAMING_NOT_CONNECTED"))
        return _OK

    async def _tell_status(self, stream_id: str, client_id: str, status: str) -> None:
        await asyncio.sleep(0)
        names = {"stream_id": stream_id, "component_ref": f"{self.engine_id}/video_streaming", "client_id": client_id}
        await self._tell("rois.stream.notify_stream_status", {**names, "status": status, "timestamp": _TIME})
        if status == "STREAMING_NOT_CONNECTED":
            await self._tell(
                "signaling.bye", {"peer_id": stream_id, "client_id": client_id, "reason": "its stream ended"}
            )
