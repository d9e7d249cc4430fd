"""The queue for each part, and which requests in it still wait for the holder's answer. Pure."""

from dataclasses import dataclass
from typing import Final

from openrois.errors import OutOfResources

__all__ = ["MAX_WAITING", "Request", "Waiting"]

MAX_WAITING: Final = 16
"""Applications that may wait for one component, or one part of a body."""


@dataclass(eq=False, slots=True)
class Request:
    """An application wants a component that another one holds, and with it its part.

    Attributes:
        request_id: by which the holder answers it.
        part: the part that is wanted.
        component_ref: the component of it that the application has named.
        asker: the session that wants it.
        deadline: until when the holder may answer; None once it has, or did not in time.
    """

    request_id: str
    part: str
    component_ref: str
    asker: object
    deadline: float | None


class Waiting:
    """The queues of all parts: first come, first in line."""

    def __init__(self) -> None:
        self._queues: dict[str, list[Request]] = {}
        self._by_id: dict[str, Request] = {}

    def count(self) -> int:
        """Return how many requests wait."""
        return len(self._by_id)

    def add(self, request: Request) -> None:
        """Put a request at the end of the queue of its part.

        Raises:
            OutOfResources: as many as can be wait already.
        """
        queue = self._queues.setdefault(request.part, [])
        if len(queue) >= MAX_WAITING:
            raise OutOfResources(f"{MAX_WAITING} applications wait for {request.component_ref} already")
        queue.append(request)
        self._by_id[request.request_id] = request

    def get(self, request_id: str) -> Request | None:
        """Return a request that waits, by its id."""
        return self._by_id.get(request_id)

    def queue(self, part: str) -> tuple[Request, ...]:
        """Return the requests for a part, the first in the queue first."""
        return tuple(self._queues.get(part, ()))

    def of(self, asker: object) -> tuple[Request, ...]:
        """Return every request of `asker`."""
        return tuple(request for request in self._by_id.values() if request.asker is asker)

    def find(self, part: str, asker: object) -> Request | None:
        """Return the request of `asker` for a part."""
        return next((request for request in self.queue(part) if request.asker is asker), None)

    def remove(self, request: Request) -> None:
        """Remove a request from its queue."""
        queue = self._queues[request.part]
        queue.remove(request)
        if not queue:
            del self._queues[request.part]
        del self._by_id[request.request_id]

    def unanswered(self) -> tuple[Request, ...]:
        """Return the requests that wait for an answer of the holder."""
        return tuple(request for request in self._by_id.values() if request.deadline is not None)
