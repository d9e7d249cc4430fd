"""The black-box suite: our gateway passes, one of the base wire passes, and a wrong one fails the right check."""

from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import replace
from typing import Any

import pytest
from openrois_conformance.checks import ALL_CHECKS
from openrois_conformance.deviation import Deviation
from openrois_conformance.stage import Check, Needs, Stage
from openrois_conformance.suite import Outcome, Verdict, run_checks, visit

from openrois.gateway.server import Gateway
from openrois.jsonrpc.method_tables import BoundMethods
from openrois.jsonrpc.session import RpcSession
from openrois.types.codes import ComponentStatus
from tests.support import deployment
from tests.support.bent import Bent, bent
from tests.support.components import Lamp

pytestmark = pytest.mark.extra(name="gateway")

PATIENCE = 20.0
"""Seconds that an answer may take on a busy machine."""
SHORT = 2.0
"""Seconds after which what a wrong gateway does not say is given up."""
QUICK = 3.0
"""Seconds that an adapter has for an answer."""


@pytest.fixture
async def gateway() -> AsyncIterator[Gateway]:
    async with deployment.gateway(adapter_timeout=QUICK) as running:
        yield running


def address(gateway: Gateway) -> str:
    return gateway.url.replace("http", "ws")


async def tried(url: str, *check_ids: str, patience: float = PATIENCE, **options: Any) -> dict[str, Verdict]:
    checks = [check for check in ALL_CHECKS if not check_ids or check.id in check_ids]
    async with visit(url, patience, adapter=options.pop("adapter", True), **options) as place:
        return {verdict.check.id: verdict for verdict in await run_checks(place, checks)}


def of(verdicts: dict[str, Verdict], outcome: Outcome) -> dict[str, str]:
    return {name: f"{v.expected} / {v.came}" for name, v in verdicts.items() if v.outcome is outcome}


async def test_our_gateway_passes(gateway: Gateway) -> None:
    async with deployment.adapter(gateway, Lamp()):
        verdicts = await tried(address(gateway), component="robot/lamp")
        assert of(verdicts, Outcome.FAILED) == {}
        assert of(verdicts, Outcome.NOT_RUN) == {}
        assert [remark for verdict in verdicts.values() for remark in verdict.remarks] == []
        await deployment.until(gateway.engine, lambda ids: ids == ("gateway", "robot"))
        async with deployment.application(gateway) as app:
            assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"


async def test_a_gateway_of_the_base_wire_alone_passes(gateway: Gateway, monkeypatch: pytest.MonkeyPatch) -> None:
    speak_the_base_alone(monkeypatch)
    verdicts = await tried(address(gateway))
    assert of(verdicts, Outcome.FAILED) == {}
    skipped = of(verdicts, Outcome.NOT_RUN)
    needs = {Needs.EXTENSIONS, Needs.LEASES, Needs.DIRECTORY, Needs.COMPONENT}
    extended = {check.id for check in ALL_CHECKS if check.needs & needs}
    assert skipped.keys() == extended
    assert "openrois.hello" in skipped["stream-life"]


