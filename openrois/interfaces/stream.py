"""The Streaming interface (clause 8.2.2.5), as methods of its own and behind execute, query and subscribe.

Both forms end in the same calls of the engine's extension. A stream belongs to the session that connected it: to every
other it looks like one that does not exist.
"""

import time
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final, TypeVar

from pydantic import ValidationError

from openrois.aio.rate import RateLimit
from openrois.errors import (
    Aborted,
    BadParameter,
    ComponentFailed,
    EngineUnreachable,
    NotResponding,
    OutOfResources,
    RoISError,
    Unsupported,
    error_for,
)
from openrois.interfaces.operation import reply_first, shared_operation
from openrois.interfaces.stream_rights import consent_stated, require_right, use_stated
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.scope.revocation import Entitlements, end_streams
from openrois.session.session import ApplicationSession, forget_stream
from openrois.session.stream_parameters import STREAM_PARAMETERS
from openrois.session.stream_rights import StreamRight
from openrois.types.codes import ReturnCode, StreamStatus
from openrois.types.directory import DIRECTORY
from openrois.types.leases import LEASES
from openrois.types.messages import Argument, CommandUnit, Parameter, Result, ReturnResult
from openrois.types.references import engine_of
from openrois.types.streams import (
    EXTENSIONS,
    STREAM_METHODS,
    ConnectStreamParams,
    ConnectStreamResult,
    HelloParams,
    HelloResult,
    ReportPlayoutParams,
    SetConsentParams,
    SetConsentResult,
    StreamParams,
    StreamStatusResult,
    subject_of,
)

__all__ = ["get_parameters", "has_streams", "is_verb", "methods", "query_status", "run_verb"]

MAX_STREAMS: Final = 16

REPORTS_PER_SECOND: Final = 8
"""Reports of playout that one application may make, for all of its streams."""

REPORTS_AT_ONCE: Final = 16

_SET_PARAMETER: Final = "set_parameter"

Outcome = TypeVar("Outcome", bound=ReturnResult)


def has_streams(app: ApplicationSession, component_ref: str) -> bool:
    """Tell whether the component's engine has the streaming methods and tells applications about their own streams."""
    return app.engine.has_streams(engine_of(component_ref))


def is_verb(command_type: str) -> bool:
    """Tell whether a command of a streaming component is about the streams of the application that sends it."""
    return command_type in STREAM_METHODS or command_type == _SET_PARAMETER


class _Streams:
    """The operations of one application."""

    __slots__ = ("_reports", "app")

    def __init__(self, app: ApplicationSession) -> None:
        self.app = app
        self._reports = RateLimit(REPORTS_AT_ONCE, REPORTS_PER_SECOND, time.monotonic)

    async def say_hello(self, params: HelloParams) -> HelloResult:
        app = self.app
        app.extended = True
        app.leasing = app.leasing or LEASES in params.extensions
        if DIRECTORY in params.extensions:
            # Each entry of the directory says whether its engine has streams.
            app.change_notice.name_engines()
            engines: tuple[str, ...] = ()
        else:
            engines = tuple(sorted(app.engine.extension.engines()))
        return HelloResult(client_id=app.client_id, extensions=(*EXTENSIONS, DIRECTORY, LEASES), engines=engines)

    async def connect(self, params: ConnectStreamParams) -> ConnectStreamResult:
        self.app.extended = True
        return ConnectStreamResult(stream_id=await connect_stream(self.app, params.component_ref, params.parameters))

    async def query_status(self, params: StreamParams) -> StreamStatusResult:
        self.app.extended = True
        return StreamStatusResult(status=await query_status(self.app, params.stream_id))

    async def report_playout(self, params: ReportPlayoutParams) -> ReturnResult:
        self.app.extended = True
        _require_own(self.app, params.stream_id)
        if not self._reports.admits():
            raise OutOfResources(f"playout is reported at most {REPORTS_PER_SECOND} times a second")
        await _call(self.app, "rois.stream.report_playout", params.model_dump(mode="json"), ReturnResult)
        return ReturnResult()

    async def set_consent(self, params: SetConsentParams) -> SetConsentResult:
        self.app.extended = True
        _require_own(self.app, params.stream_id)
        result = await _call(self.app, "rois.stream.set_consent", params.model_dump(mode="json"), SetConsentResult)
        detail = f"{params.stream_id} {consent_stated(params.consent)}"
        self.app.host.audit.acted(
            self.app.principal, "rois.stream.set_consent", self.app.streams.get(params.stream_id, ""), detail
        )
        return SetConsentResult(visitor_ref=result.visitor_ref)


