"""The connection and request that the running task works for: part of every log line and audit record of it. Pure."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final

__all__ = ["connection", "correlation", "request", "serve"]

_LONGEST: Final = 40
"""Characters of a request's id that are shown; the other side chose it."""

_connection: ContextVar[str] = ContextVar("connection", default="")

request: Final[ContextVar[str | float | None]] = ContextVar("request", default=None)
"""The id of the request that is being served. Tasks that it starts have it too."""


@contextmanager
def connection(name: str) -> Iterator[None]:
    """Let the block, and the tasks that it starts, work for the connection `name`."""
    before = _connection.set(name)
    try:
        yield
    finally:
        _connection.reset(before)


def serve(request_id: str | float | None) -> None:
    """Let the task work for a request. Of a long id no more is kept than is shown: what it starts may run for days."""
    request.set(request_id[:_LONGEST] if isinstance(request_id, str) else request_id)


def correlation() -> str:
    """Return `connection/request`, only `connection` outside of requests, and nothing outside of connections."""
    name, request_id = _connection.get(), request.get()
    return name if request_id is None else f"{name}/{str(request_id)[:_LONGEST]}"
