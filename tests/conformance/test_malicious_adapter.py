"""An adapter that lies, floods and guesses: what becomes of it, and that an honest one beside it notices nothing."""

import json
from collections.abc import Awaitable, Callable
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import Any, Final

import pytest

from openrois.gateway.server import Gateway
from openrois.gateway.socket import ADAPTER
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot
from tests.support.plain import PlainAdapter, attached, plain_adapter, profile_result, refusal
from tests.support.viewer import CAMERA, STATUS, peer_of, stream_of

LAMP: Final = "robot/lamp"
TOY: Final = "plain/toy"
STAYS: Final = 0
"""Instead of a close code: the adapter's connection stays, and what it said went nowhere."""

TEXT: Final = {"name": "text", "data_type_ref": "string", "value": "a lie"}


@dataclass
class Scene:
    """The malicious adapter, and what it may have found out about others.

    Attributes:
        evil: it.
        app: an application that works with it and with an honest one.
        subscriptions: ids of subscriptions at the honest adapter.
        stream: an id of a stream of the honest adapter.
        peer: an id of a peer connection to it.
        clients: names under which it may think that applications are known; the first is right.
    """

    evil: PlainAdapter
    app: Application
    subscriptions: list[str]
    stream: str
    peer: str
    clients: tuple[str, ...]

    async def raw(self, *messages: str | bytes) -> None:
        for message in messages:
            await self.evil.socket.send(message)

    async def ask_toy(self) -> dict[str, Any]:
        return await self.app.ask("rois.query.query", query_type="mood", condition=f"component_ref = '{TOY}'")

    async def say(self, command_id: str) -> None:
        """Let the application execute a command of the malicious adapter."""
        unit = {"component_ref": TOY, "command_type": "say", "command_id": command_id, "arguments": [TEXT]}
        assert await self.app.code("rois.command.execute", command_unit_list=[unit]) == "OK"

    async def listen(self) -> str:
        """Let the application subscribe to an event of the malicious adapter; return the id between both."""
        self.evil.answers["rois.event.subscribe"] = {"return_code": "OK", "subscribe_id": "plain/own"}
        condition = f"component_ref = '{TOY}'"
        assert await self.app.code("rois.event.subscribe", event_type="laughed", condition=condition) == "OK"
        return "plain/own"


async def completes_what_others_run(scene: Scene) -> None:
    for command_id in ("honest", "robot/1", "gateway/1", "1"):
        await scene.evil.tell_completed(command_id, "ERROR")


async def completes_twice(scene: Scene) -> None:
    await scene.say("twice")
    assert await scene.app.completed("twice") == {"twice": "OK"}
    command_id = scene.evil.last("rois.command.execute")["command_unit_list"][0]["command_id"]
    for status in ("ERROR", "OK", "ABORT"):
        await scene.evil.tell_completed(command_id, status)


async def completes_with_a_status_that_is_none(scene: Scene) -> None:
    scene.evil.answers["rois.command.execute"] = None
    await scene.say("odd")
    async with deployment.patience():
        request = await scene.evil.unanswered.get()
    await scene.evil.answer(request, return_code="OK")
    command_id = request["params"]["command_unit_list"][0]["command_id"]
    await scene.evil.tell_completed(command_id, "FINE")
    await scene.evil.tell_completed(command_id, "ABORT")
    assert await scene.app.completed("odd") == {"odd": "ABORT"}


async def completes_before_it_accepts(scene: Scene) -> None:
    scene.evil.answers["rois.command.execute"] = None
    begun = await scene.app.begin(
        "rois.command.execute",
        command_unit_list=[{"component_ref": TOY, "command_type": "start", "command_id": "early"}],
    )
    async with deployment.patience():
        request = await scene.evil.unanswered.get()
    await scene.evil.tell_completed(request["params"]["command_unit_list"][0]["command_id"])
    await scene.evil.answer(request, return_code="OK")
    assert (await scene.app.answer(begun))["result"] == {"return_code": "OK"}
    assert await scene.app.completed("early") == {"early": "OK"}


async def tells_events_of_foreign_subscriptions(scene: Scene) -> None:
    for subscribe_id in (*scene.subscriptions, "gateway/1", ""):
        await scene.evil.tell_event(subscribe_id, "rang")