def _acting(verb: str) -> Callable[[_Streams, StreamParams], Awaitable[ReturnResult]]:
    async def act(streams: _Streams, params: StreamParams) -> ReturnResult:
        streams.app.extended = True
        await act_on_stream(streams.app, verb, params.stream_id)
        return ReturnResult()

    return act


_VERBS: Final[Mapping[str, SharedMethod]] = {
    STREAM_METHODS["connect_stream"]: shared_operation(ConnectStreamParams, ConnectStreamResult, _Streams.connect),
    **{
        STREAM_METHODS[verb]: shared_operation(StreamParams, ReturnResult, _acting(verb))
        for verb in ("disconnect_stream", "suspend_stream", "resume_stream")
    },
    "rois.stream.query_stream_status": shared_operation(StreamParams, StreamStatusResult, _Streams.query_status),
}
_METHODS: Final[Mapping[str, SharedMethod]] = {
    "openrois.hello": shared_operation(HelloParams, HelloResult, _Streams.say_hello),
    "rois.stream.report_playout": shared_operation(ReportPlayoutParams, ReturnResult, _Streams.report_playout),
    "rois.stream.set_consent": shared_operation(SetConsentParams, SetConsentResult, _Streams.set_consent),
    **{name: reply_first(method) for name, method in _VERBS.items()},
}


def methods(app: ApplicationSession) -> BoundMethods:
    """Return the methods: `openrois.hello` and `rois.stream.*`."""
    return BoundMethods((_METHODS, _Streams(app)))


async def connect_stream(app: ApplicationSession, component_ref: str, parameters: tuple[Parameter, ...]) -> str:
    """Connect a stream of a component and return its id.

    Raises:
        Unsupported: there is no such component, or it has no streams.
        OutOfResources: this application, or its subject, has too many.
        Aborted: the application has left.
        RoISError: the engine refused.
    """
    app.engine.require(component_ref)
    if app.closed:
        raise Aborted("the application is gone")
    if len(app.streams) + app.connecting >= MAX_STREAMS:
        raise OutOfResources(f"one application has at most {MAX_STREAMS} streams")
    app.host.quotas.require_stream(app)
    right = require_right(app, component_ref, parameters)
    params: dict[str, Any] = {
        "component_ref": component_ref,
        "parameters": [p.model_dump(mode="json") for p in parameters],
    }
    if ice_servers := app.host.ice_servers(engine_of(component_ref)):
        # The other end of the stream needs them as much as the application does.
        params["ice_servers"] = list(ice_servers)
    if not app.principal.may_call("rois.command.bind"):
        # The adapter knows no principals, and keeps places for applications that may bind.
        params["may_bind"] = False
    if right.role is not None:
        params["role"] = right.role.value
    client, bus = app.client, app.engine.route(component_ref)
    app.connecting += 1
    app.host.quotas.note_streams(app)
    try:
        result = await _call(app, STREAM_METHODS["connect_stream"], params, ConnectStreamResult)
    finally:
        app.connecting -= 1
        app.host.quotas.note_streams(app)
    if app.client is not client:
        # It left while the stream was made, and has been forgotten already: that has to be said again.
        await app.engine.extension.forget_client(client)
        raise Aborted("the application has left")
    try:
        right = _require_still(app, component_ref, parameters)
    except RoISError:
        await end_streams(app.host.engine, (result.stream_id,), client)
        raise
    if not app.engine.leads_to(component_ref, bus):
        # Notifications of the stream have no receiver any more; the engine ends it after a while.
        raise EngineUnreachable("the connection to the engine ended while the stream was made")
    if not app.engine.leads_alike(result.stream_id, component_ref):
        raise ComponentFailed(f"the engine minted the stream_id {result.stream_id[:200]!r}, which is not its own")
    app.streams[result.stream_id] = component_ref
    app.stream_rights.note_stream(result.stream_id, component_ref, right)
    detail = f"{result.stream_id} {use_stated(right, parameters)}".rstrip()
    app.host.audit.acted(app.principal, STREAM_METHODS["connect_stream"], component_ref, detail)
    return result.stream_id


