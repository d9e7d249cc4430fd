"""Roles x methods x components x scope, generated from the method tables and the catalog, against a table of its own.

Every case is asked in a real session. What is judged is the answer, and what was reached behind the gateway.
"""

import asyncio
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import cycle
from typing import Any, Final

import pytest
from openrois_signaling.methods import signaling_methods
from openrois_signaling.relay import Relay

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.component_type import ComponentType
from openrois.testing.samples import argument
from openrois.types.codes import ComponentFunction
from openrois.types.methods import METHODS
from openrois.types.profiles import HRIComponentProfile
from tests.support.authorization import Place, Wire, place, principal

SIGNALING: Final = sorted(signaling_methods(Relay(None, lambda: 0.0), "anna", None))  # type: ignore[arg-type]

# Who may call: viewer, visitor, listener, maintenance, operator, administrator, adapter. Then what is answered of a
# component that is out of scope or absent, and of one in scope that the application has bound.
ORACLE: Final = """
    rois.system.connect                 v i l m o a .   -               OK
    rois.system.disconnect              v i l m o a .   -               OK
    rois.system.get_profile             v i l m o a .   OK              OK
    rois.system.get_error_detail        v i l m o a .   BAD_PARAMETER   BAD_PARAMETER
    rois.command.search                 v i l m o a .   OK              OK
    rois.command.bind                   . . . . o a .   UNSUPPORTED     OK
    rois.command.bind_any               . . . . o a .   UNSUPPORTED     OK
    rois.command.release                . . . . o a .   UNSUPPORTED     OK
    rois.command.get_parameter          v i l m o a .   UNSUPPORTED     OK
    rois.command.set_parameter          . . . . o a .   UNSUPPORTED     OK
    rois.command.execute                . . . . o a .   UNSUPPORTED     OK
    rois.command.get_command_result     v i l m o a .   BAD_PARAMETER   BAD_PARAMETER
    rois.query.query                    v i l m o a .   UNSUPPORTED     OK
    rois.event.subscribe                v i l m o a .   UNSUPPORTED     OK
    rois.event.unsubscribe              v i l m o a .   OK              OK
    rois.event.get_event_detail         v i l m o a .   BAD_PARAMETER   BAD_PARAMETER
    openrois.hello                      v i l m o a .   -               OK
    openrois.auth.refresh               v i l m o a .   -               -
    openrois.directory.list             v i l m o a .   OK              OK
    openrois.directory.read             v i l m o a .   OK              OK
    openrois.directory.profiles         v i l m o a .   OK              OK
    openrois.lease.query                v i l m o a .   UNSUPPORTED     OK
    openrois.lease.request              . . . . o a .   UNSUPPORTED     OK
    openrois.lease.leave                . . . . o a .   UNSUPPORTED     OK
    openrois.lease.grant                . . . . o a .   UNSUPPORTED     UNSUPPORTED
    openrois.lease.decline              . . . . o a .   UNSUPPORTED     UNSUPPORTED
    openrois.lease.borrow               . . . . o a .   UNSUPPORTED     OK
    openrois.lease.give_back            . . . . o a .   UNSUPPORTED     OK
    openrois.lease.take                 . . . . . a .   UNSUPPORTED     OK
    openrois.lease.token                . . . . o a .   -               OK
    openrois.lease.resume               . . . . o a .   -               -
    openrois.stop_all                   . . . . o a .   UNSUPPORTED     OK
    openrois.lease.release_stop         . . . . o a .   UNSUPPORTED     OK
    rois.stream.connect_stream          v i l . o a .   UNSUPPORTED     OK
    rois.stream.disconnect_stream       v i l . o a .   UNSUPPORTED     UNSUPPORTED
    rois.stream.suspend_stream          v i l . o a .   UNSUPPORTED     UNSUPPORTED
    rois.stream.resume_stream           v i l . o a .   UNSUPPORTED     UNSUPPORTED
    rois.stream.query_stream_status     v i l . o a .   UNSUPPORTED     UNSUPPORTED
    rois.stream.report_playout          v i l . o a .   UNSUPPORTED     UNSUPPORTED
    rois.stream.set_consent             v i l . o a .   UNSUPPORTED     UNSUPPORTED
    signaling.answer                    v i l . o a .   UNSUPPORTED     UNSUPPORTED
    signaling.candidate                 v i l . o a .   UNSUPPORTED     UNSUPPORTED
    signaling.restart                   v i l . o a .   UNSUPPORTED     UNSUPPORTED
    signaling.ice_servers               v i l . o a .   -               OK
"""
ROLES: Final = {
    "v": "viewer",
    "i": "visitor",
    "l": "listener",
    "m": "maintenance",
    "o": "operator",
    "a": "administrator",
    "x": "adapter",
    "-": None,
}

REACHES: Final = {
    "rois.command.get_parameter": "query",
    "rois.command.set_parameter": "invoke",
    "rois.command.execute": "invoke",
    "rois.query.query": "query",
    "rois.event.subscribe": "subscribe",
    "rois.stream.connect_stream": "rois.stream.connect_stream",
}
"""What a method calls behind the gateway; the others call nothing."""

