"""The extensions: hello, the streaming verbs in both forms, and signaling, with an adapter that has streams."""

from typing import Any, Final

from openrois.catalog.actuation import NAVIGATION
from openrois.catalog.streaming import VIDEO_STREAMING
from openrois.types.codes import StreamStatus
from openrois_conformance.application import EVENT, Application
from openrois_conformance.deviation import Deviation, expect, shown
from openrois_conformance.probe import Probe, new_engine_id
from openrois_conformance.probe_engine import Answer, ProbeEngine
from openrois_conformance.probe_streams import NOW, ProbeStreams
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()
BOTH: Final = (Needs.ADAPTER, Needs.EXTENSIONS)

STATUS: Final = "rois.stream.notify_stream_status"
HOLDER: Final = "openrois.holder"
OFFER: Final = "signaling.offer"
VERBS: Final = ("disconnect_stream", "suspend_stream", "resume_stream", "query_stream_status")
MAX_REPORTS: Final = 64
"""More reports of playout than may be made at once, and in the second that the requests may take."""
_UNKNOWN: Final = "conformance-nowhere/0"


async def _streaming(stage: Stage) -> tuple[Probe, ProbeStreams, str]:
    """Attach an adapter with streams; return it, its streams, and its camera."""
    engine_id = new_engine_id()
    camera, wheels = f"{engine_id}/camera", f"{engine_id}/wheels"
    engine = ProbeEngine(engine_id, {camera: VIDEO_STREAMING.profile("camera"), wheels: NAVIGATION.profile("wheels")})
    streams = ProbeStreams(engine)
    engine.extension = streams.answer_request
    return await stage.attached(engine), streams, camera


async def _greeted(stage: Stage) -> Application:
    app = await stage.application()
    await app.granted("openrois.hello", version="1", extensions=["rois.stream", "signaling"])
    return app


async def _connected(app: Application, camera: str) -> str:
    answer = await app.granted("rois.stream.connect_stream", component_ref=camera)
    if not answer["stream_id"]:
        raise Deviation("a stream_id", "an empty one")
    return str(answer["stream_id"])


@CHECKS("hello", Needs.EXTENSIONS)
async def _hello(stage: Stage) -> None:
    """`openrois.hello` is answered with the version, the extensions, and a client_id of this application alone."""
    app, other = await stage.application(), await stage.application()
    answer = await app.granted("openrois.hello", version="1", extensions=["rois.stream", "something.new"])
    expect("the version", answer["version"], "1")
    theirs = await other.granted("openrois.hello", version="2")
    expect("whether two applications have one client_id", answer["client_id"] == theirs["client_id"], False)
    await app.error("openrois.hello", -32602)


@CHECKS("extensions-only-to-who-asked", *BOTH)
async def _extensions_only_to_who_asked(stage: Stage) -> None:
    """Notifications of an extension go to no application that has used none."""
    _, _, camera = await _streaming(stage)
    app = await stage.application()
    unit = {"component_ref": camera, "command_type": "connect_stream", "command_id": "c"}
    await app.granted("rois.command.execute", command_unit_list=[unit])
    expect("how connect_stream completed", await app.completed("c"), {"c": "OK"})
    await app.granted("rois.query.query", query_type="component_status", condition=f"component_ref = '{camera}'")
    await app.silent("it has used no extension")


@CHECKS("stream-life", *BOTH)
async def _stream_life(stage: Stage) -> None:
    """A stream is connected, suspended, resumed and disconnected; each reply comes before the status it causes."""
    _, streams, camera = await _streaming(stage)
    app = await _greeted(stage)
    stream_id = await _connected(app, camera)
    streams.check_owner(stream_id)
    expect("statuses told before the reply", app.left(), [])
    await _told(app, camera, stream_id, "NOT_RUNNING")
    for verb, told, status in (
        ("suspend_stream", ["SUSPENDED"], "SUSPENDED"),
        ("resume_stream", ["RESUMED", "RUNNING"], "RUNNING"),
    ):
        await app.granted(f"rois.stream.{verb}", stream_id=stream_id)
        for each in told:
            await _told(app, camera, stream_id, each)
        answer = await app.granted("rois.stream.query_stream_status", stream_id=stream_id)
        expect("the status", answer["status"], f"STREAMING_{status}")
    await app.granted("rois.stream.disconnect_stream", stream_id=stream_id)
    await _told(app, camera, stream_id, "NOT_CONNECTED")
    for verb in VERBS:
        await app.refused(f"rois.stream.{verb}", "UNSUPPORTED", stream_id=stream_id)
    app.unread.clear()


