"""An event as it is told: written once for all who listen, since only the id of the subscription differs. Pure."""

from openrois.jsonrpc.protocol import encode
from openrois.types.messages import Result

__all__ = ["EventText"]


class EventText:
    """The params of `rois.event.notify_event` but for the id of a subscription."""

    __slots__ = ("_before", "_behind")

    def __init__(self, event_id: str, event_type: str, expire: str, results: tuple[Result, ...]) -> None:
        self._before = encode({"event_id": event_id, "event_type": event_type})[:-1] + ',"subscribe_id":'
        self._behind = "," + encode({"expire": expire, "results": results})[1:]

    def told_to(self, subscription: str) -> str:
        """Return the params for one subscription, whose id is given as JSON text."""
        return f"{self._before}{subscription}{self._behind}"