FLEET, HIDDEN = "fleet", "hidden"
_NO_REF: Final = ("", "/", "fleet", "fleet/", "fleet//x", "fleet/ ", "FLEET/*", "*", "fleet/*", "\x00", "é" * 999)
_NAMES: Final = re.compile("|".join(f"{FLEET}/{kind.name}" for kind in BASIC_COMPONENTS))
_ACTING: Final = [kind for kind in BASIC_COMPONENTS if kind.function is ComponentFunction.ACTUATION]
_OF_EACH_CLASS: Final = {kind.function: kind for kind in BASIC_COMPONENTS}.values()


@dataclass(frozen=True)
class Rule:
    """A line of the oracle."""

    roles: frozenset[str]
    absent: str
    present: str


def rules() -> dict[str, Rule]:
    lines = (line.split() for line in ORACLE.strip().splitlines())
    return {name: Rule(frozenset(who) - {"."}, absent, present) for name, *who, absent, present in lines}


RULES: Final = rules()


def test_the_table_of_this_test_has_every_method() -> None:
    assert {method.name for method in METHODS} | set(SIGNALING) == RULES.keys()


Shape = tuple[str, Callable[[str], dict[str, Any]]]


def condition(ref: str) -> str:
    return "component_ref = '{}'".format(ref.replace("'", "''"))


_ids = iter(range(10**9))


def unit(ref: str, command: str, arguments: Any = ()) -> dict[str, Any]:
    given = [argument(profile).model_dump() for profile in arguments]
    return {"component_ref": ref, "command_type": command, "command_id": f"c{next(_ids)}", "arguments": given}


def messages(profile: HRIComponentProfile) -> Iterator[Shape]:
    """Return a case for each message that the type has, and for every place in which a ref stands."""
    if profile.function is ComponentFunction.ACTUATION:
        for verb in ("query", "request", "leave", "take"):
            yield f"openrois.lease.{verb}", lambda ref: {"component_ref": ref}
        yield "openrois.stop_all", lambda ref: {"component_ref": ref}
        yield "openrois.lease.release_stop", lambda ref: {"component_ref": ref}
    for command in profile.command_profiles:
        if command.name in ("suspend_stream", "resume_stream", "disconnect_stream"):
            continue
        yield (
            "rois.command.execute",
            lambda ref, c=command: {"command_unit_list": [unit(ref, c.name, c.arguments)]},  # type: ignore[misc]
        )
    if profile.command_profiles:
        yield "rois.command.execute", lambda ref: {"command_unit_list": [{"command_list": [unit(ref, "stop")]}]}
        yield "rois.command.execute", lambda ref: {"command_unit_list": [unit(ref, "stop"), unit(ref, "stop")]}
    for query in profile.query_profiles:
        if query.name != "get_stream_status":
            yield (
                "rois.query.query",
                lambda ref, q=query: {"query_type": q.name, "condition": condition(ref)},  # type: ignore[misc]
            )
    for event in profile.event_profiles:
        yield (
            "rois.event.subscribe",
            lambda ref, e=event: {"event_type": e.name, "condition": condition(ref)},  # type: ignore[misc]
        )
    if given := [argument(parameter).model_dump() for parameter in profile.parameter_profiles]:
        yield "rois.command.set_parameter", lambda ref: {"component_ref": ref, "parameters": given}


def general() -> Iterator[Shape]:
    """Return the cases that are the same for every type."""
    # Bound first and released last: what has to be bound is meanwhile.
    for method in ("bind", "get_parameter"):
        yield f"rois.command.{method}", lambda ref: {"component_ref": ref}
    for method in ("rois.system.get_profile", "rois.command.search", "rois.command.bind_any"):
        yield method, lambda ref: {"condition": condition(ref)}
    yield "openrois.directory.list", lambda ref: {"component_types": [ref]}
    yield "openrois.directory.read", lambda ref: {"engine_ids": [ref.partition("/")[0]]}
    yield "openrois.directory.profiles", lambda ref: {"component_refs": [ref]}
    yield "rois.stream.connect_stream", lambda ref: {"component_ref": ref}
    for verb in ("disconnect_stream", "suspend_stream", "resume_stream", "query_stream_status"):
        yield f"rois.stream.{verb}", lambda ref: {"stream_id": ref}
    yield "rois.stream.report_playout", lambda ref: {"stream_id": ref, "milliseconds": 40}
    yield "rois.stream.set_consent", lambda ref: {"stream_id": ref, "consent": ["live"]}
    yield "signaling.answer", lambda ref: {"peer_id": ref or "x", "generation": 1, "sdp": "v=0"}
    yield "signaling.candidate", lambda ref: {"peer_id": ref or "x", "generation": 1, "candidate": None}
    yield "signaling.restart", lambda ref: {"peer_id": ref or "x"}
    for verb in ("grant", "decline"):
        yield f"openrois.lease.{verb}", lambda ref: {"request_id": ref}
    yield "openrois.lease.token", lambda _ref: {}
    yield "rois.event.unsubscribe", lambda ref: {"subscribe_id": ref}
    yield "rois.command.get_command_result", lambda ref: {"command_id": ref}
    yield "rois.event.get_event_detail", lambda ref: {"event_id": ref}
    yield "rois.system.get_error_detail", lambda ref: {"error_id": ref}
    for method in ("rois.system.connect", "openrois.hello", "signaling.ice_servers"):
        params = {"version": "1"} if method == "openrois.hello" else {}
        yield method, lambda _ref, params=params: params  # type: ignore[misc]