async def _told(app: Application, camera: str, stream_id: str, status: str) -> None:
    notice = await app.next(STATUS)
    expect("the status told", notice["status"], f"STREAMING_{status}")
    expect("the stream and component", (notice["stream_id"], notice["component_ref"]), (stream_id, camera))
    expect("the time, unchanged from the adapter", notice["timestamp"], NOW)


@CHECKS("stream-refused", *BOTH)
async def _stream_refused(stage: Stage) -> None:
    """`connect_stream` of what has no streams is answered UNSUPPORTED; params that do not fit -32602."""
    app = await _greeted(stage)
    for ref in (stage.ref("eye"), "conformance-nowhere/camera", "", stage.ref("video_streaming")):
        await app.refused("rois.stream.connect_stream", "UNSUPPORTED", component_ref=ref)
    for method, params in (
        ("connect_stream", {}),
        ("connect_stream", {"component_ref": "x", "client_id": "x"}),
        ("connect_stream", {"component_ref": "x", "parameters": None}),
        ("suspend_stream", {"stream_id": 5}),
        ("suspend_stream", {"stream_id": "x", "component_ref": "x"}),
        ("query_stream_status", {}),
    ):
        await app.error(f"rois.stream.{method}", -32602, **params)


@CHECKS("stream-playout", *BOTH)
async def _stream_playout(stage: Stage) -> None:
    """`report_playout` reaches the engine of the stream, from its owner alone; a delay out of bounds is -32602."""
    _, streams, camera = await _streaming(stage)
    app, other = await _greeted(stage), await _greeted(stage)
    stream_id = await _connected(app, camera)
    owner = streams.check_owner(stream_id)
    method = "rois.stream.report_playout"
    await app.granted(method, stream_id=stream_id, milliseconds=150)
    told = {"stream_id": stream_id, "milliseconds": 150, "client_id": owner}
    expect("what the engine is told", streams.reports, [told])
    foreign = await other.ask(method, stream_id=stream_id, milliseconds=150)
    expect("that of a foreign stream", foreign, await other.ask(method, stream_id=_UNKNOWN, milliseconds=150))
    expect("the return_code", foreign["return_code"], "UNSUPPORTED")
    for wrong in (-1, 60_001, 1.5, "150", None):
        await app.error(method, -32602, stream_id=stream_id, milliseconds=wrong)
    expect("what the engine is told", streams.reports, [told])
    app.unread.clear()


@CHECKS("stream-playout-often", *BOTH)
async def _stream_playout_often(stage: Stage) -> None:
    """Playout that is reported too often is OUT_OF_RESOURCES, and the engine is not asked."""
    _, streams, camera = await _streaming(stage)
    app = await _greeted(stage)
    stream_id = await _connected(app, camera)
    params = {"stream_id": stream_id, "milliseconds": 150}
    asked = [await app.begin("rois.stream.report_playout", **params) for _ in range(MAX_REPORTS)]
    codes = [(await app.result("rois.stream.report_playout", each))["return_code"] for each in asked]
    expect("whether some were granted and some refused", set(codes), {"OK", "OUT_OF_RESOURCES"})
    expect("reports that the engine was told", len(streams.reports), codes.count("OK"))
    app.unread.clear()


@CHECKS("stream-of-others", *BOTH)
async def _stream_of_others(stage: Stage) -> None:
    """A stream of another application looks like an absent one, and its owner alone is notified of it."""
    second, _, camera = await _streaming(stage)
    app, other = await _greeted(stage), await _greeted(stage)
    this = f"component_ref = '{camera}'"
    await other.granted("rois.event.subscribe", event_type="notify_stream_status", condition=this)
    stream_id = await _connected(app, camera)
    asked = list(second.asked)
    for verb in VERBS:
        foreign = await other.ask(f"rois.stream.{verb}", stream_id=stream_id)
        expect(f"{verb} of a foreign stream", foreign, await other.ask(f"rois.stream.{verb}", stream_id=_UNKNOWN))
        expect("the return_code", foreign["return_code"], "UNSUPPORTED")
    for verb in VERBS[:3]:
        expect(f"how {verb} of a foreign stream completed", await _ended(other, camera, verb, stream_id), "ERROR")
    condition = f"{this} AND stream_id = '{stream_id}'"
    await other.refused("rois.query.query", "UNSUPPORTED", query_type="get_stream_status", condition=condition)
    expect("what the adapter was asked", second.asked, asked)
    await other.silent("the stream is another's")
    await app.granted("rois.stream.suspend_stream", stream_id=stream_id)
    await other.silent("the stream is another's")
    app.unread.clear()