def _require_still(app: ApplicationSession, component_ref: str, parameters: tuple[Parameter, ...]) -> StreamRight:
    """Return by which right the application may have the stream that was made meanwhile.

    Raises:
        RoISError: it has none any more, or the component is out of scope by now.
    """
    if Entitlements(app.principal).lost_streams({"": component_ref}):
        raise Unsupported(f"there is no component {component_ref[:200]!r}")
    return require_right(app, component_ref, parameters)


async def act_on_stream(app: ApplicationSession, verb: str, stream_id: str) -> None:
    """Suspend, resume or disconnect a stream of this application.

    Raises:
        Unsupported: it has no such stream.
        RoISError: the engine refused.
    """
    _require_own(app, stream_id)
    await _call(app, STREAM_METHODS[verb], {"stream_id": stream_id}, ReturnResult)
    if verb == "disconnect_stream":
        forget_stream(app, stream_id)


async def query_status(app: ApplicationSession, stream_id: str, component_ref: str | None = None) -> StreamStatus:
    """Return the status of a stream of this application.

    Args:
        app: the session of the application.
        stream_id: the stream.
        component_ref: the component it must be a stream of, if the question names one.

    Raises:
        Unsupported: it has no such stream.
        RoISError: the engine did not answer.
    """
    _require_own(app, stream_id, component_ref)
    result = await _call(app, "rois.stream.query_stream_status", {"stream_id": stream_id}, StreamStatusResult)
    return result.status


async def run_verb(app: ApplicationSession, unit: CommandUnit) -> tuple[Result, ...]:
    """Run a streaming verb that came as a command unit.

    Raises:
        BadParameter: the stream_id is missing.
        RoISError: as the verb's own function.
    """
    if unit.command_type == _SET_PARAMETER:
        return await _set_parameters(app, unit)
    if unit.command_type == "connect_stream":
        seen = await get_parameters(app, unit.component_ref)
        chosen = tuple(parameter for parameter in seen if parameter.name in STREAM_PARAMETERS)
        stream_id = await connect_stream(app, unit.component_ref, chosen)
        return (Result(name="stream_id", data_type_ref="string", value=stream_id),)
    stream_id = next((argument.value for argument in unit.arguments if argument.name == "stream_id"), "")
    if not stream_id:
        raise BadParameter(f"{unit.command_type} needs the argument stream_id")
    _require_own(app, stream_id, unit.component_ref)
    await act_on_stream(app, unit.command_type, stream_id)
    return ()


async def get_parameters(app: ApplicationSession, component_ref: str) -> tuple[Parameter, ...]:
    """Return the parameters of a component as this application sees them.

    Raises:
        RoISError: the component did not answer.
    """
    stored = await app.engine.query(component_ref, "get_parameter")
    return app.stream_parameters.over(component_ref, stored)


async def _set_parameters(app: ApplicationSession, unit: CommandUnit) -> tuple[Result, ...]:
    """Change the parameters of a component; those that are about streams to come are this application's alone."""
    profile = app.engine.components.get(unit.component_ref)
    own: tuple[Argument, ...] = ()
    if profile is not None and profile.command("connect_stream") is not None:
        own = tuple(argument for argument in unit.arguments if argument.name in STREAM_PARAMETERS)
    others = tuple(argument for argument in unit.arguments if argument not in own)
    if others or not own:
        await app.engine.invoke(unit.component_ref, _SET_PARAMETER, others)
    if own and profile is not None:
        app.stream_parameters.keep(unit.component_ref, profile, own)
    return ()


def _require_own(app: ApplicationSession, stream_id: str, component_ref: str | None = None) -> None:
    owner = app.streams.get(stream_id)
    if owner is None or component_ref not in (None, owner):
        raise Unsupported(f"there is no stream {stream_id[:200]!r}")


async def _call(app: ApplicationSession, method: str, params: Mapping[str, Any], model: type[Outcome]) -> Outcome:
    try:
        answer = await app.engine.extension.call(method, params, app.client)
    except NotResponding as silence:
        raise app.engine.blame(app.streams.get(subject_of(params), ""), silence) from None
    try:
        result = model.read(answer)
    except ValidationError as error:
        raise ComponentFailed(f"the engine's answer to {method} is malformed") from error
    if result.return_code is not ReturnCode.OK:
        raise error_for(result.return_code, f"the engine refused {method}")
    return result
