"""Ids belong to sessions: principals copy and guess each other's, and are never answered as if these were theirs."""

import asyncio
import json
import os
from collections.abc import Coroutine
from contextlib import AsyncExitStack
from typing import Any, Final, TypeVar

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, initialize, invariant, rule, run_state_machine_as_test

from openrois.auth.principal import Principal
from openrois.types.codes import ErrorType
from openrois.types.references import new_id
from tests.openrois.interfaces.test_matrix import condition, unit
from tests.support.authorization import Place, Wire, place, principal

RUNS: Final = int(os.environ.get("OPENROIS_OWNERSHIP_RUNS", "40"))

CAMERA, PERSON, NAVIGATION = "fleet/video_streaming", "fleet/person_detecter", "fleet/navigation"
WHO: Final[dict[str, Principal]] = {
    "operator": principal("operator", "fleet/*", subject="ann"),
    "again": principal("operator", "fleet/*", subject="ann"),
    "viewer": principal("viewer", CAMERA, PERSON, subject="bob"),
    "stranger": principal("operator", "other/*", subject="cy"),
    "root": principal("administrator", "*", subject="root"),
}
SESSIONS: Final = st.sampled_from(sorted(WHO))
CHANGES: Final = st.sampled_from(["copy", "copy", "last", "upper", "other", "minted"])

# How each kind of id is used, and what is answered where it is not the session's own.
USES: Final = {
    "stream": [
        ("rois.stream.query_stream_status", "stream_id", "UNSUPPORTED"),
        ("rois.stream.suspend_stream", "stream_id", "UNSUPPORTED"),
        ("rois.stream.resume_stream", "stream_id", "UNSUPPORTED"),
    ],
    "peer": [("signaling.restart", "peer_id", "UNSUPPORTED")],
    "event": [("rois.event.get_event_detail", "event_id", "BAD_PARAMETER")],
    "command": [("rois.command.get_command_result", "command_id", "BAD_PARAMETER")],
    "error": [("rois.system.get_error_detail", "error_id", "BAD_PARAMETER")],
    "request": [("openrois.lease.grant", "request_id", "UNSUPPORTED")],
}
_WATCHES: Final = {name for name, who in WHO.items() if who.may_call("rois.stream.connect_stream")}
_RUNS: Final = {name for name, who in WHO.items() if who.may_call("rois.command.execute")}
T = TypeVar("T")