@CHECKS("stream-strict", *BOTH)
async def _stream_strict(stage: Stage) -> None:
    """The streaming verbs work in strict RoIS: execute, query with stream_id in the condition, subscribe."""
    _, _, camera = await _streaming(stage)
    app = await stage.application()
    subscribed = await app.granted(
        "rois.event.subscribe", event_type="notify_stream_status", condition=f"component_ref = '{camera}'"
    )
    await _verb(app, camera, "connect_stream")
    (result,) = (await app.granted("rois.command.get_command_result", command_id="connect_stream"))["results"]
    expect("the result of connect_stream", result["name"], "stream_id")
    stream_id = result["value"]
    notice = await app.next(EVENT)
    expect(
        "the event",
        (notice["event_type"], notice["subscribe_id"]),
        ("notify_stream_status", subscribed["subscribe_id"]),
    )
    values = {each["name"]: each["value"] for each in notice["results"]}
    expect(
        "the stream and status", (values.get("stream_id"), values.get("status")), (stream_id, "STREAMING_NOT_RUNNING")
    )
    condition = f"component_ref = '{camera}' AND stream_id = '{stream_id}'"
    for verb, status in (("suspend_stream", "SUSPENDED"), ("resume_stream", "RUNNING")):
        await _verb(app, camera, verb, stream_id)
        answer = await app.granted("rois.query.query", query_type="get_stream_status", condition=condition)
        expect("the status", [each["value"] for each in answer["results"]], [f"STREAMING_{status}"])
    await _verb(app, camera, "disconnect_stream", stream_id)
    await app.refused("rois.query.query", "UNSUPPORTED", query_type="get_stream_status", condition=condition)
    app.unread.clear()


async def _ended(app: Application, camera: str, verb: str, stream_id: str | None = None) -> str:
    arguments = [] if stream_id is None else [{"name": "stream_id", "data_type_ref": "String", "value": stream_id}]
    unit = {"component_ref": camera, "command_type": verb, "command_id": verb, "arguments": arguments}
    await app.granted("rois.command.execute", command_unit_list=[unit])
    return (await app.completed(verb))[verb]


async def _verb(app: Application, camera: str, verb: str, stream_id: str | None = None) -> None:
    expect(f"how {verb} completed", await _ended(app, camera, verb, stream_id), "OK")


@CHECKS("stream-which", *BOTH)
async def _stream_which(stage: Stage) -> None:
    """`get_stream_status` without a stream_id in its condition is answered BAD_PARAMETER."""
    _, _, camera = await _streaming(stage)
    app = await _greeted(stage)
    await _connected(app, camera)
    condition = f"component_ref = '{camera}'"
    await app.refused("rois.query.query", "BAD_PARAMETER", query_type="get_stream_status", condition=condition)
    app.unread.clear()


@CHECKS("stream-without-extension", Needs.ADAPTER)
async def _stream_without_extension(stage: Stage) -> None:
    """The streaming verbs of an adapter that speaks the base wire alone are passed on as they are."""
    app = await stage.application()
    camera = stage.ref("video_streaming")
    await _verb(app, camera, "connect_stream")
    unit = stage.probe.last("rois.command.execute")["command_unit_list"][0]
    expect("what the adapter is asked", (unit["component_ref"], unit["command_type"]), (camera, "connect_stream"))
    condition = f"component_ref = '{camera}'"
    await app.granted("rois.query.query", query_type="get_stream_status", condition=condition)
    await app.granted("rois.event.subscribe", event_type="notify_stream_status", condition=condition)


