"""The session of an application at another gateway, as the gateway that the application is connected to has it."""

import logging
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

from openrois.aio.lean_queue import LeanQueue
from openrois.errors import ComponentFailed, EngineUnreachable, NotResponding, Unsupported
from openrois.federation.counts import Counts
from openrois.jsonrpc import protocol
from openrois.jsonrpc.session import (
    CALL_TIMEOUT,
    InvalidParams,
    NotificationHandler,
    Reply,
    RpcError,
    RpcSession,
    SessionClosed,
)
from openrois.transport.stream import MessageStream, StreamClosed
from openrois.types.directory import DirectoryChangedNotification
from openrois.types.reasons import ReasonNotification, sentence

__all__ = ["SubSession", "UnwritableParams"]

_log = logging.getLogger(__name__)

ANSWER_TIMEOUT: Final = CALL_TIMEOUT + 1.0
"""Seconds that the other gateway has for an answer: a little longer than it waits for an adapter itself."""

MAX_REFS: Final = 4096
"""Components of one sub-session that are remembered as those which the application works with."""

_EVENTS: Final = frozenset({"rois.event.notify_event", "rois.system.notify_error"})
_OF_HERE: Final = frozenset({"rois.system.profile_changed", DirectoryChangedNotification.method})
"""Notifications that the gateway of the application sends itself, about all engines."""


class UnwritableParams(Exception):
    """Params that came and cannot be sent on: they fit no method."""


class _LastLine:
    """The reason of a refusal; of several the last one counts."""

    __slots__ = ("text",)

    def __init__(self) -> None:
        self.text = ""

    def keep(self, line: str) -> None:
        self.text = line


