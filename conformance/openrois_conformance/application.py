"""An application that is nothing but a WebSocket: it speaks raw JSON and judges every message it receives."""

import json
from typing import Any, Final

from websockets.asyncio.client import ClientConnection

from openrois.types.profiles import HRIEngineProfile
from openrois_conformance.command_ids import CommandIds
from openrois_conformance.connection import Connection
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.strictness import (
    check_envelope,
    explained_by,
    is_extension,
    read_notification,
    read_result,
)
from openrois_conformance.transcript import Transcript

__all__ = ["Application"]

COMPLETED: Final = "rois.command.completed"
EVENT: Final = "rois.event.notify_event"
REASON: Final = "openrois.reason"


class Application(Connection):
    """One connection of an application.

    Args:
        socket: the open connection.
        name: what it is called in the transcript.
        transcript: keeps what is said.
        patience: seconds to wait for anything.
        ids: of the commands of the check.

    Attributes:
        unread: the notifications that no check has awaited yet: method and params, in order.
        reasons: why something was refused or failed, by the request's id or the command's.
    """

    def __init__(
        self, socket: ClientConnection, name: str, transcript: Transcript, patience: float, ids: CommandIds
    ) -> None:
        super().__init__(socket, name, transcript, patience)
        self._ids = ids
        self.unread: list[tuple[str, dict[str, Any]]] = []
        self.reasons: dict[Any, str] = {}
        self.extended = False
        self._explained: dict[str, Any] | None = None
        self._asked: set[str] = set()
        self._answers: dict[str, dict[str, Any]] = {}
        self._ended: set[str] = set()
        self._last_id = 0

    async def hear(self) -> dict[str, Any]:
        """Return the next frame, checked: a response as it came, a notification kept in `unread` as well."""
        message: dict[str, Any] = await self.receive()
        check_envelope(message)
        told, self._explained = self._explained, None
        if told is not None:
            explained = explained_by(told, message)
            self.reasons[self._ids.written(explained) if isinstance(explained, str) else explained] = told["reason"]
        if "method" in message:
            params = read_notification(message["method"], message.get("params", {}), extended=self.extended)
            if message["method"] == REASON:
                self._explained = params
                return await self.hear()
            params = self._ids.incoming(params)
            self._count(message["method"], params)
            self.unread.append((message["method"], params))
        return message

    def _count(self, method: str, params: dict[str, Any]) -> None:
        if method == COMPLETED:
            if params["command_id"] in self._ended:
                raise Deviation(f"one `completed` for the command {params['command_id']}", "a second one")
            self._ended.add(params["command_id"])

    async def begin(self, method: str, **params: Any) -> str:
        """Send a request and return its id."""
        self._last_id += 1
        request_id = f"req-{self._last_id}"
        self.expect_answer_to(request_id)
        self.extended = self.extended or is_extension(method)
        await self.send({"jsonrpc": "2.0", "id": request_id, "method": method, "params": self._ids.outgoing(params)})
        return request_id

    def expect_answer_to(self, request_id: Any) -> None:
        """Note that a request with this id was or will be sent."""
        self._asked.add(json.dumps(request_id))

    async def response(self, request_id: Any) -> dict[str, Any]:
        """Return the response to a request, whatever comes before it."""
        wanted = json.dumps(request_id)
        while wanted not in self._answers:
            message = await self.hear()
            if "method" not in message:
                self._file(message)
        return self._answers.pop(wanted)

    def _file(self, message: dict[str, Any]) -> None:
        key = json.dumps(message["id"])
        if key not in self._asked:
            raise Deviation("one answer to each request, with its id unchanged", shown(message))
        self._asked.discard(key)
        self._answers[key] = message

    async def answer_to(self, raw: Any) -> dict[str, Any]:
        """Send one frame and return the response that comes next, whatever its id."""
        await self.send(raw)
        while "method" in (message := await self.hear()):
            pass
        return message

    async def result(self, method: str, request_id: str) -> dict[str, Any]:
        """Return the result of a request of `method`, checked."""
        response = await self.response(request_id)
        if "result" not in response:
            raise Deviation(f"a result of {method}", shown(response))
        return self._ids.incoming(read_result(method, response["result"]))

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Send a request and return its result, checked and with every field."""
        return await self.result(method, await self.begin(method, **params))

    async def code(self, method: str, **params: Any) -> str:
        """Send a request and return its return code."""
        return str((await self.ask(method, **params))["return_code"])

    async def granted(self, method: str, **params: Any) -> dict[str, Any]:
        """Send a request that has to be answered OK and return the result."""
        result = await self.ask(method, **params)
        expect(f"the return_code of {method}", result["return_code"], "OK")
        return result

    async def tree(self) -> HRIEngineProfile:
        """Return the tree of engines in the gateway's profile."""
        profile = (await self.granted("rois.system.get_profile"))["profile"]
        if profile is None:
            raise Deviation("a profile of the engine", "null")
        return HRIEngineProfile.model_validate(profile)

    async def refused(self, method: str, *codes: str, **params: Any) -> dict[str, Any]:
        """Send a request that has to be answered with one of `codes` and empty out parameters; return the result."""
        result = await self.ask(method, **params)
        expect(f"the return_code of {method}", result["return_code"], *codes)
        left = {name: value for name, value in result.items() if name != "return_code" and value}
        if left and set(left) != {"status"}:
            raise Deviation(f"the out parameters of a refused {method} to be empty", shown(left))
        return result

    async def error(self, method: str, *codes: int, **params: Any) -> dict[str, Any]:
        """Send a request that has to be answered with a JSON-RPC error of one of `codes` and return the error."""
        response = await self.response(await self.begin(method, **params))
        if "error" not in response:
            raise Deviation(f"the error {' or '.join(map(str, codes))}", shown(response))
        error: dict[str, Any] = response["error"]
        expect("the error's code", error["code"], *codes)
        return error

    async def next(self, method: str) -> dict[str, Any]:
        """Return the params of the next notification of `method`; those of other methods stay in `unread`."""
        while True:
            for index, (name, params) in enumerate(self.unread):
                if name == method:
                    del self.unread[index]
                    return params
            message = await self.hear()
            if "method" not in message:
                self._file(message)

    async def completed(self, *command_ids: str) -> dict[str, str]:
        """Wait until commands have completed and return how; no other may complete meanwhile."""
        ended: dict[str, str] = {}
        while set(ended) != set(command_ids):
            notice = await self.next(COMPLETED)
            if notice["command_id"] not in command_ids:
                raise Deviation(f"`completed` of {', '.join(command_ids)} only", shown(notice))
            ended[notice["command_id"]] = notice["status"]
        return ended

    def left(self) -> list[str]:
        """Return the methods of unexpected notifications; changes of the tree are always allowed."""
        return [method for method, _ in self.unread if method != "rois.system.profile_changed"]

    def drop_notifications(self, method: str) -> None:
        """Drop the unexpected notifications of `method`."""
        self.unread = [(name, params) for name, params in self.unread if name != method]

    async def settled(self) -> list[str]:
        """Send a harmless request and return the unexpected notifications up to its answer."""
        await self.ask("rois.command.search", condition="component_ref = ''")
        return self.left()

    async def silent(self, why: str) -> None:
        """Refuse any unexpected notification up to now."""
        if await self.settled():
            raise Deviation(f"no notification: {why}", shown(self.unread))