async def tells_events_nobody_asked_for(scene: Scene) -> None:
    await scene.evil.tell_event(await scene.listen(), "cried")


async def tells_events_under_foreign_ids(scene: Scene) -> None:
    await scene.evil.tell_event(await scene.listen(), "laughed", event_id="robot/evt-1")


async def tells_events_of_wrong_types(scene: Scene) -> None:
    subscribe_id = await scene.listen()
    wrongs: tuple[dict[str, Any], ...] = (
        {"event_id": 5},
        {"results": "ha"},
        {"expire": {}},
        {"results": [{"name": 1}]},
        {"subscribe_id": []},
    )
    for wrong in wrongs:
        usual = {"event_id": "plain/e", "event_type": "laughed", "subscribe_id": subscribe_id, "results": []}
        await scene.evil.tell("rois.event.notify_event", **{**usual, "expire": "2030-01-01T00:00:00+00:00", **wrong})


async def floods_with_events(scene: Scene) -> None:
    for number in range(3000):
        await scene.evil.tell_event("plain/absent", "laughed", event_id=f"plain/{number}")


async def answers_with_more_than_may_be_said(scene: Scene) -> None:
    too_long = {"return_code": "OK", "results": [{**TEXT, "value": "x" * ADAPTER.max_message}]}
    scene.evil.answers["rois.query.query"] = too_long
    assert (await scene.ask_toy())["return_code"] == "ERROR"


async def answers_with_as_much_as_may_be_said(scene: Scene) -> None:
    long = {"return_code": "OK", "results": [{**TEXT, "value": "x" * (ADAPTER.max_message - 1000)}]}
    scene.evil.answers["rois.query.query"] = long
    assert (await scene.ask_toy())["return_code"] == "OK"


async def answers_twice(scene: Scene) -> None:
    assert (await scene.ask_toy())["return_code"] == "OK"
    # What it is asked next it may answer as it likes.
    for number in range(1, scene.evil.last_id + 1):
        await scene.raw(json.dumps({"jsonrpc": "2.0", "id": number, "result": {"return_code": "ERROR", "results": []}}))


async def answers_what_was_never_asked(scene: Scene) -> None:
    for odd in (10**6, -1, "1", None, 1.5):
        await scene.raw(json.dumps({"jsonrpc": "2.0", "id": odd, "result": {"return_code": "OK"}}))


async def answers_with_what_is_no_result(scene: Scene) -> None:
    results: tuple[Any, ...] = (None, [], 5, {"return_code": "FINE"}, {"return_code": "OK", "results": [[]]})
    for result in results:
        scene.evil.answers["rois.query.query"] = f'{{"jsonrpc":"2.0","id":"ID","result":{json.dumps(result)}}}'
        assert (await scene.ask_toy())["return_code"] == "ERROR"


async def answers_with_an_error_full_of_secrets(scene: Scene) -> None:
    scene.evil.answers["rois.query.query"] = (
        '{"jsonrpc":"2.0","id":"ID","error":{"code":-32603,"message":"Traceback the secret"}}'
    )
    assert (await scene.ask_toy())["return_code"] == "ERROR"
    assert "secret" not in json.dumps(scene.app.heard)


async def mints_foreign_ids(scene: Scene) -> None:
    for minted in (*scene.subscriptions, "robot/1", "gateway/1", ""):
        scene.evil.answers["rois.event.subscribe"] = {"return_code": "OK", "subscribe_id": minted}
        condition = f"component_ref = '{TOY}'"
        assert await scene.app.code("rois.event.subscribe", event_type="laughed", condition=condition) == "ERROR"


async def never_ends(scene: Scene) -> None:
    scene.evil.hold_completed = True
    await scene.say("endless")
    assert (await scene.app.ask("rois.command.get_command_result", command_id="endless"))["return_code"] == "OK"


async def asks_as_an_application(scene: Scene) -> None:
    for number, method in enumerate(
        ("rois.command.search", "rois.command.bind", "openrois.stop_all", "openrois.hello")
    ):
        request = {"jsonrpc": "2.0", "id": 900 + number, "method": method, "params": {"component_ref": LAMP}}
        await scene.raw(json.dumps(request))
    await scene.ask_toy()
    assert scene.evil.refusals == [-32601] * 4