class SubSession:
    """One application's session at one other gateway.

    What comes back goes on in its order: a reply that has been read leaves before the notifications behind it.

    Args:
        gateway_id: of the other gateway.
        stream: to it.
        notify: sends the application a notification: method, params, `droppable`, `dispensable`.
        seen: sees each notification, and tells whether it goes on.
        counts: of what is asked.

    Attributes:
        gateway_id: of the other gateway.
        refs: the components there that the application works with.
    """

    def __init__(
        self,
        gateway_id: str,
        stream: MessageStream,
        notify: Callable[..., None],
        seen: Callable[[str, Mapping[str, Any]], bool],
        counts: Counts,
    ) -> None:
        self.gateway_id = gateway_id
        self.refs: dict[str, None] = {}
        self._stream = stream
        self._notify = notify
        self._seen = seen
        self._calls = counts.calls
        self._unsent = 0
        self._held = LeanQueue[tuple[str, Mapping[str, Any]]]()
        self._reason: Mapping[str, Any] | None = None
        self._session = RpcSession(
            stream,
            notifications=_Relayed(self),
            call_timeout=ANSWER_TIMEOUT,
            call_latencies=counts.latencies,
            peer=f"gateway {gateway_id}",
        )

    async def run(self) -> StreamClosed:
        """Serve until the stream ends; return why it did."""
        return await self._session.run()

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """End the session at the other gateway."""
        await self._session.close(code, reason)

    def abort(self) -> None:
        """End it as a lost connection does, for the other gateway too."""
        self._stream.abort()

    def note_ref(self, component_ref: str) -> None:
        """Note that the application works with a component there."""
        self.refs[component_ref] = None
        if len(self.refs) > MAX_REFS:
            del self.refs[next(iter(self.refs))]

    def post(self, method: str, params: Mapping[str, Any]) -> None:
        """Ask the other gateway something whose answer does not matter, behind all that was asked before."""
        self._session.post(method, dict(params))

    def send_notification(self, method: str, params: Mapping[str, Any]) -> None:
        """Send the other gateway a notification, behind all that was asked before."""
        self._session.notify(method, dict(params))

    async def relay(
        self,
        method: str,
        params: Mapping[str, Any],
        *,
        urgent: bool = False,
        accepted: Callable[[Mapping[str, Any]], None] = lambda _result: None,
    ) -> Reply:
        """Ask the other gateway what the application asks, and return its reply for the application.

        Args:
            method: as the application named it.
            params: as they came.
            urgent: whether it is asked also where there is no room for questions.
            accepted: called with the result before any later message of the other gateway is read.

        Raises:
            InvalidParams: the params do not fit.
            UnwritableParams: likewise; the session here can say what is wrong.
            RoISError: the other gateway was lost, or did not answer in time or properly.
        """
        line = _LastLine()

        def note_result(result: Any) -> Any:
            if isinstance(result, dict):
                accepted(result)
            # The reply to the application is put as soon as this call returns; what is read until then waits for it.
            self._unsent += 1
            return result

        result = await self._call(method, params, urgent=urgent, on_result=note_result, on_reason=line.keep)
        return Reply(result, self._sent, line.text)

    async def ask(
        self,
        method: str,
        params: Mapping[str, Any],
        *,
        timeout: float | None = None,
        urgent: bool = False,
        accepted: Callable[[Mapping[str, Any]], None] = lambda _result: None,
    ) -> tuple[dict[str, Any], str]:
        """Ask the other gateway something for a reply that is made here; return its result and the reason in it.

        Args:
            method: what is asked.
            params: of it.
            timeout: seconds to wait at most.
            urgent: whether it is asked also where there is no room for questions.
            accepted: called with the result before any later message of the other gateway is read.

        Raises:
            RoISError: the other gateway was lost, or did not answer in time or properly.
        """
        line = _LastLine()

        def note_result(result: Any) -> Any:
            if isinstance(result, dict):
                accepted(result)
            return result

        result = await self._call(
            method, params, timeout=timeout, urgent=urgent, on_result=note_result, on_reason=line.keep
        )
        if not isinstance(result, dict):
            raise ComponentFailed(f"gateway {self.gateway_id} answers {method} with what is no object")
        return result, line.text

    async def _call(self, method: str, params: Mapping[str, Any], **more: Any) -> Any:
        try:
            result = await self._session.call(method, dict(params), **more)
        except ValueError:
            # JSON has been read that cannot be written, such as 1e999.
            raise UnwritableParams from None
        except TimeoutError:
            self._calls["late"] += 1
            raise NotResponding(f"gateway {self.gateway_id} did not answer {method} in time") from None
        except SessionClosed as closed:
            self._calls["lost"] += 1
            raise EngineUnreachable(f"gateway {self.gateway_id}, which has the engine, was lost: {closed}") from closed
        except RpcError as error:
            if error.code == protocol.INVALID_PARAMS and isinstance(error.data, list):
                self._calls["answered"] += 1
                raise InvalidParams(error.data) from None
            self._calls["refused"] += 1
            if error.code == protocol.METHOD_NOT_FOUND:
                raise Unsupported(f"gateway {self.gateway_id} is of an older version, without {method}") from None
            raise ComponentFailed(f"gateway {self.gateway_id} refused {method} with the error {error.code}") from error
        self._calls["answered"] += 1
        return result

    def _sent(self) -> None:
        self._unsent = max(0, self._unsent - 1)
        while self._held and not self._unsent:
            self._pass_on(*self._held.pop())

    def take_notification(self, name: str, params: Mapping[str, Any]) -> None:
        """Take a notification of the other gateway, and pass it on in its turn."""
        if name == ReasonNotification.method and "request_id" in params:
            notice = ReasonNotification.read_newer(params)
            self._session.handle_reason(notice.request_id, sentence(notice.reason))
        elif self._unsent:
            self._held.put((name, params))
        else:
            self._pass_on(name, params)

    def _pass_on(self, name: str, params: Mapping[str, Any]) -> None:
        if name == ReasonNotification.method:
            # It stands right before what it explains: nothing of this gateway comes between them.
            self._reason = params
            return
        reason, self._reason = self._reason, None
        if reason is not None and self._seen(ReasonNotification.method, reason):
            self._notify(ReasonNotification.method, reason, dispensable=True)
        if self._seen(name, params):
            self._notify(name, params, droppable=name in _EVENTS)


class _Relayed(Mapping[str, NotificationHandler]):
    """Handlers of whatever the other gateway notifies: it is about the application, which knows what it asked for."""

    def __init__(self, sub: SubSession) -> None:
        self._sub = sub

    def __getitem__(self, name: str) -> NotificationHandler:
        if name in _OF_HERE:
            raise KeyError(name)
        return lambda params: self._sub.take_notification(name, params)

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0