def speak_the_base_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make gateways know no extension, neither towards applications nor towards adapters."""

    async def no_greeting(*_asked: object) -> None:
        """Say nothing."""

    monkeypatch.setattr("openrois.gateway.applications.stream_methods", lambda _app: BoundMethods())
    monkeypatch.setattr("openrois.gateway.applications._SIGNALING", {})
    monkeypatch.setattr("openrois.remote.remote_offer.RemoteOffer._greet", no_greeting)


async def test_without_an_adapter_what_needs_none_is_tried(gateway: Gateway) -> None:
    verdicts = await tried(address(gateway), adapter=False)
    assert of(verdicts, Outcome.FAILED) == {}
    assert len(of(verdicts, Outcome.PASSED)) >= 50
    assert "--no-adapter" in of(verdicts, Outcome.NOT_RUN)["bind-exclusive"]
    assert gateway.engine.directory.profile.engine_ids() == ("gateway",)


@pytest.mark.parametrize(
    ("status", "remarks"),
    [
        (ComponentStatus.READY, ()),
        (ComponentStatus.ERROR, ("the component's status is ERROR: its events were not tried",)),
    ],
)
async def test_events_of_a_component_that_cannot_work_are_not_tried(
    gateway: Gateway, status: ComponentStatus, remarks: tuple[str, ...]
) -> None:
    lamp = Lamp()
    lamp.condition = lambda: status  # type: ignore[method-assign]
    async with deployment.adapter(gateway, lamp):
        verdicts = await tried(address(gateway), adapter=False, component="robot/lamp")
    assert of(verdicts, Outcome.FAILED) == {}
    assert verdicts["component-events"].remarks == remarks


async def test_a_component_that_says_it_can_work_and_refuses_subscribers_fails(gateway: Gateway) -> None:
    refuse = result(lambda result: {**result, "return_code": "ERROR"}, "rois.event.subscribe")
    async with deployment.adapter(gateway, Lamp()), bent(address(gateway), **refuse) as proxy:
        verdicts = await tried(proxy.url, "component-events", adapter=False, component="robot/lamp")
    assert "return_code of rois.event.subscribe" in of(verdicts, Outcome.FAILED)["component-events"]


async def test_a_component_that_is_not_there(gateway: Gateway) -> None:
    async with deployment.adapter(gateway, Lamp()):
        with pytest.raises(Deviation, match="the component robot/absent; came the components robot/lamp"):
            await tried(address(gateway), component="robot/absent")


async def test_a_server_that_does_not_answer_is_no_gateway() -> None:
    with pytest.raises(Deviation, match="an application to be let in"):
        await tried("ws://127.0.0.1:9/")


def result(changes: Callable[[dict[str, Any]], dict[str, Any]], *methods: str) -> dict[str, Any]:
    """Change the results of methods, of all unless some are named."""

    def bend(message: Any, method: str) -> Sequence[Any]:
        if "result" in message and (not methods or method in methods):
            return [{**message, "result": changes(message["result"])}]
        return [message]

    return {"to_application": bend}


def told(method: str, bend: Callable[[dict[str, Any]], Sequence[Any]]) -> dict[str, Any]:
    """Change the notifications of one method."""
    return {
        "to_application": lambda message, name: bend(message) if name == method and "id" not in message else [message]
    }


def asked(method: str, change: Callable[[dict[str, Any]], dict[str, Any]], leg: str = "to_gateway") -> dict[str, Any]:
    """Change what is asked by requests of one method."""
    return {leg: lambda message, name: [change(message)] if name == method and "method" in message else [message]}


def params(**changes: Any) -> Callable[[dict[str, Any]], dict[str, Any]]:
    return lambda message: {**message, "params": {**message["params"], **changes}}


def code(wrong: int, right: int) -> dict[str, Any]:
    """Answer one error in place of another."""

    def bend(message: Any, _method: str) -> Sequence[Any]:
        if message.get("error", {}).get("code") == right:
            return [{**message, "error": {**message["error"], "code": wrong}}]
        return [message]

    return {"to_application": bend}


class Swapped:
    """Holds a reply back until the next notification has passed."""

    def __init__(self, method: str) -> None:
        self._method = method
        self._held: list[Any] = []

    def __call__(self, message: Any, method: str) -> Sequence[Any]:
        if method == self._method and "method" not in message:
            self._held.append(message)
            return []
        held, self._held = self._held, []
        return [message, *held]


def number_ids(message: Any, _method: str) -> Sequence[Any]:
    return [{**message, "id": str(message["id"])}] if isinstance(message.get("id"), int) else [message]


def as_error(message: Any, _method: str) -> Sequence[Any]:
    """Say a failure in RoIS terms as early versions did."""
    outcome = message.get("result", {}).get("return_code", "OK")
    if outcome == "OK":
        return [message]
    error = {"code": -32602, "message": "failed", "data": {"return_code": outcome}}
    return [{"jsonrpc": "2.0", "id": message["id"], "error": error}]


def with_request(message: Any, _method: str) -> Sequence[Any]:
    return [message, {"jsonrpc": "2.0", "id": 1, "method": "rois.system.get_profile", "params": {}}]


def one_unit(message: dict[str, Any]) -> dict[str, Any]:
    units = [{**unit, "delay_time": 5} for unit in message["params"]["command_unit_list"]]
    return {**message, "params": {"command_unit_list": units}}


def no_delays(message: dict[str, Any]) -> dict[str, Any]:
    units = [
        {key: value for key, value in unit.items() if key != "delay_time"}
        for unit in message["params"]["command_unit_list"]
    ]
    return {**message, "params": {"command_unit_list": units}}


def renamed(refs: dict[str, Any]) -> dict[str, Any]:
    return {**refs, "component_ref_list": [f"gateway/{ref}" for ref in refs.get("component_ref_list", [])]}


def numbered(results: dict[str, Any]) -> dict[str, Any]:
    return {
        **results,
        "results": [
            {**each, "value": "1" if each["value"] == "READY" else each["value"]} for each in results["results"]
        ],
    }


def without(name: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    return lambda fields: {key: value for key, value in fields.items() if key != name}


def lax_numbers(message: Any, _method: str) -> Sequence[Any]:
    """Take what is no number for one: the proxy reads it so, and the gateway is asked another id."""
    nothing = isinstance(message.get("id"), float) and message["id"] - message["id"] != 0
    return [{**message, "id": "a number"}] if nothing else [message]


def strict_envelopes(message: Any, _method: str) -> Sequence[Any]:
    """Make what has superfluous members, or answers nothing, an invalid request."""
    wrong = set(message) - {"jsonrpc", "id", "method", "params"}
    return [{"jsonrpc": "2.0", "id": message["id"]}] if wrong else [message]


COMPLETED, EVENT = "rois.command.completed", "rois.event.notify_event"
CONNECT = {"method": "rois.system.connect", "params": {}}
TO_CONNECT: Callable[[dict[str, Any]], dict[str, Any]] = lambda message: {**message, **CONNECT}  # noqa: E731


def same_epoch(message: Any, _method: str) -> Sequence[Any]:
    """Say one epoch always."""
    for held in (message.get("result"), message):
        for name in ("lease", "params"):
            if held is not None and (held.get(name) or {}).get("epoch"):
                held[name]["epoch"] = 1
    return [{**message}]


def no_token(message: dict[str, Any]) -> dict[str, Any]:
    return TO_CONNECT(message) if message["params"] else message


CHANGED: dict[str, Any] = {"method": "openrois.lease.changed", "params": {}}


def query_instead(message: dict[str, Any]) -> dict[str, Any]:
    return {**message, "method": "openrois.lease.query"}


WRONG: list[tuple[str, dict[str, Any], str, str]] = [
    ("drops return_code", result(without("return_code"), "rois.command.bind"), "bind-exclusive", "a return_code"),
    ("adds a field", result(lambda r: {**r, "total": 1}, "rois.command.search"), "search", "total: Extra inputs"),
    ("says null for a list", result(lambda r: {**r, "results": None}, "rois.query.query"), "query", "results: Input"),
    ("says a number for a name", result(numbered, "rois.query.query"), "query-status", '"READY"'),
    ("rewrites references", result(renamed, "rois.command.search"), "search", "every component of the adapter"),
    ("grants what is held", result(lambda r: {**r, "return_code": "OK"}, "rois.command.bind"), "bind-exclusive",
     "OUT_OF_RESOURCES"),
    ("tells before it answers", {"to_application": Swapped("rois.command.execute")}, "execute-order",
     "the reply of execute before its `completed`"),
    ("tells events before it answers", {"to_application": Swapped("rois.event.subscribe")}, "subscribe-order",
     "the reply of subscribe before its events"),
    ("completes twice", told(COMPLETED, lambda m: [m, m]), "execute-order", "one `completed` for the command c0"),
    ("completes with another status", told(COMPLETED, lambda m: [params(status="ERROR")(m)]), "execute-order",
     '"status": "OK"'),
    ("completes with results", told(COMPLETED, lambda m: [params(results=[])(m)]), "execute-order", "results: Extra"),
    ("completes never", told(COMPLETED, lambda _m: []), "execute-results", "a frame within"),
    ("tells a foreign event id", told(EVENT, lambda m: [params(event_id="robot/evt-1")(m)]), "subscribe",
     "the event_id, unchanged from the adapter"),
    ("tells an unknown event id", told(EVENT, lambda m: [params(event_id="x/1")(m)]), "event-detail",
     "the return_code of rois.event.get_event_detail"),
    ("tells another's subscription", told(EVENT, lambda m: [params(subscribe_id="x")(m)]), "subscribe",
     "the subscribe_id"),
    ("tells events twice", told(EVENT, lambda m: [m, m]), "subscribe-only-subscribers", "no notification"),
    ("tells no change of the tree", told("rois.system.profile_changed", lambda _m: []), "profile-changed",
     "a frame within"),
    ("answers unknown methods otherwise", code(-32600, -32601), "frame-unknown-method", "-32601"),
    ("answers misfits otherwise", code(-32603, -32602), "params-misfit", "-32602"),
    ("answers garbage otherwise", code(-32600, -32700), "frame-not-json", "-32700"),
    ("answers no data", {"to_application": lambda m, _n: [{**m, "error": without("data")(m["error"])}]
                         if "error" in m else [m]}, "params-misfit-named", "a list of path and message"),
    ("says failures as errors", {"to_application": as_error}, "bind-unknown", "a result of rois.command.bind"),
    ("changes the type of ids", {"to_application": number_ids}, "frame-id-echo", "the id of the answer to id 7"),
    ("answers twice", {"to_application": lambda m, _n: [m, m] if "result" in m else [m]}, "many-requests",
     "one answer to each request"),
    ("has an envelope of its own", {"to_application": lambda m, _n: [{**m, "time": 1}]}, "frames-text",
     "the members of a JSON-RPC response"),
    ("asks applications", {"to_application": with_request}, "frames-text", "no request of the gateway"),
    ("speaks an older dialect", told(EVENT, lambda m: [{**m, "method": "rois.event.notify"}]), "subscribe",
     "one of the notifications of the wire"),
    ("notifies extensions to all", told(COMPLETED, lambda m: [
        {**m, "method": "signaling.bye", "params": {"peer_id": "x", "reason": "x"}}, m]), "execute-order",
     "no notification of an extension"),
    ("forgets to release", asked("rois.command.release", TO_CONNECT), "bind-exclusive", "OK"),
    ("forgets to unsubscribe", asked("rois.event.unsubscribe", TO_CONNECT), "unsubscribe", "no notification"),
    ("knows no delays", asked("rois.command.execute", no_delays), "sequence-delay", "delays of 60 and 120 ms"),
    ("delays at the adapter", asked("rois.command.execute", one_unit, "to_adapter"), "adapter-execute",
     "the delay_time to be null"),
    ("asks for half a profile", asked("rois.system.get_profile", params(condition="component_ref = 'x'"), "to_adapter"),
     "adapter-asked-first", "the params"),
    ("keeps an epoch", {"to_application": same_epoch}, "lease-exclusive", "whether the epoch has grown"),
    ("notifies leases to all", told(COMPLETED, lambda m: [{**m, **CHANGED}, m]),
     "lease-base", "no notification of an extension"),
    ("lets all grant", asked("openrois.lease.grant", TO_CONNECT), "lease-hand-over",
     "the return_code of openrois.lease.grant"),
    ("knows no positions", result(lambda r: {**r, "lease": {**r["lease"], "position": 1}}, "openrois.lease.request"),
     "lease-queue", "the state, position and how many wait"),
    ("takes nothing", asked("openrois.lease.take", query_instead), "lease-take", "the state"),
    ("resumes nothing", asked("openrois.lease.resume", TO_CONNECT), "lease-resume", "the leases"),
    ("stops less", asked("openrois.stop_all", params(component_ref="gateway/nothing")), "stop-all",
     "the return_code of openrois.stop_all"),
    ("takes any token", asked("openrois.auth.refresh", no_token), "token-refresh",
     "the return_code of openrois.auth.refresh"),
    ("closes for no reason", {"close_code": 1000}, "adapter-bad-id", "the close code for the engine id ''"),
]  # fmt: skip


@pytest.mark.parametrize(("bends", "check_id", "words"), [each[1:] for each in WRONG], ids=[each[0] for each in WRONG])
async def test_a_gateway_that_is_wrong_is_told_so(
    gateway: Gateway, bends: dict[str, Any], check_id: str, words: str
) -> None:
    async with bent(address(gateway)) as proxy, visit(proxy.url, PATIENCE, adapter=True) as place:
        check = next(check for check in ALL_CHECKS if check.id == check_id)
        (before,) = await run_checks(place, [check])
        bend(proxy, **bends)
        hasty = replace(place, setting=replace(place.setting, patience=SHORT))
        (verdict,) = await run_checks(hasty, [check])
        bend(proxy)
    assert before.outcome is Outcome.PASSED, before
    assert verdict.outcome is Outcome.FAILED
    assert words in f"{verdict.expected} / {verdict.came}"
    assert verdict.frames


OTHERWISE: list[tuple[str, dict[str, Any], str, str]] = [
    ("events carry no results", told(EVENT, lambda m: [params(results=[])(m)]), "subscribe", "get_event_detail has"),
    ("details for all", result(lambda r: {**r, "return_code": "OK"}, "rois.event.get_event_detail"),
     "event-detail-of-others", "reads its details"),
    ("results for all", result(lambda r: {**r, "return_code": "OK"}, "rois.command.get_command_result"),
     "command-result-of-others", "reads its results"),
    ("integers are read laxly", asked("rois.command.execute", no_delays), "params-integers", "a delay_time of"),
    ("numbers are read laxly", {"to_gateway": lax_numbers}, "frame-not-a-number", "they are no JSON"),
    ("envelopes are strict", {"to_gateway": strict_envelopes}, "frame-extra-members", "further members"),
    ("foreign answers are answered", {"to_gateway": strict_envelopes}, "frame-stray-answers", "was not asked for"),
]  # fmt: skip


@pytest.mark.parametrize(("bends", "check_id", "words"), [e[1:] for e in OTHERWISE], ids=[e[0] for e in OTHERWISE])
async def test_what_may_be_done_otherwise_is_said(
    gateway: Gateway, bends: dict[str, Any], check_id: str, words: str
) -> None:
    async with bent(address(gateway), **bends) as proxy:
        verdict = (await tried(proxy.url, check_id))[check_id]
    assert verdict.outcome is Outcome.PASSED, verdict
    assert words in " ".join(verdict.remarks)


def bend(proxy: Bent, **bends: Any) -> None:
    """Let the proxy do what is given and nothing else."""
    for name, how in {**vars(Bent()), "url": proxy.url, **bends}.items():
        setattr(proxy, name, how)


STUBS: list[dict[str, Any]] = [
    {"result": {"return_code": "ERROR"}},
    {"result": {"return_code": "OK"}},
    {"error": {"code": -32603, "message": "no"}},
]

WITHOUT_APPLICATIONS = {
    "adapter-asked-first",
    "adapter-bad-id",
    "adapter-twice-in-itself",
    "adapter-foreign-component",
    "adapter-missing-profile",
    "adapter-no-profile",
}
"""Checks that look at an adapter's connection alone; gateways that are wrong there are above."""


