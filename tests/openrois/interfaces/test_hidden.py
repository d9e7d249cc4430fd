"""What is out of scope looks like what does not exist: byte for byte, in every answer and in every silence."""

import json
import random
import re
import string
from collections.abc import Callable
from typing import Any, Final

import pytest

from openrois.auth.principal import Role
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.gateway.applications import serve_application
from openrois.gateway.token_expiry import TokenExpiry
from openrois.transport.websocket import dial
from openrois.types.codes import ErrorType
from openrois.types.references import new_id
from tests.openrois.interfaces.test_matrix import Shape, condition, general, messages, unit
from tests.support.authorization import Watched, Wire, place, principal
from tests.support.serving import serving

PAIRS: Final = 1_000
SHAPES_OF_A_PAIR: Final = 6

KINDS: Final = {kind.name: kind for kind in BASIC_COMPONENTS}
SHOWN: Final = [kind for kind in BASIC_COMPONENTS if kind.code in ("Navigation", "PersonDetection", "VideoStreaming")]
SCOPE: Final = tuple(f"fleet/{kind.name}" for kind in SHOWN)
OUT: Final = [
    *(f"fleet/{kind.name}" for kind in BASIC_COMPONENTS if kind not in SHOWN),
    *(f"hidden/{kind.name}" for kind in BASIC_COMPONENTS),
]
IN: Final = SCOPE[0]
_CAMERA: Final = condition(SCOPE[2])
MINTING: Final = ("openrois.hello", "openrois.lease.token")
"""Methods that are about no component, and answer something new each time."""
_COMMAND_ID: Final = re.compile(r'"command_id": "c\d+"')


def compound(ref_kind: str) -> list[Shape]:
    """Return the cases in which a ref stands beside others, in a pattern, or leads an id."""
    command = next((each.name for each in KINDS[ref_kind].profile().command_profiles), "start")
    query = KINDS[ref_kind].profile().query_profiles[0].name
    typed = KINDS[ref_kind].profile().identifier.code
    known = [{"component_ref": f"fleet/{SHOWN[0].name}", "command_type": "stop", "command_id": "first"}]

    def another(ref: str) -> dict[str, Any]:
        return unit(ref, command) | {"command_id": "second"}

    def like(method: str, **more: str) -> Shape:
        return method, lambda ref: {**more, "condition": f"component_ref LIKE '%{ref}%'"}

    def narrowed(method: str, **more: str) -> Shape:
        return method, lambda ref: {**more, "condition": f"{condition(ref)} AND component_type = '{typed}'"}

    conditioned: list[Shape] = []
    for make in (like, narrowed):
        conditioned += [
            make("rois.command.search"),
            make("rois.system.get_profile"),
            make("rois.command.bind_any"),
            make("rois.query.query", query_type=query),
            make("rois.query.query", query_type="component_status"),
            make("rois.event.subscribe", event_type="notify_stream_status"),
        ]
    return [
        *conditioned,
        ("rois.command.execute", lambda ref: {"command_unit_list": [*known, another(ref)]}),
        ("rois.command.execute", lambda ref: {"command_unit_list": [{"command_list": [*known, another(ref)]}]}),
        ("rois.command.execute", lambda ref: {"command_unit_list": [another(ref), {"command_list": known}]}),
        ("rois.command.execute", lambda ref: {"command_unit_list": [another(ref) | {"command_type": "no such"}]}),
        ("rois.command.execute", lambda ref: {"command_unit_list": [another(ref) | {"command_id": ""}]}),
        *(
            ("rois.command.execute", lambda ref, v=verb: {"command_unit_list": [another(ref) | {"command_type": v}]})
            for verb in ("connect_stream", "suspend_stream", "set_parameter")
        ),
        ("rois.command.set_parameter", lambda ref: {"component_ref": ref, "parameters": []}),
        ("rois.command.release", lambda ref: {"component_ref": ref}),
        (
            "rois.query.query",
            lambda ref: {"query_type": "get_stream_status", "condition": f"{condition(ref)} AND stream_id = '{ref}'"},
        ),
        (
            "rois.query.query",
            lambda ref: {
                "query_type": "get_stream_status",
                "condition": f"{condition(SCOPE[2])} AND stream_id = '{ref}'",
            },
        ),
        *(
            (f"rois.stream.{verb}", lambda ref: {"stream_id": f"{ref.partition('/')[0]}/{'0' * 32}"})
            for verb in ("suspend_stream", "query_stream_status")
        ),
        (
            "rois.stream.connect_stream",
            lambda ref: {
                "component_ref": ref,
                "parameters": [
                    {"name": "transport_parameters", "data_type_ref": "", "value": '{"direction": "sendonly"}'}
                ],
            },
        ),
    ]


def shapes(ref: str) -> list[Shape]:
    """Return every case of a component of the same type as the one that `ref` names."""
    name = ref.partition("/")[2]
    return [*general(), *messages(KINDS[name].profile()), *compound(name)]


