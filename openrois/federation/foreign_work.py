"""What an application has at other gateways that has to be ended here when one of them is lost. Pure."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from openrois.aio.bounded_history import BoundedHistory
from openrois.errors import BadParameter, OutOfResources
from openrois.types.codes import StreamStatus
from openrois.types.leases import LeaseChangedNotification, LeaseRequestedNotification, LeaseState
from openrois.types.reasons import ReasonNotification
from openrois.types.streams import StreamStatusNotification

__all__ = ["ForeignWork", "Lost"]

MAX_RUNNING: Final = 4096
"""Commands of one application that run at other gateways; each of these has a limit of its own for them."""

MAX_KEPT: Final = 4096
"""Commands that have ended, and requests for components, whose gateway is remembered."""

_ENDED: Final = StreamStatus.STREAMING_NOT_CONNECTED.value


@dataclass(frozen=True, slots=True)
class Lost:
    """What an application had at a gateway that was lost.

    Attributes:
        commands: the component of each command that had not ended, by its id.
        streams: the component of each stream, by its id.
    """

    commands: Mapping[str, str]
    streams: Mapping[str, str]


class ForeignWork:
    """Commands, streams and requests of one application, and the gateway where each of them is."""

    def __init__(self) -> None:
        self._running: dict[str, tuple[str, str]] = {}
        self._streams: dict[str, tuple[str, str]] = {}
        self._held: dict[str, None] = {}
        self._finished: BoundedHistory[str] = BoundedHistory(MAX_KEPT)
        self._requests: BoundedHistory[str] = BoundedHistory(MAX_KEPT)

    @property
    def held(self) -> frozenset[str]:
        """The components at other gateways that the application has bound, as far as it was told."""
        return frozenset(self._held)

    def note_held(self, component_ref: str, *, is_held: bool) -> None:
        """Note that the application has bound a component at another gateway, or has it no more."""
        if is_held:
            self._held[component_ref] = None
            if len(self._held) > MAX_KEPT:
                del self._held[next(iter(self._held))]
        else:
            self._held.pop(component_ref, None)

    def __contains__(self, command_id: str) -> bool:
        return command_id in self._running

    def begin(self, gateway_id: str, commands: Mapping[str, str]) -> None:
        """Note commands before a gateway is asked to run them.

        Args:
            gateway_id: the gateway.
            commands: the component of each, by its id.

        Raises:
            BadParameter: one of the ids is taken.
            OutOfResources: too many run.
        """
        for command_id in commands:
            if command_id in self._running or command_id in self._finished:
                raise BadParameter(f"the command_id {command_id[:200]!r} is empty or taken")
        if len(self._running) + len(commands) > MAX_RUNNING:
            raise OutOfResources(f"one application has at most {MAX_RUNNING} commands at other gateways")
        self._running.update({command_id: (gateway_id, ref) for command_id, ref in commands.items()})

    def give_up(self, command_ids: Iterable[str]) -> None:
        """Drop commands that were not accepted."""
        for command_id in command_ids:
            self._running.pop(command_id, None)

    def gateway_of_command(self, command_id: str) -> str | None:
        """Return the gateway that runs a command, or has run it; None where that is not known."""
        running = self._running.get(command_id)
        return self._finished.get(command_id) if running is None else running[0]

    def gateway_of_request(self, request_id: str) -> str | None:
        """Return the gateway at which a component was requested; None where that is not known."""
        return self._requests.get(request_id)

    def note_stream(self, gateway_id: str, stream_id: str, component_ref: str) -> None:
        """Note a stream that was connected."""
        self._streams[stream_id] = gateway_id, component_ref

    @property
    def running(self) -> int:
        """The number of commands that run at other gateways."""
        return len(self._running)

    def adopt(self, gateway_id: str, command_ids: Iterable[str]) -> None:
        """Note commands of a session in whose place this one goes on."""
        self._running.update(dict.fromkeys(command_ids, (gateway_id, "")))

    def note_notification(self, gateway_id: str, method: str, params: Mapping[str, Any]) -> bool:
        """Note what a notification of a gateway says of commands, streams and requests.

        Returns:
            Whether it goes on to the application: a command has one end, and what was lost has had it.
        """
        if method == "rois.command.completed":
            command_id = str(params.get("command_id"))
            if self._running.pop(command_id, None) is None:
                return False
            self._finished.put(command_id, gateway_id, ())
        elif method == ReasonNotification.method and "command_id" in params:
            return params["command_id"] in self._running
        elif method == LeaseRequestedNotification.method:
            request_id = params.get("request_id")
            if isinstance(request_id, str):
                self._requests.put(request_id, gateway_id, ())
        elif method == LeaseChangedNotification.method:
            self.note_held(str(params.get("component_ref")), is_held=params.get("state") == LeaseState.MINE.value)
        elif method == StreamStatusNotification.method and params.get("status") == _ENDED:
            self._streams.pop(str(params.get("stream_id")), None)
        return True

    def lose(self, gateway_id: str) -> Lost:
        """Drop what the application has at a gateway, and return it."""
        commands = {key: ref for key, (where, ref) in self._running.items() if where == gateway_id}
        streams = {key: ref for key, (where, ref) in self._streams.items() if where == gateway_id}
        for command_id in commands:
            del self._running[command_id]
        for stream_id in streams:
            del self._streams[stream_id]
        return Lost(commands, streams)
