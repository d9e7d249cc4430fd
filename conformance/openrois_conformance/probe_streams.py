"""Streams without media: the answers of an adapter of the suite to the methods of the extensions."""

from dataclasses import dataclass, field
from typing import Any, Final

from openrois_conformance.deviation import Deviation
from openrois_conformance.probe_engine import Answer, Notices, ProbeEngine

__all__ = ["NOW", "ProbeStreams"]

NOW: Final = "2026-11-21T00:00:00+00:00"
"""The time of every status that is notified."""
_VERBS = {
    "rois.stream.disconnect_stream": ("NOT_CONNECTED",),
    "rois.stream.suspend_stream": ("SUSPENDED",),
    "rois.stream.resume_stream": ("RESUMED", "RUNNING"),
}


@dataclass
class ProbeStreams:
    """The streams of one engine.

    Attributes:
        engine: mints their ids.
        owner: the client_id of the application that connected a stream last.
        reports: the params of each report of playout.
    """

    engine: ProbeEngine
    owner: str = ""
    reports: list[dict[str, Any]] = field(default_factory=list)
    _streams: dict[str, dict[str, str]] = field(default_factory=dict)

    def answer_request(self, method: str, params: dict[str, Any]) -> Answer | None:
        """Return the answer to a method of an extension, or None where there is no such method."""
        if method == "openrois.hello":
            return Answer({"return_code": "OK", "version": "1", "extensions": ["rois.stream", "signaling"]})
        if method == "rois.stream.connect_stream":
            return self._connect(params)
        if method == "rois.stream.query_stream_status":
            return Answer({"return_code": "OK", "status": self._streams[params["stream_id"]]["status"]})
        if method == "rois.stream.report_playout":
            self.reports.append(params)
            return Answer({"return_code": "OK"})
        if method in _VERBS:
            return Answer({"return_code": "OK"}, then=self._move(params["stream_id"], *_VERBS[method]))
        return Answer({"return_code": "OK"}) if method.startswith("signaling.") else None

    def check_owner(self, stream_id: str) -> str:
        """Return the client_id of the application that a stream was connected for.

        Raises:
            Deviation: the gateway did not say whose it is, or changed the stream's id.
        """
        stream = self._streams.get(stream_id)
        if stream is None:
            raise Deviation("the stream_id that the adapter minted", stream_id)
        if not stream["client_id"]:
            raise Deviation("the gateway to say whose stream it is", "no client_id")
        return stream["client_id"]

    def _connect(self, params: dict[str, Any]) -> Answer:
        stream_id, peer_id = self.engine.mint("stream"), self.engine.mint("peer")
        self.owner = params.get("client_id", "")
        stream = {"client_id": self.owner, "component_ref": params["component_ref"], "status": ""}
        self._streams[stream_id] = stream
        section = {"mid": "0", "stream_id": stream_id, "component_ref": params["component_ref"]}
        offer = {
            "client_id": self.owner,
            "peer_id": peer_id,
            "generation": 1,
            "sdp": "v=0",
            "streams": [{**section, "kind": "video", "direction": "recvonly"}],
        }
        notices = (*self._move(stream_id, "NOT_RUNNING"), ("signaling.offer", offer))
        return Answer({"return_code": "OK", "stream_id": stream_id}, then=notices)

    def _move(self, stream_id: str, *statuses: str) -> Notices:
        stream = self._streams[stream_id]
        told = []
        for status in (f"STREAMING_{status}" for status in statuses):
            if status != "STREAMING_RESUMED":
                stream["status"] = status
            notice = {**stream, "stream_id": stream_id, "status": status, "timestamp": NOW}
            told.append(("rois.stream.notify_stream_status", notice))
        return tuple(told)