@pytest.mark.long
async def test_no_check_passes_at_a_gateway_that_does_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever a gateway answers to everything, no check takes it for conformant."""
    always: set[str] = {check.id for check in ALL_CHECKS}
    seconds, sessions = QUICK, list[RpcSession]()

    def make(*arguments: Any, **options: Any) -> RpcSession:
        sessions.append(RpcSession(*arguments, **options))
        sessions[-1].call_timeout = seconds
        return sessions[-1]

    monkeypatch.setattr("openrois.gateway.adapters.RpcSession", make)
    async with (
        deployment.gateway() as gateway,
        bent(address(gateway)) as proxy,
        visit(proxy.url, SHORT, adapter=True) as place,
    ):
        assert place.missing.keys() == {Needs.COMPONENT}
        # The suite's own adapter is attached, however busy the machine is; from now on waits are short.
        seconds = sessions[0].call_timeout = 0.05
        setting = replace(place.setting, patience=0.05, component="robot/absent")
        hasty = replace(place, setting=setting, missing={})
        for answer in STUBS:
            bend(proxy, to_application=answering(answer))
            verdicts = await run_checks(hasty, ALL_CHECKS)
            always &= {verdict.check.id for verdict in verdicts if verdict.outcome is Outcome.PASSED}
        bend(proxy)
    assert always <= WITHOUT_APPLICATIONS


def answering(answer: dict[str, Any]) -> Callable[[Any, str], Sequence[Any]]:
    """Answer every request alike."""
    return lambda message, _method: [
        message if "method" in message else {"jsonrpc": "2.0", "id": message["id"], **answer}
    ]


async def test_an_adapter_that_is_not_taken_is_said(gateway: Gateway) -> None:
    async with bent(address(gateway), to_adapter=lambda _message, _method: []) as proxy:
        verdicts = await tried(proxy.url, "connect", "query", patience=0.3)
    assert verdicts["connect"].outcome is Outcome.PASSED
    assert verdicts["query"].outcome is Outcome.NOT_RUN
    assert "the suite's adapter was not taken" in verdicts["query"].came


async def test_a_check_that_breaks_is_one_failure(gateway: Gateway, monkeypatch: pytest.MonkeyPatch) -> None:
    """In its middle, or only when its connections are closed; the others are run."""

    async def broken(stage: Stage) -> None:
        raise AttributeError("'NoneType' object has no attribute 'call_soon'")

    async def breaking_at_its_end(stage: Stage) -> None:
        stage.stack.push_async_callback(broken, stage)

    monkeypatch.setattr(Stage, "clear", broken)
    plays = {"broken": broken, "at its end": breaking_at_its_end}
    checks = [Check(name, "", play, frozenset()) for name, play in plays.items()]
    sane = next(check for check in ALL_CHECKS if check.id == "connect")
    async with visit(address(gateway), PATIENCE, adapter=False) as place:
        verdicts = await run_checks(place, checks)
        monkeypatch.undo()
        (after,) = await run_checks(place, [sane])
    assert [verdict.outcome for verdict in verdicts] == [Outcome.FAILED] * 2
    assert all("call_soon" in verdict.came for verdict in verdicts)
    assert after.outcome is Outcome.PASSED


async def test_no_id_of_a_command_is_sent_by_two_checks_or_two_runs(gateway: Gateway) -> None:
    """As at a gateway that remembers ids for all applications."""
    names = ("execute-results", "execute-statuses")
    sent: list[set[str]] = []

    def note(message: Any, method: str) -> Sequence[Any]:
        if method == "rois.command.execute":
            sent[-1].update(unit["command_id"] for unit in message["params"]["command_unit_list"])
        return [message]

    async with bent(address(gateway), to_gateway=note) as proxy:
        for _ in range(2):
            for name in names:
                sent.append(set())
                assert (await tried(proxy.url, name))[name].outcome is Outcome.PASSED
    assert all(sent)
    assert len(set().union(*sent)) == sum(map(len, sent))


async def test_an_adapter_that_is_cut_off_fails_what_needs_it(gateway: Gateway) -> None:
    checks = [check for check in ALL_CHECKS if check.id in ("connect", "query")]
    async with visit(address(gateway), PATIENCE, adapter=True) as place:
        assert place.setting.probe is not None
        await place.setting.probe.socket.close()
        verdicts = {verdict.check.id: verdict for verdict in await run_checks(place, checks)}
    assert verdicts["connect"].outcome is Outcome.PASSED
    assert verdicts["query"].outcome is Outcome.FAILED
    assert "to stay connected" in verdicts["query"].expected