class Thieves(RuleBasedStateMachine):
    """Five sessions, two of them of one subject, and a model of what each of them owns."""

    ids: Bundle[tuple[str, str]] = Bundle("ids")

    def __init__(self) -> None:
        super().__init__()
        self.runner = asyncio.Runner()
        self.stack = AsyncExitStack()
        self.own: dict[str, set[tuple[str, str]]] = {name: set() for name in WHO}
        self.results: dict[tuple[str, str], str] = {}
        self.subscribed: dict[str, str] = {}
        self.where: Place
        self.wires: dict[str, Wire] = {}

    def run(self, work: Coroutine[Any, Any, T]) -> T:
        return self.runner.run(work)

    @initialize()
    def begin(self) -> None:
        async def connect() -> None:
            self.where = await self.stack.enter_async_context(place("fleet", "other"))
            for name, who in WHO.items():
                self.wires[name] = await self.stack.enter_async_context(self.where.application(who))
                await self.wires[name].result("openrois.hello", {"version": "1"})

        self.run(connect())

    def teardown(self) -> None:
        self.run(self.stack.aclose())
        self.runner.close()

    @rule(target=ids, name=SESSIONS)
    def connect_stream(self, name: str) -> tuple[str, str]:
        result = self.run(self.wires[name].result("rois.stream.connect_stream", {"component_ref": CAMERA}))
        mine = len([1 for kind, _ in self.own[name] if kind == "stream"])
        expected = "UNSUPPORTED" if not WHO[name].sees(CAMERA) else "OK" if mine < 16 else "OUT_OF_RESOURCES"
        assert result["return_code"] == expected
        if expected != "OK":
            return "stream", "none"
        self.own[name] |= {("stream", result["stream_id"])}
        offer = self.run(self.wires[name].until("signaling.offer"))
        if len([1 for kind, _ in self.own[name] if kind == "peer"]) < 64:
            self.own[name] |= {("peer", offer["peer_id"])}
        return "stream", result["stream_id"]

    @rule(target=ids, name=SESSIONS, data=st.data())
    def learn_of_a_peer(self, name: str, data: st.DataObject) -> tuple[str, str]:
        peers = sorted(each for each in self.own[name] if each[0] == "peer")
        return data.draw(st.sampled_from(peers or [("peer", "none")]))

    @rule(target=ids, name=SESSIONS)
    def hear_an_event(self, name: str) -> tuple[str, str]:
        """Every subscriber gets it, and may read its details; others may not."""
        wire = self.wires[name]
        if name not in self.subscribed:
            told = self.run(
                wire.result("rois.event.subscribe", {"event_type": "person_detected", "condition": condition(PERSON)})
            )
            assert (told["return_code"] == "OK") == WHO[name].sees(PERSON)
            if told["return_code"] != "OK":
                return "event", "none"
            self.subscribed[name] = told["subscribe_id"]
        event_id = "none"

        async def detect() -> None:
            self.where.robots["fleet"].robot.parts["PersonDetection"].tell("person_detected")

        self.run(detect())
        for each, subscribe_id in self.subscribed.items():
            event = self.run(self.wires[each].until("rois.event.notify_event"))
            assert event["subscribe_id"] == subscribe_id
            assert event_id in ("none", event["event_id"])
            event_id = event["event_id"]
            self.own[each] |= {("event", event_id)}
        return "event", event_id

    @rule(name=SESSIONS, thief=SESSIONS)
    def end_the_subscription_of_another(self, name: str, thief: str) -> None:
        """It is answered OK, as an unknown id is, and nothing ends."""
        subscribe_id = self.subscribed.get(name, new_id("gateway"))
        if thief != name:
            code = self.run(self.wires[thief].code("rois.event.unsubscribe", {"subscribe_id": subscribe_id}))
            assert code == "OK"

    @rule(target=ids, name=SESSIONS, number=st.integers(1, 3))
    def execute(self, name: str, number: int) -> tuple[str, str]:
        """Connect a stream in strict RoIS: what it gives is another's business least of all."""
        command_id, wire = f"k{number}", self.wires[name]
        command = unit(CAMERA, "connect_stream") | {"command_id": command_id}
        code = self.run(wire.code("rois.command.execute", {"command_unit_list": [command]}))
        taken = ("command", command_id) in self.own[name]
        allowed = name in _RUNS and WHO[name].sees(CAMERA)
        assert code == ("UNSUPPORTED" if not allowed else "BAD_PARAMETER" if taken else "OK")
        if code == "OK":
            status = self.run(wire.completed(command_id))
            results = self.run(wire.result("rois.command.get_command_result", {"command_id": command_id}))["results"]
            self.own[name] |= {("command", command_id)}
            self.results[name, command_id] = results[0]["value"] if status == "OK" else ""
            if status == "OK":
                self.own[name] |= {("stream", results[0]["value"])}
        return "command", command_id

    @rule(target=ids, name=SESSIONS)
    def have_a_fault(self, name: str) -> tuple[str, str]:
        """A component is faulty: applications that work with it are notified, and may read the details."""

        async def report() -> None:
            self.where.host.engine.report(ErrorType.USER_DEFINED_ERROR, "a fault", PERSON)

        self.run(report())
        error_id = "none"
        for each in self.subscribed:
            told = self.run(self.wires[each].until("rois.system.notify_error"))
            error_id = told["error_id"]
            self.own[each] |= {("error", error_id)}
        return "error", error_id

    @rule(thief=SESSIONS, known=ids, change=CHANGES, data=st.data())
    def use(self, thief: str, known: tuple[str, str], change: str, data: st.DataObject) -> None:
        """Use an id, or one like it, as any kind of id: own ones are answered, all others look the same."""
        kind = data.draw(st.sampled_from(sorted(USES)))
        value = changed(known[1], change)
        method, member, refusal = data.draw(st.sampled_from(USES[kind]))
        answer = self.answer(thief, method, {member: value})
        if not WHO[thief].may_call(method):
            assert answer[-1]["result"]["return_code"] == "UNSUPPORTED"
        elif (kind, value) in self.own[thief]:
            assert answer[-1]["result"]["return_code"] == "OK"
            if kind == "command":
                given = self.results[thief, value]
                assert [each["value"] for each in answer[-1]["result"]["results"]] == ([given] if given else [])
        else:
            assert answer[-1]["result"]["return_code"] == refusal
            unknown = json.dumps(self.answer(thief, method, {member: "unknown"}))
            assert json.dumps(answer).replace(value, "unknown") == unknown

    def answer(self, name: str, method: str, params: dict[str, str]) -> list[dict[str, Any]]:
        """Ask, and return the answer and the reason that stands before it; other notifications are kept."""
        frames = [json.loads(frame) for frame in self.run(self.wires[name].ask(method, params))]
        answers = [each for each in frames if "id" in each or each["method"] == "openrois.reason"]
        self.wires[name].frames += [json.dumps(each) for each in frames if each not in answers]
        return answers

    @invariant()
    def streams_are_where_they_belong(self) -> None:
        """No session has ended or suspended a stream of another: the engine has all of them still."""
        if self.wires:
            streams = {value for own in self.own.values() for kind, value in own if kind == "stream"}
            assert set(self.where.robots["fleet"].streams.streams) == streams


def changed(value: str, change: str) -> str:
    """Return an id that is like another."""
    engine_id, _, rest = value.partition("/")
    return {
        "copy": value,
        "last": value[:-1] + ("0" if value[-1:] != "0" else "1"),
        "upper": value.upper(),
        "other": f"other/{rest}",
        "minted": new_id(engine_id or "fleet"),
    }[change]


def test_no_session_is_answered_for_another() -> None:
    assert {"operator", "viewer", "root"} <= _WATCHES
    few = settings(max_examples=RUNS, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    run_state_machine_as_test(Thieves, settings=settings(few, stateful_step_count=30))
