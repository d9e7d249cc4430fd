"""What the suite takes from a gateway, and what it refuses."""

from typing import Any

import pytest
from openrois_conformance.deviation import Deviation
from openrois_conformance.strictness import (
    check_envelope,
    explained_by,
    is_extension,
    read_notification,
    read_result,
)

pytestmark = pytest.mark.extra(name="base")

OK = {"return_code": "OK"}
COMPLETED = {"command_id": "c", "status": "OK"}


@pytest.mark.parametrize(
    "message",
    [
        {"jsonrpc": "2.0", "id": 1, "result": OK},
        {"jsonrpc": "2.0", "id": None, "error": {"code": -32700, "message": "Parse error"}},
        {"jsonrpc": "2.0", "id": 1, "error": {"code": -32602, "message": "Invalid params", "data": []}},
        {"jsonrpc": "2.0", "method": "rois.command.completed", "params": COMPLETED},
        {"jsonrpc": "2.0", "method": "rois.system.profile_changed"},
    ],
)
def test_envelopes_that_are_taken(message: Any) -> None:
    check_envelope(message)


@pytest.mark.parametrize(
    ("message", "sentence"),
    [
        ([], "one JSON-RPC object"),
        ({"id": 1, "result": OK}, "one JSON-RPC object"),
        ({"jsonrpc": "2.0", "id": 1, "method": "m"}, "no request of the gateway"),
        ({"jsonrpc": "2.0", "method": 1}, "and no other"),
        ({"jsonrpc": "2.0", "method": "m", "params": []}, "and no other"),
        ({"jsonrpc": "2.0", "method": "m", "more": 1}, "and no other"),
        ({"jsonrpc": "2.0", "result": OK}, "and no other"),
        ({"jsonrpc": "2.0", "id": 1, "result": OK, "more": 1}, "and no other"),
        ({"jsonrpc": "2.0", "id": 1, "error": "bad"}, "and no other"),
        ({"jsonrpc": "2.0", "id": 1, "error": {"code": True, "message": "bad"}}, "and no other"),
        ({"jsonrpc": "2.0", "id": 1, "error": {"code": 1}}, "and no other"),
        ({"jsonrpc": "2.0", "id": 1, "error": {"code": 1, "message": "bad", "more": 1}}, "and no other"),
    ],
)
def test_envelopes_that_are_refused(message: Any, sentence: str) -> None:
    with pytest.raises(Deviation, match=sentence):
        check_envelope(message)


def test_a_result_has_every_field() -> None:
    assert read_result("rois.command.search", OK) == {"return_code": "OK", "component_ref_list": []}
    assert read_result("signaling.ice_servers", OK) == {"return_code": "OK", "ice_servers": [], "ttl": 0}


@pytest.mark.parametrize("result", [[], {}, {**OK, "more": 1}, {**OK, "component_ref_list": None}])
def test_results_that_are_refused(result: Any) -> None:
    with pytest.raises(Deviation, match=r"a result of rois\.command\.search"):
        read_result("rois.command.search", result)


def test_notifications() -> None:
    assert read_notification("rois.command.completed", COMPLETED, extended=False) == COMPLETED
    bye = {"peer_id": "p", "reason": "over"}
    assert read_notification("signaling.bye", bye, extended=True) == bye
    with pytest.raises(Deviation, match="that uses none"):
        read_notification("signaling.bye", bye, extended=False)
    with pytest.raises(Deviation, match="one of the notifications"):
        read_notification("rois.system.gossip", {}, extended=True)
    with pytest.raises(Deviation, match="status"):
        read_notification("rois.command.completed", {"command_id": "c", "status": 0}, extended=True)


def test_what_is_an_extension() -> None:
    assert is_extension("openrois.hello")
    assert is_extension("signaling.answer")
    assert not is_extension("rois.command.search")
    assert not is_extension("rois.system.gossip")


REFUSED = {"id": 7, "result": {"return_code": "ERROR"}}
FAILED = {"method": "rois.command.completed", "params": {"command_id": "c", "status": "ABORT"}}


def why(request_id: Any = None, command_id: str | None = None, reason: str = "it sleeps") -> dict[str, Any]:
    return {"request_id": request_id, "command_id": command_id, "reason": reason}


def test_a_reason_stands_right_before_what_it_explains() -> None:
    assert explained_by(why(request_id=7), REFUSED) == 7
    assert explained_by(why(command_id="c"), FAILED) == "c"


@pytest.mark.parametrize(
    ("told", "message"),
    [
        (why(request_id=7), FAILED),
        (why(request_id=8), REFUSED),
        (why(request_id=7), {"id": 7, "result": OK}),
        (why(request_id=7), {"id": 7, "error": {"code": -32603, "message": "no"}}),
        (why(command_id="c"), REFUSED),
        (why(command_id="d"), FAILED),
        (why(command_id="c"), {**FAILED, "params": COMPLETED}),
        (why(command_id="c"), {"method": "rois.system.profile_changed"}),
        (why(7, "c"), REFUSED),
        (why(7, "c"), FAILED),
        (why(request_id=7, reason="two\nlines"), REFUSED),
    ],
)
def test_reasons_that_are_refused(told: dict[str, Any], message: dict[str, Any]) -> None:
    with pytest.raises(Deviation, match=r"reason"):
        explained_by(told, message)
