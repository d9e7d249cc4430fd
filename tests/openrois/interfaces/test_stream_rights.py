"""The operator of an engine and visitors send microphone and camera into it; listeners receive what visitors send."""

import json
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from openrois.auth.principal import LOCAL, Principal, Role
from openrois.gateway.token_expiry import TokenExpiry
from openrois.interfaces.stream_rights import may_be_uplink
from openrois.types.messages import Parameter
from tests.openrois.interfaces.test_loans import Recorded
from tests.openrois.interfaces.test_matrix import unit
from tests.support.authorization import Place, Watched, Wire, place, principal

CAMERA, NAVIGATION = "fleet/video_streaming", "fleet/navigation"


def transport(text: str) -> Parameter:
    return Parameter(name="transport_parameters", data_type_ref="string", value=text)


@pytest.mark.parametrize(
    "text",
    ["", "{}", '{"direction": "recvonly"}', '{"input": true}', '{"direction": "recvonly", "more": [1, {"a": 2}]}'],
)
def test_what_is_received(text: str) -> None:
    assert not may_be_uplink([transport(text)])
    assert not may_be_uplink([])
    assert not may_be_uplink(
        [Parameter(name="encoding_parameters", data_type_ref="", value='{"direction": "sendonly"}')]
    )


@pytest.mark.parametrize(
    "text",
    [
        '{"direction": "sendonly"}',
        '{"direction": "sendrecv"}',
        '{"direction": "RECVONLY"}',
        '{"direction": null}',
        '{"direction": ["recvonly"]}',
        '{"direction": "recvonly", "direction": "sendonly"}',
        '{"direction": "sendonly", "direction": "recvonly"}',
        '{"dir\\u0065ction": "sendonly"}',
        '[{"direction": "recvonly"}]',
        '"recvonly"',
        "{",
        "no JSON",
        "[" * 20_000,
        "NaN",
    ],
)
def test_what_could_be_sent(text: str) -> None:
    assert may_be_uplink([transport(text)])


def test_a_parameter_that_stands_twice_is_not_believed() -> None:
    assert may_be_uplink([transport(""), transport('{"direction": "recvonly"}')])


@settings(max_examples=50)
@given(st.recursive(st.none() | st.booleans() | st.text(), lambda inner: st.dictionaries(st.text(), inner)))
@example({"direction": "sendonly"})
def test_whatever_another_reader_takes_for_sending_is_an_uplink(told: Any) -> None:
    text = json.dumps(told)
    direction = told.get("direction", "recvonly") if isinstance(told, dict) else "none"
    assert may_be_uplink([transport(text)]) == (direction != "recvonly")


SENDING = '{"direction": "sendonly", "consent": ["live"]}'
LISTENING = '{"visitor_ref": "urn:x", "purposes": ["live"]}'


def connecting(text: str = '{"direction": "sendonly"}', ref: str = CAMERA) -> dict[str, Any]:
    return {"component_ref": ref, "parameters": [transport(text).model_dump()]}


async def strictly(wire: Wire, text: str = '{"direction": "sendonly"}') -> str:
    """Connect a stream in strict RoIS; return how the command ended."""
    parameters = [transport(text).model_dump()]
    set_first = await wire.result("rois.command.set_parameter", {"component_ref": CAMERA, "parameters": parameters})
    assert await wire.completed(set_first["command_id"]) == "OK"
    command = unit(CAMERA, "connect_stream")
    assert await wire.code("rois.command.execute", {"command_unit_list": [command]}) == "OK"
    return await wire.completed(command["command_id"])


def sent(where: Place) -> int:
    """Return how many streams there are."""
    return len(where.robots["fleet"].streams.streams)


@pytest.mark.parametrize("role", ["operator", "administrator"])
async def test_only_the_operator_sends(role: str) -> None:
    async with place("fleet") as where, where.application(principal(role, "*")) as wire:
        assert await wire.code("rois.stream.connect_stream", connecting()) == "OUT_OF_RESOURCES"
        assert await wire.code("rois.stream.connect_stream", connecting('{"direction": "recvonly"}')) == "OK"
        assert await strictly(wire) == "OUT_OF_RESOURCES"
        assert sent(where) == 1
        await wire.result("rois.command.bind", {"component_ref": CAMERA})
        assert await wire.code("rois.stream.connect_stream", connecting()) == "OUT_OF_RESOURCES"
        await wire.result("rois.command.bind", {"component_ref": NAVIGATION})
        assert await wire.code("rois.stream.connect_stream", connecting()) == "OK"
        assert await strictly(wire, '{"direction": "sendrecv"}') == "OK"
        assert sent(where) == 3