@CHECKS("stream-client-gone", *BOTH)
async def _stream_client_gone(stage: Stage) -> None:
    """An adapter with streams is notified of an application that has disconnected or is gone."""
    second, streams, camera = await _streaming(stage)
    for leave in ("disconnect", "close"):
        app = await _greeted(stage)
        owner = streams.check_owner(await _connected(app, camera))
        if leave == "disconnect":
            await app.granted("rois.system.disconnect")
        else:
            await app.socket.close()
        app.unread.clear()
        await second.until(
            lambda owner=owner: ("openrois.client_gone", {"client_id": owner}) in second.asked,  # type: ignore[misc]
            "say that the application is gone",
        )


@CHECKS("holder", *BOTH)
async def _holder(stage: Stage) -> None:
    """An adapter with streams is notified of the holders of its actuation components, with growing epochs."""
    second, _, _ = await _streaming(stage)
    wheels = second.ref("wheels")
    app, other = await _greeted(stage), await _greeted(stage)

    async def told(count: int) -> dict[str, Any]:
        await second.until(lambda: len(second.params_of(HOLDER)) >= count, "say who holds the component")
        expect("how often it is told", len(second.params_of(HOLDER)), count)
        return second.params_of(HOLDER)[-1]

    await app.granted("rois.command.bind", component_ref=wheels)
    first = await told(1)
    expect("the component, and whether it is held", (first["component_ref"], first["holds"]), (wheels, True))
    await app.granted("rois.command.bind", component_ref=wheels)
    expect("what is told when it is bound once more", await told(2), first)
    await other.refused("rois.command.bind", "OUT_OF_RESOURCES", component_ref=wheels)
    await app.granted("rois.command.release", component_ref=wheels)
    expect("what is told when it is released", await told(3), {**first, "holds": False})
    await other.granted("rois.command.bind", component_ref=wheels)
    theirs = await told(4)
    expect("whether another holder has another client_id", theirs["client_id"] != first["client_id"], True)
    expect("whether the epoch has grown", theirs["epoch"] > first["epoch"], True)
    await other.granted("rois.system.disconnect")
    gone = ("openrois.client_gone", {"client_id": theirs["client_id"]})
    given_back = (HOLDER, {**theirs, "holds": False})
    await second.until(lambda: gone in second.asked or given_back in second.asked, "say that it is held no more")
    for each in (app, other):
        each.unread.clear()


@CHECKS("stream-adapter-lost", *BOTH)
async def _stream_adapter_lost(stage: Stage) -> None:
    """When an adapter is lost its streams are notified to be NOT_CONNECTED, before profile_changed."""
    second, _, camera = await _streaming(stage)
    app = await _greeted(stage)
    stream_id = await _connected(app, camera)
    await _told(app, camera, stream_id, "NOT_RUNNING")
    await app.next(OFFER)
    app.unread.clear()
    await second.socket.close()
    await app.next("rois.system.profile_changed")
    told = [params["status"] for method, params in app.unread if method == STATUS]
    expect("what was told before profile_changed", told, [StreamStatus.STREAMING_NOT_CONNECTED.value])
    app.unread.clear()


@CHECKS("stream-many", *BOTH)
async def _stream_many(stage: Stage) -> None:
    """One application has a bounded number of streams: one more is answered OUT_OF_RESOURCES."""
    _, _, camera = await _streaming(stage)
    app = await _greeted(stage)
    codes = [await app.code("rois.stream.connect_stream", component_ref=camera) for _ in range(17)]
    expect("the return codes", codes, ["OK"] * 16 + ["OUT_OF_RESOURCES"])
    app.unread.clear()


async def _peer(app: Application, camera: str) -> dict[str, Any]:
    stream_id = await _connected(app, camera)
    offer = await app.next(OFFER)
    expect("the stream of the offer", [each["stream_id"] for each in offer["streams"]], [stream_id])
    app.unread.clear()
    return offer


@CHECKS("signaling-relay", *BOTH)
async def _signaling_relay(stage: Stage) -> None:
    """Answers, candidates and restarts reach the adapter as they are, beside the client_id of their application."""
    second, streams, camera = await _streaming(stage)
    app = await _greeted(stage)
    offer = await _peer(app, camera)
    peer_id = offer["peer_id"]
    for method, params in (
        ("answer", {"peer_id": peer_id, "generation": 1, "sdp": "v=0\r\n"}),
        ("candidate", {"peer_id": peer_id, "generation": 1, "candidate": "c", "sdp_mid": "0"}),
        ("candidate", {"peer_id": peer_id, "generation": 1, "candidate": None}),
        ("restart", {"peer_id": peer_id}),
    ):
        await app.granted(f"signaling.{method}", **params)
        asked = dict(second.last(f"signaling.{method}"))
        expect("the client_id", asked.pop("client_id", None), streams.owner)
        expect(f"the params of {method}", asked, params)


