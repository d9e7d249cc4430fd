"""The envelope rules of JSON-RPC 2.0, without a connection."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from openrois.jsonrpc.protocol import (
    INVALID_PARAMS,
    INVALID_REQUEST,
    PARSE_ERROR,
    ErrorResponse,
    Notification,
    Peer,
    Request,
    Response,
    Violation,
    decode,
    encode,
)


def violation(text: str) -> dict[str, Any]:
    """Receive something wrong and return the answer to it."""
    outcome = Peer().receive(text)
    assert isinstance(outcome, Violation)
    assert outcome.answer is not None
    answer: dict[str, Any] = json.loads(outcome.answer)
    assert answer["jsonrpc"] == "2.0"
    return answer


@pytest.mark.parametrize(
    "text",
    ["", "{", "nonsense", '{"id":NaN}', '{"id":-Infinity}', "[" * 20_000, '{"id":' + "9" * 5000 + "}", "\ufeff{}"],
    ids=["empty", "cut", "word", "nan", "infinity", "deep", "many digits", "byte order mark"],
)
def test_what_is_not_json_is_a_parse_error_with_id_null(text: str) -> None:
    answer = violation(text)
    assert answer == {"jsonrpc": "2.0", "id": None, "error": {"code": PARSE_ERROR, "message": "Parse error"}}


@pytest.mark.parametrize("text", ["[]", '[{"jsonrpc":"2.0","id":1,"method":"m"}]', "1", '"text"', "null", "true"])
def test_batches_and_what_is_no_object_are_invalid(text: str) -> None:
    answer = violation(text)
    assert (answer["id"], answer["error"]["code"]) == (None, INVALID_REQUEST)


@pytest.mark.parametrize(
    ("envelope", "echoed"),
    [
        ('"jsonrpc":"1.0","id":7,"method":"m"', 7),
        ('"id":"a","method":"m"', "a"),
        ('"jsonrpc":2.0,"id":7,"method":"m"', 7),
        ('"jsonrpc":"2.0","id":7,"method":5', 7),
        ('"jsonrpc":"2.0","id":null,"method":null', None),
        ('"jsonrpc":"2.0","id":true,"method":"m"', None),
        ('"jsonrpc":"2.0","id":[1],"method":"m"', None),
        ('"jsonrpc":"2.0","id":{},"method":"m"', None),
        ('"jsonrpc":"2.0","id":1e999,"method":"m"', None),
        ('"jsonrpc":"2.0","id":3', 3),
        ('"jsonrpc":"2.0"', None),
    ],
)
def test_a_wrong_envelope_is_invalid_and_a_usable_id_is_echoed(envelope: str, echoed: object) -> None:
    answer = violation("{" + envelope + "}")
    assert (answer["id"], answer["error"]["code"]) == (echoed, INVALID_REQUEST)


@pytest.mark.parametrize(
    ("written", "read"), [('"x"', "x"), ("5", 5), ("-0", 0), ("2.5", 2.5), ("null", None), ('""', ""), ("1e3", 1000.0)]
)
def test_a_request_keeps_the_type_of_its_id(written: str, read: object) -> None:
    request = Peer().receive(f'{{"jsonrpc":"2.0","id":{written},"method":"m","params":{{"a":1}}}}')
    assert request == Request(read, "m", {"a": 1})  # type: ignore[arg-type]
    assert isinstance(request, Request)
    assert type(request.id) is type(read)


@pytest.mark.parametrize("params", ["", ',"params":null', ',"params":{}'])
def test_missing_and_null_params_are_an_empty_object(params: str) -> None:
    assert Peer().receive(f'{{"jsonrpc":"2.0","id":1,"method":"m"{params}}}') == Request(1, "m", {})
    assert Peer().receive(f'{{"jsonrpc":"2.0","method":"m"{params}}}') == Notification("m", {})


@pytest.mark.parametrize("params", ["[]", "[1]", "1", '"text"', "false"])
def test_params_that_are_no_object_are_left_to_the_handler(params: str) -> None:
    request = Peer().receive(f'{{"jsonrpc":"2.0","id":1,"method":"m","params":{params}}}')
    assert request == Request(1, "m", json.loads(params))


def test_a_notification_with_such_params_cannot_be_answered() -> None:
    outcome = Peer().receive('{"jsonrpc":"2.0","method":"m","params":[]}')
    assert isinstance(outcome, Violation)
    assert outcome.answer is None


def test_other_members_of_an_envelope_are_ignored() -> None:
    assert Peer().receive('{"jsonrpc":"2.0","id":1,"method":"m","x":1}') == Request(1, "m", {})


def test_requests_have_ids_of_their_own_and_each_answer_counts_once() -> None:
    peer = Peer()
    (first, text), (second, _) = peer.request("m", {"a": 1}), peer.request("m", {})
    assert json.loads(text) == {"jsonrpc": "2.0", "id": first, "method": "m", "params": {"a": 1}}
    assert first != second
    answer = json.dumps({"jsonrpc": "2.0", "id": second, "result": None})
    assert peer.receive(answer) == Response(second, None)
    again = peer.receive(answer)
    assert isinstance(again, Violation)
    assert again.answer is None


@pytest.mark.parametrize("request_id", ['"1"', "99", "null", "1.0", "1.5"])
def test_an_unrequested_answer_is_not_answered(request_id: str) -> None:
    peer = Peer()
    peer.request("m", {})
    for member in ('"result":1', '"error":{"code":1,"message":"x"}'):
        outcome = peer.receive(f'{{"jsonrpc":"2.0","id":{request_id},{member}}}')
        assert isinstance(outcome, Violation)
        assert outcome.answer is None


def test_the_reason_of_a_violation_does_not_grow_with_the_message() -> None:
    outcome = Peer().receive(json.dumps({"jsonrpc": "2.0", "id": "x" * 50_000, "result": 1}))
    assert isinstance(outcome, Violation)
    assert len(outcome.reason) < 200


def test_a_forgotten_request_is_not_outstanding() -> None:
    peer = Peer()
    request_id, _ = peer.request("m", {})
    peer.abandon_request(request_id)
    peer.abandon_request(request_id)
    assert isinstance(peer.receive(f'{{"jsonrpc":"2.0","id":{request_id},"result":1}}'), Violation)


def test_error_answers() -> None:
    peer = Peer()
    request_id, _ = peer.request("m", {})
    text = Peer.error(request_id, INVALID_PARAMS, "Invalid params", [{"path": "a", "message": "b"}])
    expected = ErrorResponse(request_id, INVALID_PARAMS, "Invalid params", [{"path": "a", "message": "b"}])
    assert peer.receive(text) == expected


@pytest.mark.parametrize(
    "error", ["1", "{}", '{"code":"x","message":"y"}', '{"code":1}', '{"code":1,"message":2}', "null"]
)
def test_a_malformed_error_object_still_ends_the_request(error: str) -> None:
    peer = Peer()
    request_id, _ = peer.request("m", {})
    outcome = peer.receive(f'{{"jsonrpc":"2.0","id":{request_id},"error":{error}}}')
    assert isinstance(outcome, ErrorResponse)
    assert outcome.code == INVALID_REQUEST


def test_error_beside_result_wins_unless_it_is_null() -> None:
    peer = Peer()
    (first, _), (second, _) = peer.request("m", {}), peer.request("m", {})
    error = '"error":{"code":-1,"message":"no"}'
    assert peer.receive(f'{{"jsonrpc":"2.0","id":{first},"result":1,{error}}}') == ErrorResponse(first, -1, "no")
    assert peer.receive(f'{{"jsonrpc":"2.0","id":{second},"result":1,"error":null}}') == Response(second, 1)


def test_what_is_written() -> None:
    assert json.loads(Peer.response("x", {"a": None})) == {"jsonrpc": "2.0", "id": "x", "result": {"a": None}}
    assert json.loads(Peer.notification("m", {"a": 1})) == {"jsonrpc": "2.0", "method": "m", "params": {"a": 1}}
    assert json.loads(Peer.error(None, -1, "no")) == {
        "jsonrpc": "2.0",
        "id": None,
        "error": {"code": -1, "message": "no"},
    }


def test_params_may_be_text_already() -> None:
    assert Peer.notification("m", '{"a":1}') == '{"jsonrpc":"2.0","method":"m","params":{"a":1}}'


def test_text_is_written_as_it_is_and_numbers_json_does_not_have_are_refused() -> None:
    assert encode({"a": "お早う"}) == '{"a":"お早う"}'
    with pytest.raises(ValueError):
        encode({"a": float("nan")})


def test_half_a_surrogate_pair_is_echoed_in_a_form_that_utf_8_can_carry() -> None:
    request = Peer().receive(r'{"jsonrpc":"2.0","id":"\ud800é","method":"m"}')
    assert isinstance(request, Request)
    text = Peer.response(request.id, {})
    text.encode()
    assert json.loads(text)["id"] == "\ud800é"


class Told(BaseModel):
    text: str
    number: float = 1


def test_a_model_is_written_where_an_object_stands() -> None:
    assert json.loads(Peer.notification("m", Told(text="é")))["params"] == {"text": "é", "number": 1}
    assert json.loads(Peer.response(1, Told(text="\ud800")))["result"] == {"text": "\ud800", "number": 1}
    assert json.loads(Peer.response(1, {"a": Told(text="NaN, Infinity")}))["result"]["a"]["text"] == "NaN, Infinity"
    with pytest.raises(TypeError, match="object"):
        encode({"a": object()})


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
        max_leaves=20,
    ),
    st.integers(0, 200),
    st.text(max_size=2),
)
def test_the_quick_reader_reads_as_the_exact_one(value: Any, at: int, noise: str) -> None:
    """Exactly what Python's own reader takes for JSON is JSON, also in a text with random changes."""
    text = json.dumps(value)
    for candidate in (text, text[:at] + noise + text[at:]):
        try:
            expected = json.dumps(json.loads(candidate, parse_constant=_refuse), allow_nan=True)
        except (ValueError, RecursionError):
            with pytest.raises((ValueError, RecursionError)):
                decode(candidate)
        else:
            assert json.dumps(decode(candidate), allow_nan=True) == expected


def _refuse(name: str) -> None:
    raise ValueError(name)