def absent(chance: random.Random, hidden: str) -> str:
    """Return a ref that names nothing: in the engine of the hidden component where it shows others, or in none."""
    name = "".join(chance.choices(string.ascii_lowercase, k=chance.randint(12, 24)))
    return f"fleet/{name}" if hidden.startswith("fleet/") else f"{name}/{hidden.partition('/')[2]}"


async def answered(wire: Wire, method: str, build: Callable[[str], Any], ref: str) -> list[str]:
    """Ask about a ref and return all that comes, with the ref and its engine's id taken out."""
    params = json.loads(_COMMAND_ID.sub('"command_id": "same"', json.dumps(build(ref))))
    engine_id = ref.partition("/")[0]
    return [frame.replace(ref, "<ref>").replace(f"{engine_id}/", "<id>/") for frame in await wire.ask(method, params)]


async def compare(wire: Wire, method: str, build: Callable[[str], Any], hidden: str, missing: str) -> None:
    """Ask the same of both and compare."""
    told = [await answered(wire, method, build, ref) for ref in (hidden, missing)]
    assert told[0] == told[1], f"{method} tells {hidden} from {missing}"


@pytest.mark.parametrize("role", [Role.VIEWER, pytest.param(Role.OPERATOR, marks=pytest.mark.long)])
async def test_a_thousand_pairs(role: Role) -> None:
    chance, tried = random.Random(6), set()
    async with place("fleet", "hidden") as where:
        for start in range(0, PAIRS, 10):  # More in one session would be too many messages of signaling.
            async with where.application(principal(role, *SCOPE)) as wire:
                await wire.result("openrois.hello", {"version": "1"})
                for number in range(start, start + 10):
                    hidden = OUT[number % len(OUT)]
                    cases = shapes(hidden)
                    for step in range(SHAPES_OF_A_PAIR):
                        index = (number // len(OUT) * SHAPES_OF_A_PAIR + step) % len(cases)
                        tried.add((hidden, index))
                        method, build = cases[index]
                        if method not in MINTING:
                            await compare(wire, method, build, hidden, absent(chance, hidden))
        assert {ref for _, ref in where.reached()} <= set(SCOPE)
    assert tried == {(hidden, index) for hidden in OUT for index in range(len(shapes(hidden)))}


async def test_over_two_sockets() -> None:
    """Two applications, each over its own: one asks for what is hidden, the other for what is not there."""
    chance, hidden = random.Random(7), "hidden/navigation"
    who = principal("operator", *SCOPE)
    async with (
        place("fleet", "hidden") as where,
        serving(lambda socket: serve_application(where.host, socket, TokenExpiry(who))) as url,
        dial(url) as near,
        dial(url) as far,
    ):
        one, other = Wire(near), Wire(far)
        for wire in (one, other):
            await wire.result("openrois.hello", {"version": "1"})
        for method, build in shapes(hidden):
            if method not in MINTING:
                told = await answered(other, method, build, absent(chance, hidden))
                assert await answered(one, method, build, hidden) == told, method


async def test_a_gateway_with_hidden_engines_and_one_without_are_the_same() -> None:
    """The whole conversation, profiles and notifications too, of one that sees a part and of one for whom it is all."""
    script: list[tuple[str, dict[str, Any]]] = [
        ("openrois.hello", {"version": "1"}),
        ("rois.system.connect", {}),
        ("rois.system.get_profile", {}),
        ("rois.command.search", {}),
        ("rois.system.get_profile", {"condition": "component_ref LIKE '%'"}),
        ("openrois.directory.list", {}),
        ("openrois.directory.read", {"engine_ids": ["hidden", "fleet", "gateway"]}),
        ("openrois.directory.profiles", {"component_refs": ["hidden/navigation", IN]}),
        ("rois.command.bind_any", {"condition": ""}),
        ("rois.query.query", {"query_type": "component_status", "condition": ""}),
        ("rois.query.query", {"query_type": "get_parameter", "condition": ""}),
        ("rois.event.subscribe", {"event_type": "person_detected"}),
        ("rois.command.execute", {"command_unit_list": [unit(IN, "stop") | {"command_id": "hidden/c"}]}),
        ("signaling.ice_servers", {}),
        ("rois.command.release", {"component_ref": IN}),
        ("rois.system.disconnect", {}),
    ]
    who = principal("operator", "fleet/*", "hidden/none")
    heard = []
    for robots in ((Watched("fleet", SHOWN),), (Watched("fleet", SHOWN), Watched("hidden"))):
        async with place(*robots) as where, where.application(who) as wire:
            told = []
            for method, params in script:
                told += [_without_chance(frame) for frame in await wire.ask(method, params)]
            told.append(await wire.result("rois.command.get_command_result", {"command_id": "hidden/c"}))
            heard.append(told)
    assert heard[0] == heard[1]


def _without_chance(frame: str) -> dict[str, Any]:
    """Return a frame without what is made anew each time."""
    read: dict[str, Any] = json.loads(frame)
    for minted in ("client_id", "subscribe_id"):
        if minted in read.get("result", {}):
            read["result"][minted] = ""
    return read


async def test_nothing_is_told_of_what_comes_and_goes_out_of_sight() -> None:
    async with place("fleet", "hidden") as where, where.application(principal("viewer", *SCOPE)) as wire:
        await wire.result("rois.system.connect", {})
        engine = where.host.engine
        late = Watched("late")
        await engine.attach(late)
        await engine.refresh(late)
        engine.detach(late)
        engine.detach(where.robots["hidden"])
        for ref in OUT:
            engine.report(ErrorType.COMPONENT_INTERNAL_ERROR, "hidden", ref)
        frames = await wire.ask("rois.command.search", {})
        assert len(frames) == 1
        engine.detach(where.robots["fleet"])
        frames = await wire.ask("rois.command.search", {})
        assert [json.loads(frame).get("method") for frame in frames] == ["rois.system.profile_changed", None]


async def test_no_engine_out_of_sight_is_named() -> None:
    async with place("fleet", "hidden") as where, where.application(principal("viewer", *SCOPE)) as wire:
        await wire.result("openrois.hello", {"version": "1", "extensions": ["openrois.directory"]})
        engine = where.host.engine
        late = Watched("late")
        await engine.attach(late)
        engine.detach(late)
        engine.detach(where.robots["hidden"])
        assert len(await wire.ask("rois.command.search", {})) == 1
        engine.detach(where.robots["fleet"])
        told, _ = map(json.loads, await wire.ask("rois.command.search", {}))
        assert (told["method"], told["params"]["gone"]) == ("openrois.directory.changed", ["fleet"])


async def test_a_component_that_was_lost_out_of_sight_is_not_told_of() -> None:
    async with place("fleet", "hidden") as where, where.application(principal("viewer", *SCOPE)) as wire:
        await wire.result("openrois.hello", {"version": "1"})
        where.host.engine.detach(where.robots["hidden"], lost="without a word")
        for missing in ("absent/navigation", "absent/x"):
            await compare(
                wire,
                "rois.query.query",
                lambda ref: {"query_type": "component_status", "condition": condition(ref)},
                "hidden/navigation",
                missing,
            )


async def test_faults_of_engines() -> None:
    """Of an engine with something in sight one hears, without what its sentence says of the rest."""
    engine = Watched("hidden").robot
    async with place("fleet", "hidden") as where, where.application(principal("viewer", *SCOPE)) as wire:
        await wire.result("rois.system.connect", {})
        where.host.crashed(f"start of {OUT[0]}")
        told = await wire.until("rois.system.notify_error")
        results = (await wire.result("rois.system.get_error_detail", {"error_id": told["error_id"]}))["results"]
        assert {each["name"]: each["value"] for each in results}["description"] == "the engine has a fault"
        assert engine.engine_id not in json.dumps(results)


@pytest.mark.parametrize("role", [Role.VIEWER, Role.ADMINISTRATOR])
async def test_ids_of_others_are_like_unknown_ids(role: Role) -> None:
    """Of a stream, a command, an event, a subscription, an error: the id of another session, and an unknown one."""
    async with place("fleet") as where:
        person, navigation, camera = SCOPE
        owner, thief = principal("operator", "*", subject="owner"), principal(role, "*", subject="thief")
        async with where.application(owner) as mine, where.application(thief) as wire:
            for each in (mine, wire):
                await each.result("openrois.hello", {"version": "1"})
            await mine.result("rois.command.bind", {"component_ref": navigation})
            stream_id = (await mine.result("rois.stream.connect_stream", {"component_ref": camera}))["stream_id"]
            offer = await mine.until("signaling.offer")
            await mine.result("rois.event.subscribe", {"event_type": "person_detected", "condition": condition(person)})
            where.robots["fleet"].robot.parts["PersonDetection"].tell("person_detected")
            event = await mine.until("rois.event.notify_event")
            await mine.result(
                "rois.command.execute", {"command_unit_list": [unit(person, "stop") | {"command_id": "k"}]}
            )
            assert await mine.completed("k") == "OK"
            where.host.engine.report(ErrorType.COMPONENT_INTERNAL_ERROR, "a fault", navigation)
            fault = await mine.until("rois.system.notify_error")
            for method, name, known in (
                ("rois.stream.suspend_stream", "stream_id", stream_id),
                ("rois.stream.query_stream_status", "stream_id", stream_id),
                ("rois.stream.disconnect_stream", "stream_id", stream_id),
                ("rois.event.unsubscribe", "subscribe_id", event["subscribe_id"]),
                ("rois.event.get_event_detail", "event_id", event["event_id"]),
                ("rois.command.get_command_result", "command_id", "k"),
                ("rois.system.get_error_detail", "error_id", fault["error_id"]),
                ("signaling.restart", "peer_id", offer["peer_id"]),
            ):
                texts = []
                for value in (known, new_id("fleet") if "/" in known else "n"):
                    frames = await wire.ask(method, {name: value})
                    texts.append([frame.replace(value, "<id>") for frame in frames])
                if known != "k":
                    assert texts[0] == texts[1], method
                assert (await mine.result(method, {name: known}))["return_code"] == "OK"