@CHECKS("signaling-of-others", *BOTH)
async def _signaling_of_others(stage: Stage) -> None:
    """A peer of another application looks like an absent one."""
    second, _, camera = await _streaming(stage)
    app, other = await _greeted(stage), await _greeted(stage)
    peer_id = (await _peer(app, camera))["peer_id"]
    for each in (peer_id, _UNKNOWN):
        await other.refused("signaling.restart", "UNSUPPORTED", peer_id=each)
        await other.refused("signaling.answer", "UNSUPPORTED", peer_id=each, generation=1, sdp="v=0")
        candidate = {"peer_id": each, "generation": 1, "candidate": "c", "sdp_mid": "0"}
        await other.refused("signaling.candidate", "UNSUPPORTED", **candidate)
    asked = [method for method, _ in second.asked if method.startswith("signaling.")]
    expect("what the adapter was asked", asked, [])
    await app.granted("signaling.restart", peer_id=peer_id)


@CHECKS("signaling-capture-clocks", *BOTH)
async def _signaling_capture_clocks(stage: Stage) -> None:
    """`signaling.capture_clocks` reaches the application that has the peer."""
    second, streams, camera = await _streaming(stage)
    app = await _greeted(stage)
    clock = {"mid": "0", "ssrc": 2**32 - 1, "clock_rate": 90_000, "rtp_origin": 0, "wall": 1_800_000_000_000}
    told = {"peer_id": (await _peer(app, camera))["peer_id"], "senders": [clock]}
    await second.send_notification("signaling.capture_clocks", client_id=streams.owner, **told)
    expect("the capture times", await app.next("signaling.capture_clocks"), told)


@CHECKS("signaling-bye", *BOTH)
async def _signaling_bye(stage: Stage) -> None:
    """`signaling.bye` reaches the application with its reason, and the peer is unknown afterwards."""
    second, streams, camera = await _streaming(stage)
    app = await _greeted(stage)
    peer_id = (await _peer(app, camera))["peer_id"]
    await second.send_notification("signaling.bye", client_id=streams.owner, peer_id=peer_id, reason="enough")
    expect("the bye", await app.next("signaling.bye"), {"peer_id": peer_id, "reason": "enough"})
    await app.refused("signaling.restart", "UNSUPPORTED", peer_id=peer_id)


@CHECKS("signaling-misfit", Needs.EXTENSIONS)
async def _signaling_misfit(stage: Stage) -> None:
    """Signaling params that do not fit are answered -32602."""
    app = await _greeted(stage)
    for method, params in (
        ("answer", {"peer_id": "x", "generation": 1}),
        ("answer", {"peer_id": "x", "generation": "1", "sdp": "v=0"}),
        ("candidate", {"peer_id": "x", "generation": 1, "candidate": "c"}),
        ("restart", {}),
        ("ice_servers", {"x": 1}),
    ):
        await app.error(f"signaling.{method}", -32602, **params)


@CHECKS("signaling-ice-servers", Needs.EXTENSIONS)
async def _signaling_ice_servers(stage: Stage) -> None:
    """`signaling.ice_servers` gives a list of servers with their URLs, and how long it holds."""
    app = await _greeted(stage)
    answer = await app.granted("signaling.ice_servers")
    for server in answer["ice_servers"]:
        if not isinstance(server.get("urls"), list) or not server["urls"]:
            raise Deviation("urls of every server", shown(server))


@CHECKS("hello-adapter", *BOTH)
async def _hello_adapter(stage: Stage) -> None:
    """The gateway sends openrois.hello to an adapter once, after the profile; one that answers -32601 is served."""
    second = await stage.attached()
    methods = [method for method, _ in second.asked]
    expect("what the adapter was asked", methods, ["rois.system.get_profile", "openrois.hello"])
    older = await stage.adapter()
    older.engine.answers["openrois.hello"] = Answer({"return_code": "UNSUPPORTED"})
    await stage.until_there(older.ref("eye"))
