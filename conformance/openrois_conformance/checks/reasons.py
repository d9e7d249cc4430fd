"""The extension `openrois.reason`: why a request is refused or a command fails, and nothing of other applications."""

from typing import Any, Final

from openrois_conformance.application import Application
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

_UNKNOWN: Final = "conformance-nowhere/0"
_ALWAYS_REFUSED: Final = (
    ("rois.command.bind", "UNSUPPORTED", {"component_ref": _UNKNOWN}),
    ("rois.command.search", "BAD_PARAMETER", {"condition": "what?"}),
    ("rois.command.get_command_result", "BAD_PARAMETER", {"command_id": "none"}),
    ("rois.query.query", "UNSUPPORTED", {"query_type": "conformance_nothing"}),
    ("rois.event.get_event_detail", "BAD_PARAMETER", {"event_id": _UNKNOWN}),
    ("rois.stream.suspend_stream", "UNSUPPORTED", {"stream_id": _UNKNOWN}),
)


async def _greeted(stage: Stage) -> Application:
    app = await stage.application()
    await app.granted("openrois.hello", version="1")
    return app


async def _refused(app: Application, method: str, code: str, params: dict[str, Any]) -> str:
    """Send a request that is refused and return the reason."""
    request_id = await app.begin(method, **params)
    expect(f"the return_code of {method}", (await app.result(method, request_id))["return_code"], code)
    return _reason(app, request_id)


def _reason(app: Application, subject: str) -> str:
    if subject not in app.reasons:
        raise Deviation(f"openrois.reason for {subject}", shown(sorted(app.reasons)))
    return app.reasons[subject]


@CHECKS("reason-refused", Needs.EXTENSIONS)
async def _reason_refused(stage: Stage) -> None:
    """The reason stands right before a reply that is a refusal, in one line of at most 500 characters."""
    app = await _greeted(stage)
    for method, code, params in _ALWAYS_REFUSED:
        await _refused(app, method, code, params)
    begun = [
        await app.begin("rois.command.bind", component_ref=f"conformance-nowhere/{number}") for number in range(64)
    ]
    for request_id in begun:
        await app.response(request_id)
        _reason(app, request_id)
    await app.silent("reasons apart")


@CHECKS("reason-base", Needs.EXTENSIONS)
async def _reason_base(stage: Stage) -> None:
    """A client that has used no extension gets the reply alone."""
    app = await stage.application()
    for method, code, params in _ALWAYS_REFUSED:
        if not method.startswith("rois.stream"):
            await app.refused(method, code, **params)
    expect("reasons", app.reasons, {})


@CHECKS("reason-failed", Needs.ADAPTER, Needs.EXTENSIONS)
async def _reason_failed(stage: Stage) -> None:
    """The reason stands right before `completed` of a failed command, and of those that follow it and do not run."""
    app, eye = await _greeted(stage), stage.ref("eye")
    commands = {"first": "fail", "after": "echo"}
    units = [{"component_ref": eye, "command_type": kind, "command_id": each} for each, kind in commands.items()]
    await app.granted("rois.command.execute", command_unit_list=units)
    expect("how they completed", await app.completed(*commands), {"first": "ERROR", "after": "ABORT"})
    for command_id in commands:
        _reason(app, command_id)


@CHECKS("reason-hops", Needs.ADAPTER, Needs.EXTENSIONS)
async def _reason_hops(stage: Stage) -> None:
    """The reason of an adapter for the end of a command reaches the application."""
    app, eye = await _greeted(stage), stage.ref("eye")
    unit = {"component_ref": eye, "command_type": "hang", "command_id": "c"}
    await app.granted("rois.command.execute", command_unit_list=[unit])
    await stage.probe.hangs(eye)
    for command_id in stage.probe.engine.hanging()[eye]:
        await stage.probe.send_notification("openrois.reason", command_id=command_id, reason="the eye is shut")
    await stage.probe.finish(eye, "ERROR")
    expect("how it completed", await app.completed("c"), {"c": "ERROR"})
    expect("the reason", _reason(app, "c"), "the eye is shut")


@CHECKS("reason-secret", Needs.ADAPTER, Needs.EXTENSIONS)
async def _reason_secret(stage: Stage) -> None:
    """A component of another application and an absent one are refused with the same sentence."""
    app, other = await _greeted(stage), await _greeted(stage)
    unit = {"component_ref": stage.ref("eye"), "command_type": "echo", "command_id": "theirs"}
    await other.granted("rois.command.execute", command_unit_list=[unit])
    expect("how it completed", await other.completed("theirs"), {"theirs": "OK"})
    method = "rois.command.get_command_result"
    said = {each: await _refused(app, method, "BAD_PARAMETER", {"command_id": each}) for each in ("theirs", "unknown")}
    expect("the reason", said["theirs"].replace(stage.sent_id("theirs"), "unknown"), said["unknown"])