async def test_a_viewer_only_receives() -> None:
    async with place("fleet") as where, where.application(principal("viewer", "*")) as wire:
        assert await wire.code("rois.stream.connect_stream", connecting()) == "UNSUPPORTED"
        assert await wire.code("rois.stream.connect_stream", connecting("")) == "OK"
        assert sent(where) == 1


def told_role(where: Place) -> str | None:
    """Return the role that the engine was told with the last stream."""
    role: str | None = where.robots["fleet"].streams.calls[-1][1].get("role")
    return role


async def test_a_visitor_sends_without_binding_and_commands_nothing() -> None:
    async with place("fleet") as where, where.application(principal("visitor", "*")) as wire:
        assert await wire.code("rois.stream.connect_stream", connecting(SENDING)) == "OK"
        assert told_role(where) == "visitor"
        assert await wire.code("rois.stream.connect_stream", connecting("")) == "OK"
        assert told_role(where) is None
        for method in ("bind", "release"):
            assert await wire.code(f"rois.command.{method}", {"component_ref": NAVIGATION}) == "UNSUPPORTED"
        assert await wire.code("openrois.stop_all", {"component_ref": NAVIGATION}) == "UNSUPPORTED"
        assert sent(where) == 2


async def refusal(wire: Wire, text: str, ref: str = CAMERA) -> tuple[str | int, str]:
    """Connect a stream in vain; return the code and the reason."""
    await wire.result("openrois.hello", {"version": "1"})
    code = await wire.code("rois.stream.connect_stream", connecting(text, ref))
    return code, str((await wire.until("openrois.reason"))["reason"])


async def test_a_visitor_that_states_no_consent_is_told_to() -> None:
    async with place("fleet") as where, where.application(principal("visitor", "*")) as wire:
        for text in (
            '{"direction": "sendonly"}',
            '{"direction": "sendonly", "consent": null}',
            '{"direction": "sendonly", "consent": [], "consent": ["live"]}',
        ):
            code, reason = await refusal(wire, text)
            assert (code, reason) == (
                "BAD_PARAMETER",
                "a visitor states what it consents to before it sends: set consent in transport_parameters",
            )
        assert sent(where) == 0


@pytest.mark.parametrize("scope", ["other/*", "fleet/video_streaming", "fleet/navigation"])
async def test_out_of_scope_a_listener_receives_nothing(scope: str) -> None:
    async with place("fleet", "other") as where, where.application(principal("listener", scope)) as wire:
        code, reason = await refusal(wire, LISTENING, "fleet/audio_streaming")
        assert (code, "there is no component" in reason) == ("UNSUPPORTED", True)
        assert sent(where) == 0


@pytest.mark.parametrize("role", ["visitor", "operator", "administrator"])
async def test_a_visitor_cannot_send_in_the_name_of_another(role: str) -> None:
    text = '{"direction": "sendonly", "consent": ["live"], "visitor_ref": "urn:x", "purposes": ["live"]}'
    async with place("fleet") as where, where.application(principal(role, "*")) as wire:
        await wire.code("rois.command.bind", {"component_ref": NAVIGATION})
        await wire.code("rois.stream.connect_stream", connecting(text))
        # The engine is not told that it listens, and refuses to relay.
        assert told_role(where) == "visitor"


def _is_end(told: dict[str, Any]) -> bool:
    return bool(told["status"].endswith("NOT_CONNECTED"))


async def test_no_application_says_itself_that_it_listens() -> None:
    async with place("fleet") as where, where.application(principal("viewer", "*")) as wire:
        told = {**connecting(LISTENING), "role": "listener"}
        assert await wire.code("rois.stream.connect_stream", told) == -32602
        assert sent(where) == 0


@pytest.mark.parametrize("how", ["disconnect", "by the engine", "leave", "another token"])
async def test_the_audit_trail_has_visitors_their_consent_and_listeners(how: str) -> None:
    trail = Recorded()
    async with place("fleet", audit=trail) as where:
        expiry = TokenExpiry(both("visitor", "listener"))
        async with where.application(expiry) as wire:
            sent_id, heard_id = [
                (await wire.result("rois.stream.connect_stream", connecting(text)))["stream_id"]
                for text in (SENDING, LISTENING)
            ]
            for consent in (["live", "agent"], []):
                await wire.result("rois.stream.set_consent", {"stream_id": sent_id, "consent": consent})
            match how:
                case "disconnect":
                    for stream_id in (sent_id, heard_id):
                        await wire.result("rois.stream.disconnect_stream", {"stream_id": stream_id})
                case "by the engine":
                    for stream_id in (sent_id, heard_id):
                        where.robots["fleet"].streams.end(stream_id)
                        await wire.until("rois.stream.notify_stream_status", _is_end)
                case "another token":
                    expiry.replace(principal("viewer", "*"))
                    for _ in range(2):
                        await wire.until("rois.stream.notify_stream_status", _is_end)
        connect, state, subject = "rois.stream.connect_stream", "rois.stream.set_consent", CAMERA
        assert [(method, ref, detail) for _, method, ref, detail in trail.lines[:4]] == [
            (connect, subject, f"{sent_id} consents to live"),
            (connect, subject, f"{heard_id} of urn:x for live"),
            (state, subject, f"{sent_id} consents to live agent"),
            (state, subject, f"{sent_id} consents to nothing"),
        ]
        assert sorted(each[1:] for each in trail.lines[4:]) == sorted(
            ("stream.ended", subject, stream_id) for stream_id in (sent_id, heard_id)
        )