async def speaks_nonsense(scene: Scene) -> None:
    await scene.raw("{", "[]", "5", "[" * 20_000, '{"jsonrpc":"2.0"}', "\x00")
    await scene.ask_toy()
    assert set(scene.evil.refusals) <= {-32700, -32600}


async def sends_bytes(scene: Scene) -> None:
    await scene.raw(b"\x00\x01")


async def changes_its_profile_a_thousand_times(scene: Scene) -> None:
    for number in range(1000):
        scene.evil.profile = profile_result("toy", f"part-{number}")
        await scene.evil.tell("rois.system.profile_changed")
    await scene.app.next("rois.system.profile_changed")
    await scene.ask_toy()
    assert sum(method == "rois.system.get_profile" for method, _ in scene.evil.asked) < 100
    scene.app.told.clear()


async def becomes_somebody_else(scene: Scene) -> None:
    scene.evil.profile = profile_result("lamp", engine_id="robot")
    await scene.evil.tell("rois.system.profile_changed")


async def claims_foreign_components(scene: Scene) -> None:
    claimed = profile_result("toy")
    claimed["profile"]["component_ids"].append(LAMP)
    claimed["component_profiles"][LAMP] = claimed["component_profiles"][TOY]
    scene.evil.profile = claimed
    await scene.evil.tell("rois.system.profile_changed")


async def tells_the_status_of_foreign_streams(scene: Scene) -> None:
    for client_id in scene.clients:
        notice = {"stream_id": scene.stream, "component_ref": CAMERA, "timestamp": "2030-01-01T00:00:00+00:00"}
        await scene.evil.tell(STATUS, client_id=client_id, status="STREAMING_NOT_CONNECTED", **notice)


async def offers_in_the_name_of_others(scene: Scene) -> None:
    for client_id in scene.clients:
        offer = {"peer_id": scene.peer, "generation": 2, "sdp": "v=0", "streams": []}
        await scene.evil.tell("signaling.offer", client_id=client_id, **offer)


async def ends_peers_of_others(scene: Scene) -> None:
    for client_id in scene.clients:
        await scene.evil.tell("signaling.bye", client_id=client_id, peer_id=scene.peer, reason="mischief")


async def lies_about_who_holds_what(scene: Scene) -> None:
    for client_id in scene.clients:
        await scene.evil.tell("openrois.holder", component_ref=LAMP, epoch=10**9, client_id=client_id)
        await scene.evil.tell("openrois.lease.changed", component_ref=LAMP, client_id=client_id, state="FREE")
        await scene.evil.tell("openrois.client_gone", client_id=client_id)


async def blames_foreign_components(scene: Scene) -> None:
    for error_id in ("robot/err-1", "gateway/err-1", "x"):
        await scene.evil.tell(
            "rois.system.notify_error", error_id=error_id, error_type="COMPONENT_INTERNAL_ERROR", component_ref=LAMP
        )


async def explains_what_is_not_its_own(scene: Scene) -> None:
    await scene.evil.tell("openrois.reason", command_id="honest", reason="mischief")
    await scene.evil.tell("openrois.reason", request_id="req-1", reason="mischief")
    await scene.evil.tell("openrois.events_dropped", count=5)
    await scene.evil.tell("openrois.auth.expiring", expires_in=1)


MISBEHAVIOURS: Final[dict[Callable[[Scene], Awaitable[None]], int]] = {
    completes_what_others_run: STAYS,
    completes_twice: STAYS,
    completes_with_a_status_that_is_none: STAYS,
    completes_before_it_accepts: STAYS,
    tells_events_of_foreign_subscriptions: STAYS,
    tells_events_nobody_asked_for: STAYS,
    tells_events_under_foreign_ids: STAYS,
    tells_events_of_wrong_types: STAYS,
    floods_with_events: STAYS,
    answers_with_more_than_may_be_said: 1009,
    answers_with_as_much_as_may_be_said: STAYS,
    answers_twice: STAYS,
    answers_what_was_never_asked: STAYS,
    answers_with_what_is_no_result: STAYS,
    answers_with_an_error_full_of_secrets: STAYS,
    mints_foreign_ids: STAYS,
    never_ends: STAYS,
    asks_as_an_application: STAYS,
    speaks_nonsense: STAYS,
    sends_bytes: 1003,
    changes_its_profile_a_thousand_times: STAYS,
    becomes_somebody_else: 1008,
    claims_foreign_components: 1008,
    tells_the_status_of_foreign_streams: STAYS,
    offers_in_the_name_of_others: STAYS,
    ends_peers_of_others: STAYS,
    lies_about_who_holds_what: STAYS,
    blames_foreign_components: STAYS,
    explains_what_is_not_its_own: STAYS,
}
"""What it does, and how its connection ends."""

