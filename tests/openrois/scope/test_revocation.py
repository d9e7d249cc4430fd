"""A scope or a role that shrinks: what is out of it is lost at once, and the rest goes on."""

import asyncio
import json
from typing import Any

import pytest

from openrois.auth.principal import Principal
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.errors import Unsupported
from openrois.gateway.token_expiry import TokenExpiry
from openrois.scope.revocation import Entitlements
from openrois.types.codes import ErrorType, StreamStatus
from openrois.types.references import new_id
from tests.openrois.interfaces.test_matrix import condition, unit
from tests.support.authorization import Place, Wire, place, principal

KEPT, LOST = "kept", "lost"


def test_claims() -> None:
    operator, viewer = Entitlements(principal("operator", "kept/*")), Entitlements(principal("viewer", "kept/*"))
    refs = ["kept/arm", "lost/arm"]
    assert (operator.lost_bindings(refs), viewer.lost_bindings(refs)) == (["lost/arm"], refs)
    streams = {"kept/1": "kept/camera", "lost/1": "lost/camera"}
    maintenance = Entitlements(principal("maintenance", "kept/*"))
    assert (viewer.lost_streams(streams), maintenance.lost_streams(streams)) == (["lost/1"], list(streams))
    assert [each.loses_subscription("kept/arm") for each in (viewer, Entitlements(principal(None, "*")))] == [
        False,
        True,
    ]
    assert viewer.loses_subscription("lost/arm")


class Holder:
    """An application that has one of everything of an engine that it keeps and of one that it will lose."""

    def __init__(self, where: Place, wire: Wire, expiry: TokenExpiry) -> None:
        self.where, self.wire, self.expiry = where, wire, expiry
        self.streams: dict[str, str] = {}
        self.events: dict[str, str] = {}
        self.errors: dict[str, str] = {}

    async def take(self, engine_id: str) -> None:
        wire, part = self.wire, self.where.robots[engine_id].robot
        await wire.result("openrois.hello", {"version": "1"})
        assert await wire.code("rois.command.bind", {"component_ref": part.ref("Navigation")}) == "OK"
        connected = await wire.result("rois.stream.connect_stream", {"component_ref": part.ref("VideoStreaming")})
        self.streams[engine_id] = connected["stream_id"]
        where = condition(part.ref("PersonDetection"))
        assert await wire.code("rois.event.subscribe", {"event_type": "person_detected", "condition": where}) == "OK"
        part.parts["PersonDetection"].tell("person_detected")
        self.events[engine_id] = (await wire.until("rois.event.notify_event"))["event_id"]
        command = unit(part.ref("PersonDetection"), "stop") | {"command_id": engine_id}
        assert await wire.code("rois.command.execute", {"command_unit_list": [command]}) == "OK"
        assert await wire.completed(engine_id) == "OK"
        self.where.host.engine.report(ErrorType.USER_DEFINED_ERROR, "it says so", part.ref("Navigation"))
        self.errors[engine_id] = (await wire.until("rois.system.notify_error"))["error_id"]

    async def has(self, engine_id: str) -> dict[str, bool]:
        """Tell what of an engine it still has, by asking for it."""
        asked: dict[str, tuple[str, dict[str, Any]]] = {
            "stream": ("rois.stream.query_stream_status", {"stream_id": self.streams[engine_id]}),
            "event": ("rois.event.get_event_detail", {"event_id": self.events[engine_id]}),
            "result": ("rois.command.get_command_result", {"command_id": engine_id}),
            "error": ("rois.system.get_error_detail", {"error_id": self.errors[engine_id]}),
        }
        return {name: await self.wire.code(*question) == "OK" for name, question in asked.items()}


EVERYTHING, NOTHING = (dict.fromkeys(("stream", "event", "result", "error"), each) for each in (True, False))


@pytest.fixture
async def holder() -> Any:
    expiry = TokenExpiry(principal("operator", "kept/*", "lost/*"))
    async with place(KEPT, LOST) as where, where.application(expiry) as wire:
        made = Holder(where, wire, expiry)
        for engine_id in (KEPT, LOST):
            await made.take(engine_id)
        yield made