@dataclass
class Verdicts:
    """What was wrong.

    Attributes:
        cases: how many were judged.
        allowed: that should have been refused.
        denied: that should not.
    """

    cases: int = 0
    allowed: list[str] = field(default_factory=list)
    denied: list[str] = field(default_factory=list)

    def judge(self, case: str, *, expected: str | int, answered: str | int) -> None:
        self.cases += 1
        if answered != expected:
            wrong = self.allowed if answered == "OK" or expected != "OK" else self.denied
            wrong.append(f"{case}: {answered}, not {expected}")


@dataclass
class Trial:
    """One role with a scope of one component."""

    where: Place
    wire: Wire
    letter: str
    kind: ComponentType
    verdicts: Verdicts

    @property
    def ref(self) -> str:
        """The only component in scope."""
        return f"{FLEET}/{self.kind.name}"

    async def run(self) -> None:
        shapes = [*general(), *messages(self.kind.profile())]
        beside = cycle(f"{FLEET}/{kind.name}" for kind in BASIC_COMPONENTS if kind is not self.kind)
        for method, build in shapes:
            await self.ask(method, build(self.ref), RULES[method].present)
            for other in (f"{HIDDEN}/{self.kind.name}", next(beside), f"{FLEET}/nothing"):
                await self.ask(method, build(other), RULES[method].absent, other)
            malformed = build(self.ref) | {"extra": self.ref}
            await self.ask(method, malformed, -32602)
            await self.ask(method, {"component_ref": 5}, -32602)
        for method, build in general() if self.kind in _OF_EACH_CLASS else ():
            for text in _NO_REF:
                # An id of signaling that is too long is refused as such, an empty one is no id.
                if not (method.startswith("signaling.") and len(text) > 256):
                    await self.ask(method, build(text), RULES[method].absent, text)
        hidden = f"{HIDDEN}/{self.kind.name}"
        await self.ask("rois.command.release", {"component_ref": hidden}, "UNSUPPORTED", hidden)
        await self.ask("rois.command.release", {"component_ref": self.ref}, "OK")
        await self.ask("rois.system.disconnect", {}, "OK")

    async def ask(self, method: str, params: Any, expected: str | int, named: str = "") -> None:
        rule = RULES[method]
        self.where.reached()
        frames = await self.wire.ask(method, params)
        answer = json.loads(frames[-1])
        code = answer["result"]["return_code"] if "result" in answer else answer["error"]["code"]
        if expected == "-":
            expected = rule.present
        case = f"{self.letter} with scope {self.ref} {method} {str(params)[:200]}"
        allowed = self.letter in rule.roles
        self.verdicts.judge(case, expected=expected if allowed else "UNSUPPORTED", answered=code)
        if code == "OK" and method in REACHES:
            # What was accepted begins when the reply has left.
            await asyncio.sleep(0)
            await asyncio.sleep(0)
        reached = self.where.reached()
        may_reach = {(REACHES[method], self.ref)} if allowed and method in REACHES else set()
        if method == "rois.command.execute" and "connect_stream" in str(params):
            may_reach |= {("query", self.ref), ("rois.stream.connect_stream", self.ref)}
        if method == "openrois.stop_all":
            # The holder of a part of an engine stops the whole of it, and can do nothing else to the rest.
            may_reach = {("invoke", f"{FLEET}/{kind.name}") for kind in _ACTING} if allowed else set()
        if not reached <= may_reach:
            self.verdicts.allowed.append(f"{case} reached {reached}")
        told = "".join(frames).replace(named, "") if named else "".join(frames)
        if HIDDEN in told or _NAMES.search(told.replace(self.ref, "")):
            self.verdicts.allowed.append(f"{case} tells of what is hidden: {told[:300]}")


@pytest.mark.parametrize("letter", ROLES)
async def test_every_role(letter: str) -> None:
    verdicts = Verdicts()
    async with place(FLEET, HIDDEN) as where:
        for kind in BASIC_COMPONENTS:
            async with where.application(principal(ROLES[letter], f"{FLEET}/{kind.name}", rank="person")) as wire:
                await Trial(where, wire, letter, kind, verdicts).run()
    assert (verdicts.allowed[:20], verdicts.denied[:20]) == ([], [])
    assert verdicts.cases > 3_500
