"""State of one stream of an application: what it is wanted to be, what it is, and the next verb. Pure.

Times are seconds of one monotonic clock, and arguments.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Final

from openrois.transport.backoff import Backoff
from openrois.types.codes import StreamStatus

__all__ = ["Desire", "Failure", "Problem", "StreamState", "Verb", "next_verb"]

_FIRST_RETRY: Final = 1.0
_RETRY_FACTOR: Final = 2.0
_LONGEST_RETRY: Final = 15.0


class Desire(Enum):
    """What the application wants a stream to be."""

    RUNNING = "running"
    SUSPENDED = "suspended"
    DISCONNECTED = "disconnected"


class Verb(Enum):
    """Operations of the Streaming Interface (RoIS 2.0, table 8.6), by their names."""

    CONNECT = "connect_stream"
    SUSPEND = "suspend_stream"
    RESUME = "resume_stream"
    DISCONNECT = "disconnect_stream"


class Failure(Enum):
    """Why a verb has failed."""

    NO_CONNECTION = "no connection"
    """To the gateway; all verbs are tried again on the next one."""
    UNSUPPORTED = "unsupported"
    """The engine has no such stream, or no such component."""
    REFUSED = "refused"


@dataclass(frozen=True, slots=True)
class Problem:
    """What keeps a stream from running.

    Attributes:
        detail: one sentence.
        error: what the engine has answered; None where it has not refused.
    """

    detail: str
    error: Exception | None = None


def next_verb(desire: Desire, *, connected: bool, suspended: bool) -> Verb | None:
    """Return the next verb towards the desired state; None when it is reached."""
    if desire is Desire.DISCONNECTED:
        return Verb.DISCONNECT if connected else None
    if not connected:
        return Verb.CONNECT
    if desire is Desire.SUSPENDED:
        return None if suspended else Verb.SUSPEND
    return Verb.RESUME if suspended else None


class StreamState:
    """State of one stream.

    Attributes:
        desire: what the application wants it to be.
        stream_id: the engine's id of this connection of the stream; None while there is none.
        status: the newest status that was reported; None without a connection to the gateway.
        problem: what keeps it from running; None for nothing.
        connected_at: when it was connected.
        retry_at: when the next verb may be tried, after a failure; None for now.
    """

    def __init__(self) -> None:
        self.desire = Desire.DISCONNECTED
        self.stream_id: str | None = None
        self.status: StreamStatus | None = StreamStatus.STREAMING_NOT_CONNECTED
        self.problem: Problem | None = None
        self.connected_at = 0.0
        self.retry_at: float | None = None
        self._suspended = False
        self._backoff = _new_backoff()

    @property
    def pending(self) -> Verb | None:
        """The next verb, whenever it may be tried; None when the desired state is reached."""
        return next_verb(self.desire, connected=self.stream_id is not None, suspended=self._suspended)

    def due(self, now: float) -> Verb | None:
        """Return the verb to be tried now."""
        return None if self.retry_at is not None and now < self.retry_at else self.pending

    def want(self, desire: Desire) -> None:
        """Change the desired state; it is tried at once."""
        self.desire = desire
        if desire is Desire.RUNNING and self.status is StreamStatus.STREAMING_SUSPENDED and self.stream_id is not None:
            # The engine may have suspended it.
            self._suspended = True
        self._backoff = _new_backoff()
        self.retry_at = None

    def retry_now(self) -> None:
        """Let what has failed be tried at once: there is a reason to."""
        self.retry_at = None

    def flowed(self) -> None:
        """Note that media flows: the next failure is a first one."""
        self._backoff = _new_backoff()

    def connected(self, stream_id: str, now: float) -> None:
        """Note that the stream is connected."""
        self.stream_id, self._suspended = stream_id, False
        self.status = StreamStatus.STREAMING_NOT_RUNNING
        self.problem, self.connected_at = None, now

    def performed(self, verb: Verb, stream_id: str) -> None:
        """Note that a verb on a connected stream was carried out."""
        if self.stream_id == stream_id:
            self._suspended = verb is Verb.SUSPEND

    def release(self) -> None:
        """Forget the connection, which is being disconnected: whatever the answer, its id is not used again."""
        self.stream_id, self._suspended, self.problem = None, False, None
        self.status = StreamStatus.STREAMING_NOT_CONNECTED

    def failed(self, verb: Verb, failure: Failure, problem: Problem, now: float) -> None:
        """Note that a verb has failed; another attempt follows, at once where there is a new connection first."""
        if verb is Verb.DISCONNECT or failure is Failure.NO_CONNECTION:
            self.retry_at = None if verb is Verb.DISCONNECT else self._retry(now)
            return
        if verb is Verb.CONNECT:
            self.problem = problem
        elif failure is Failure.UNSUPPORTED:
            self.lost(StreamStatus.STREAMING_NOT_CONNECTED, now)
            return
        self.retry_at = self._retry(now)

    def reported(self, status: StreamStatus, now: float) -> None:
        """Note a status that the engine has reported."""
        if status is StreamStatus.STREAMING_NOT_CONNECTED:
            self.lost(status, now)
            return
        # RESUMED is an event; the state that follows it is RUNNING.
        resumed = status is StreamStatus.STREAMING_RESUMED
        self.status = StreamStatus.STREAMING_RUNNING if resumed else status
        if self.pending is not None:
            # A stream that could not be suspended before it ran can be now.
            self.retry_at = None

    def lost(self, status: StreamStatus | None, now: float) -> bool:
        """Note that the stream is not connected any more, None: unknown; returns whether it was."""
        self.status = status
        if self.stream_id is None:
            return False
        self.stream_id, self._suspended = None, False
        self.retry_at = self._retry(now)
        return True

    def expects_media(self, *, flowed: bool) -> bool:
        """Whether media should be flowing: connected, wanted, and running or about to for the first time.

        An engine whose source has stopped reports NOT_RUNNING, and nothing is wrong with the path.

        Args:
            flowed: whether media has flowed over the present path.
        """
        if self.stream_id is None or self.desire is not Desire.RUNNING:
            return False
        running = self.status is StreamStatus.STREAMING_RUNNING
        return running or (self.status is StreamStatus.STREAMING_NOT_RUNNING and not flowed)

    def _retry(self, now: float) -> float:
        return now + self._backoff.after(0.0)


def _new_backoff() -> Backoff:
    return Backoff(_FIRST_RETRY, _RETRY_FACTOR, _LONGEST_RETRY)