HELLO: Final = {
    "return_code": "OK",
    "version": "1",
    "extensions": ["rois.stream", "signaling"],
    "engines": [],
    "client_id": "",
}


async def enter(stack: AsyncExitStack, gateway: Gateway, adapter: Adapter, app: Application) -> Scene:
    """Let an application work with both adapters."""
    evil = await stack.enter_async_context(plain_adapter(gateway, openrois__hello=HELLO))
    await attached(gateway)
    assert await app.code("rois.command.bind", component_ref=LAMP) == "OK"
    condition = "component_ref = 'robot/bell'"
    assert await app.code("rois.event.subscribe", event_type="rang", condition=condition) == "OK"
    unit = {"component_ref": LAMP, "command_type": "start", "command_id": "honest"}
    assert await app.code("rois.command.execute", command_unit_list=[unit]) == "OK"
    stream, peer = await stream_of(app), await peer_of(app)
    evil.answers["rois.stream.connect_stream"] = {"return_code": "OK", "stream_id": "plain/1"}
    assert await app.code("rois.stream.connect_stream", component_ref=TOY) == "OK"
    known = evil.last("rois.stream.connect_stream")["client_id"]
    await app.settled()
    app.told.clear()
    clients = (known, "robot", "gateway", "client-1", "")
    return Scene(evil, app, list(adapter.host.engine._subscriptions), stream, peer, clients)


async def nothing_noticed(scene: Scene, robot: Robot, of_its_end: set[str]) -> None:
    """Check that what was begun with the honest adapter goes on, and that only the other's end was notified."""
    app = scene.app
    assert set(await app.settled()) <= of_its_end
    app.told.clear()
    assert robot.lamp.glowing.is_set()
    robot.lamp.may_end.set()
    assert await app.completed("honest") == {"honest": "OK"}
    unit = {"component_ref": LAMP, "command_type": "switch", "command_id": "still mine"}
    assert await app.code("rois.command.execute", command_unit_list=[unit]) == "OK"
    assert await app.completed("still mine") == {"still mine": "OK"}
    robot.bell.ring("a true tune")
    assert (await app.next("rois.event.notify_event"))["results"][0]["value"] == "a true tune"
    status = await app.ask("rois.stream.query_stream_status", stream_id=scene.stream)
    assert status == {"return_code": "OK", "status": "STREAMING_NOT_RUNNING"}
    assert await app.code("signaling.restart", peer_id=scene.peer) == "OK"
    assert not [name for name, _ in app.told if name.startswith("rois.")]
    assert "lie" not in json.dumps([each for each in app.heard if each.get("method")])


@pytest.mark.parametrize("misbehave", MISBEHAVIOURS, ids=lambda each: each.__name__)
async def test_an_honest_adapter_and_its_application_notice_nothing(
    misbehave: Callable[[Scene], Awaitable[None]],
    gateway: Gateway,
    adapter: Adapter,
    app: Application,
    robot: Robot,
    stack: AsyncExitStack,
) -> None:
    scene = await enter(stack, gateway, adapter, app)
    await misbehave(scene)
    ends = MISBEHAVIOURS[misbehave]
    if ends:
        assert (await refusal(scene.evil))[0] == ends
        await deployment.until(gateway.engine, lambda ids: "plain" not in ids)
    else:
        # It answers, so all that it has said before was looked at.
        scene.evil.answers.pop("rois.query.query", None)
        assert (await scene.ask_toy())["return_code"] == "OK"
    of_its_end = {"rois.system.profile_changed", "rois.system.notify_error", STATUS} if ends else set()
    await nothing_noticed(scene, robot, of_its_end)


def test_they_are_enough() -> None:
    assert len(MISBEHAVIOURS) >= 25