async def test_out_of_scope_a_visitor_sends_nothing() -> None:
    async with place("fleet") as where, where.application(principal("visitor", "fleet/video_streaming")) as wire:
        assert await wire.code("rois.stream.connect_stream", connecting(SENDING, "fleet/audio_streaming")) == (
            "UNSUPPORTED"
        )
        assert sent(where) == 0


async def test_a_viewer_is_told_which_roles_send() -> None:
    async with place("fleet") as where, where.application(principal("viewer", "*")) as wire:
        code, reason = await refusal(wire, SENDING)
        assert code == "UNSUPPORTED"
        assert reason.endswith("sending needs the role visitor, or operator")


def both(*roles: str) -> Principal:
    return Principal("anna", frozenset(Role(role) for role in roles), ("*",))


async def test_what_an_operator_sends_as_a_visitor_outlives_its_control() -> None:
    async with place("fleet") as where, where.application(both("operator", "visitor")) as wire:
        await wire.result("rois.command.bind", {"component_ref": NAVIGATION})
        kept = await wire.result("rois.stream.connect_stream", connecting(SENDING))
        lost = await wire.result("rois.stream.connect_stream", connecting(ref="fleet/audio_streaming"))
        assert told_role(where) is None
        assert await wire.code("rois.command.release", {"component_ref": NAVIGATION}) == "OK"
        ended = await wire.until("rois.stream.notify_stream_status", lambda told: told["status"].endswith("CONNECTED"))
        assert ended["stream_id"] == lost["stream_id"]
        assert list(where.robots["fleet"].streams.streams) == [kept["stream_id"]]


async def test_an_operator_may_state_its_consent_too() -> None:
    async with place("fleet") as where, where.application(principal("operator", "*")) as wire:
        assert await wire.code("rois.stream.connect_stream", connecting(SENDING)) == "OUT_OF_RESOURCES"
        await wire.result("rois.command.bind", {"component_ref": NAVIGATION})
        assert await wire.code("rois.stream.connect_stream", connecting(SENDING)) == "OK"
        assert told_role(where) == "visitor"


@pytest.mark.parametrize("role", ["viewer", "visitor", "maintenance", "operator", "administrator"])
async def test_only_a_listener_receives_what_visitors_send(role: str) -> None:
    async with place("fleet") as where, where.application(principal(role, "*")) as wire:
        code, reason = await refusal(wire, LISTENING)
        assert code == "UNSUPPORTED"
        assert role == "maintenance" or "use a token that has it" in reason
        assert sent(where) == 0


async def test_a_listener_sends_nothing_and_its_engine_is_told_that_it_listens() -> None:
    async with place("fleet") as where, where.application(principal("listener", "*")) as wire:
        assert await wire.code("rois.stream.connect_stream", connecting(LISTENING)) == "OK"
        assert told_role(where) == "listener"
        assert await wire.code("rois.stream.connect_stream", connecting(SENDING)) == "UNSUPPORTED"


@pytest.mark.parametrize(("role", "text"), [("visitor", SENDING), ("listener", LISTENING)])
async def test_streams_end_with_the_role_that_they_need(role: str, text: str) -> None:
    expiry = TokenExpiry(principal(role, "*"))
    async with place("fleet") as where, where.application(expiry) as wire:
        kept = await wire.result("rois.stream.connect_stream", connecting(""))
        lost = await wire.result("rois.stream.connect_stream", connecting(text))
        expiry.replace(principal("viewer", "*"))
        ended = await wire.until("rois.stream.notify_stream_status", lambda told: told["status"].endswith("CONNECTED"))
        assert ended["stream_id"] == lost["stream_id"]
        assert list(where.robots["fleet"].streams.streams) == [kept["stream_id"]]


@pytest.mark.parametrize("text", [SENDING, LISTENING])
async def test_without_authentication_every_application_visits_and_listens(text: str) -> None:
    async with place("fleet") as where, where.application(LOCAL) as wire:
        assert await wire.code("rois.stream.connect_stream", connecting(text)) == "OK"
        assert told_role(where) == ("listener" if text == LISTENING else "visitor")