async def test_what_leaves_the_scope_is_lost_and_the_rest_is_not(holder: Holder) -> None:
    where, wire = holder.where, holder.wire
    assert (await holder.has(KEPT), await holder.has(LOST)) == (EVERYTHING, EVERYTHING)
    holder.expiry.replace(principal("operator", "kept/*"))
    told = await wire.until("rois.stream.notify_stream_status", lambda told: told["stream_id"] == holder.streams[LOST])
    assert told["status"] == "STREAMING_NOT_CONNECTED"
    await wire.until("rois.system.profile_changed")
    assert (await holder.has(KEPT), await holder.has(LOST)) == (EVERYTHING, NOTHING)
    profile = json.dumps(await wire.result("rois.system.get_profile", {}))
    assert "lost" not in profile
    # Behind the gateway it is over, too, and free for others.
    assert where.robots[LOST].streams.streams == {}
    assert list(where.robots[KEPT].streams.streams) == [holder.streams[KEPT]]
    for engine_id in (KEPT, LOST):
        where.robots[engine_id].robot.parts["PersonDetection"].tell("person_detected", number=7)
        where.host.engine.report(ErrorType.USER_DEFINED_ERROR, "again", where.robots[engine_id].robot.ref("Navigation"))
    frames = [json.loads(frame) for frame in await wire.ask("rois.command.search", {})]
    heard = [(frame["method"], next(iter(frame["params"].values())).partition("/")[0]) for frame in frames[:-1]]
    assert heard == [("rois.event.notify_event", KEPT), ("rois.system.notify_error", "gateway")]
    async with where.application(principal("operator", "*")) as other:
        navigation = {each: where.robots[each].robot.ref("Navigation") for each in (KEPT, LOST)}
        assert await other.code("rois.command.bind", {"component_ref": navigation[KEPT]}) == "OUT_OF_RESOURCES"
        assert await other.code("rois.command.bind", {"component_ref": navigation[LOST]}) == "OK"


async def test_a_peer_of_an_engine_out_of_sight_is_ended(holder: Holder) -> None:
    calls = holder.where.robots[LOST].streams.calls
    holder.expiry.replace(principal("operator", "kept/*"))
    await holder.wire.until("rois.system.profile_changed")
    await holder.wire.code("rois.command.search", {})
    assert {"rois.stream.disconnect_stream", "signaling.bye"} <= {method for method, _, _ in calls}


@pytest.mark.parametrize(("role", "binds", "streams"), [("viewer", False, True), ("maintenance", False, False)])
async def test_what_a_lesser_role_may_not_have(holder: Holder, role: str, binds: bool, streams: bool) -> None:
    where, wire = holder.where, holder.wire
    holder.expiry.replace(principal(role, "kept/*", "lost/*"))
    if not streams:
        for _ in holder.streams:
            await wire.until("rois.stream.notify_stream_status")
    expected = EVERYTHING | {"stream": streams}
    assert (await holder.has(KEPT), await holder.has(LOST)) == (expected, expected)
    async with where.application(principal("operator", "*")) as other:
        free = await other.code("rois.command.bind", {"component_ref": where.robots[KEPT].robot.ref("Navigation")})
        assert free == ("OUT_OF_RESOURCES" if binds else "OK")


async def test_a_wider_scope_takes_nothing_and_shows_more() -> None:
    expiry = TokenExpiry(principal("operator", "kept/*"))
    async with place(KEPT, LOST) as where, where.application(expiry) as wire:
        holder = Holder(where, wire, expiry)
        await holder.take(KEPT)
        expiry.replace(principal("operator", "*"))
        await wire.until("rois.system.profile_changed")
        assert await holder.has(KEPT) == EVERYTHING
        assert len((await wire.result("rois.command.search", {}))["component_ref_list"]) == 2 * len(BASIC_COMPONENTS)


async def test_commands_whose_turn_has_not_come_do_not_run(holder: Holder) -> None:
    """The rest of a sequence, where its component is out of scope by then, or its application may run nothing."""
    where, wire = holder.where, holder.wire
    follow = {each: where.robots[each].robot for each in (KEPT, LOST)}
    for lesser in (principal("operator", "kept/*"), principal("viewer", "kept/*")):
        holder.expiry.replace(principal("operator", "*"))
        await wire.result("rois.command.bind", {"component_ref": follow[KEPT].ref("Follow")})
        doomed = LOST if "operator" in lesser.roles else KEPT
        refs = follow[KEPT].ref("PersonDetection"), follow[doomed].ref("FaceDetection")
        sequence = [unit(ref, "stop") for ref in refs]
        gate = asyncio.Event()
        stop = _delayed(follow[KEPT], gate)
        where.reached()
        assert await wire.code("rois.command.execute", {"command_unit_list": sequence}) == "OK"
        holder.expiry.replace(lesser)
        gate.set()
        assert await wire.completed(sequence[0]["command_id"]) == "OK"
        assert await wire.completed(sequence[1]["command_id"]) == "ERROR"
        assert ("invoke", refs[1]) not in where.reached()
        stop()


def _delayed(robot: Any, gate: asyncio.Event) -> Any:
    """Have the robot's PersonDetection wait before each command; return what ends that."""
    part = robot.parts["PersonDetection"]
    run = part.run

    async def waiting(*asked: Any) -> Any:
        await gate.wait()
        return await run(*asked)

    part.run = waiting
    return lambda: setattr(part, "run", run)


async def test_what_is_being_made_when_the_scope_shrinks_is_not_had() -> None:
    expiry = TokenExpiry(principal("operator", "*"))
    async with place(LOST) as where, where.application(expiry) as wire:
        streams = where.robots[LOST].streams
        streams.may_answer.clear()
        camera = {"component_ref": where.robots[LOST].robot.ref("VideoStreaming")}
        connecting = asyncio.ensure_future(wire.code("rois.stream.connect_stream", camera))
        await streams.called.wait()
        expiry.replace(principal("operator", "other/*"))
        streams.may_answer.set()
        assert await connecting == "UNSUPPORTED"
        assert streams.streams == {}


async def test_a_stream_that_cannot_be_ended_is_no_reason_to_show_it(
    holder: Holder, caplog: pytest.LogCaptureFixture
) -> None:
    holder.where.robots[LOST].streams.refusal = Unsupported("not now")
    holder.expiry.replace(principal("operator", "kept/*"))
    await holder.wire.until("rois.system.profile_changed")
    assert await holder.has(LOST) == NOTHING
    assert "a stream that its application lost could not be ended: not now" in caplog.text
    streams = holder.where.robots[LOST].streams
    streams.announce(holder.streams[LOST], StreamStatus.STREAMING_RUNNING)
    streams.offer(streams.streams[holder.streams[LOST]].client, new_id(LOST), [])
    frames = [json.loads(frame) for frame in await holder.wire.ask("rois.command.search", {})]
    assert not {"rois.stream.notify_stream_status", "signaling.offer"} & {frame.get("method") for frame in frames}


async def test_what_is_out_of_sight_in_an_engine_that_is_not_is_not_told_of_either(holder: Holder) -> None:
    robot, streams = holder.where.robots[LOST].robot, holder.where.robots[LOST].streams
    streams.refusal = Unsupported("not now")
    holder.expiry.replace(principal("operator", robot.ref("Navigation")))
    await holder.wire.until("rois.system.profile_changed")
    streams.announce(holder.streams[LOST], StreamStatus.STREAMING_RUNNING)
    frames = [json.loads(frame) for frame in await holder.wire.ask("rois.command.search", {})]
    assert "rois.stream.notify_stream_status" not in {frame.get("method") for frame in frames}
    assert frames[-1]["result"]["component_ref_list"] == [robot.ref("Navigation")]


async def test_a_component_out_of_scope_is_not_waited_for() -> None:
    expiry = TokenExpiry(principal("operator", "*"))
    async with place(LOST) as where, where.application(expiry) as wire:
        navigation = where.robots[LOST].robot.ref("Navigation")
        async with where.application(principal("operator", "*")) as other:
            await other.result("rois.command.bind", {"component_ref": navigation})
            await other.result("openrois.lease.query", {"component_ref": navigation})
            lease = (await wire.result("openrois.lease.request", {"component_ref": navigation}))["lease"]
            assert lease["position"] == 1
            await other.until("openrois.lease.requested")
            expiry.replace(principal("operator", "other/*"))
            await other.until("openrois.lease.withdrawn")
            await wire.until("rois.system.profile_changed")
            assert await other.code("rois.command.release", {"component_ref": navigation}) == "OK"
        # An application that watched it is not notified any more.
        frames = [json.loads(frame) for frame in await wire.ask("rois.command.search", {})]
        assert [frame["method"] for frame in [*map(json.loads, wire.frames), *frames[:-1]]] == []
        assert await wire.code("openrois.lease.query", {"component_ref": navigation}) == "UNSUPPORTED"


@pytest.mark.parametrize(("lesser", "kept"), [(("operator", "kept/*"), [KEPT]), (("operator", "*"), [KEPT, LOST])])
async def test_resuming_with_a_smaller_scope_loses_leases(lesser: tuple[str, str], kept: list[str]) -> None:
    async with place(KEPT, LOST) as where:
        refs = {each: where.robots[each].robot.ref("Navigation") for each in (KEPT, LOST)}
        async with where.application(principal("operator", "*")) as wire:
            for ref in refs.values():
                await wire.result("rois.command.bind", {"component_ref": ref})
            token = (await wire.result("openrois.lease.token", {}))["token"]
            wire.stream.abort()
        async with (
            where.application(principal(*lesser)) as wire,
            where.application(principal("operator", "*")) as other,
        ):
            resumed = await wire.result("openrois.lease.resume", {"token": token})
            assert [each["component_ref"] for each in resumed["leases"]] == [refs[each] for each in kept]
            for each, ref in refs.items():
                expected = "OUT_OF_RESOURCES" if each in kept else "OK"
                assert await other.code("rois.command.bind", {"component_ref": ref}) == expected


async def test_a_principal_without_roles_keeps_nothing(holder: Holder) -> None:
    """After its token has ended: every method is refused, and nothing is notified."""
    holder.expiry.replace(Principal("anna", frozenset(), ()))
    assert await holder.has(KEPT) == NOTHING
    holder.where.robots[KEPT].robot.parts["PersonDetection"].tell("person_detected")
    await asyncio.sleep(0)
    frames = [json.loads(frame) for frame in await holder.wire.ask("rois.system.get_profile", {})]
    assert "rois.event.notify_event" not in [frame.get("method") for frame in frames]
    assert frames[-1]["result"] == {"return_code": "UNSUPPORTED", "profile": None, "component_profiles": {}}