async def test_another_engine_is_another_matter() -> None:
    async with place("fleet", "other") as where, where.application(principal("operator", "*")) as wire:
        await wire.result("rois.command.bind", {"component_ref": "other/navigation"})
        assert await wire.code("rois.stream.connect_stream", connecting()) == "OUT_OF_RESOURCES"
        assert await wire.code("rois.stream.connect_stream", connecting(ref="other/video_streaming")) == "OK"


@pytest.mark.parametrize("scope", [(CAMERA,), (CAMERA, "fleet/person_detecter")])
async def test_of_an_engine_that_shows_nothing_to_hold_the_role_is_enough(scope: tuple[str, ...]) -> None:
    for robot in (Watched("fleet"), Watched("fleet")):
        async with place(robot) as where, where.application(principal("operator", *scope)) as wire:
            assert await wire.code("rois.stream.connect_stream", connecting()) == "OK"


@pytest.mark.parametrize("who", [LOCAL])
async def test_without_authentication_no_lease_is_needed(who: Principal) -> None:
    async with place("fleet") as where, where.application(who) as wire:
        assert await wire.code("rois.stream.connect_stream", connecting()) == "OK"


@pytest.mark.parametrize("how", ["release", "disconnect", "take", "borrow"])
async def test_losing_control_ends_uplinks(how: str) -> None:
    async with place("fleet", "other") as where, where.application(principal("operator", "*")) as wire:
        await wire.result("openrois.hello", {"version": "1"})
        for ref in (NAVIGATION, "fleet/move", "other/navigation"):
            assert await wire.code("rois.command.bind", {"component_ref": ref}) == "OK"
        received = await wire.result("rois.stream.connect_stream", connecting(""))
        for ref in (CAMERA, "other/video_streaming"):
            assert await wire.code("rois.stream.connect_stream", connecting(ref=ref)) == "OK"
        assert await wire.code("rois.command.release", {"component_ref": "fleet/move"}) == "OK"
        assert sent(where) == 2
        if how == "take":
            async with where.application(principal("administrator", "*", subject="root")) as other:
                assert await other.code("openrois.lease.take", {"component_ref": NAVIGATION}) == "OK"
        elif how == "borrow":
            async with where.application(principal("operator", "*", subject="ann", rank="person")) as other:
                assert await other.code("openrois.lease.borrow", {"component_ref": NAVIGATION}) == "OK"
                assert await wire.code("rois.stream.connect_stream", connecting()) == "OUT_OF_RESOURCES"
        elif how == "release":
            assert await wire.code("rois.command.release", {"component_ref": NAVIGATION}) == "OK"
        else:
            assert await wire.code("rois.system.disconnect", {}) == "OK"
            assert (sent(where), len(where.robots["other"].streams.streams)) == (0, 0)
            return
        ended = "STREAMING_NOT_CONNECTED"
        await wire.until("rois.stream.notify_stream_status", lambda told: told["status"] == ended)
        assert list(where.robots["fleet"].streams.streams) == [received["stream_id"]]
        assert len(where.robots["other"].streams.streams) == 1


async def test_losing_control_while_the_stream_is_made_ends_it() -> None:
    async with place("fleet") as where, where.application(principal("operator", "*")) as wire:
        streams = where.robots["fleet"].streams
        await wire.result("rois.command.bind", {"component_ref": NAVIGATION})
        streams.may_answer.clear()
        await wire.stream.send(
            json.dumps({"jsonrpc": "2.0", "id": 7, "method": "rois.stream.connect_stream", "params": connecting()})
        )
        await streams.called.wait()
        await wire.stream.send(
            json.dumps(
                {"jsonrpc": "2.0", "id": 8, "method": "rois.command.release", "params": {"component_ref": NAVIGATION}}
            )
        )
        answers = {}
        while 8 not in answers:
            frame = json.loads(await wire.stream.receive())
            answers[frame.get("id")] = frame
        streams.may_answer.set()
        while 7 not in answers:
            frame = json.loads(await wire.stream.receive())
            answers[frame.get("id")] = frame
        assert answers[7]["result"]["return_code"] == "OUT_OF_RESOURCES"
        assert sent(where) == 0


async def test_without_authentication_an_uplink_outlives_a_lease() -> None:
    async with place("fleet") as where, where.application(LOCAL) as wire:
        await wire.result("rois.command.bind", {"component_ref": NAVIGATION})
        assert await wire.code("rois.stream.connect_stream", connecting()) == "OK"
        assert await wire.code("rois.command.release", {"component_ref": NAVIGATION}) == "OK"
        assert await wire.code("rois.command.search", {}) == "OK"
        assert sent(where) == 1
