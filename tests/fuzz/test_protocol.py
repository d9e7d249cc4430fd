"""Whatever arrives, the protocol answers it or drops it, in bounded words."""

import json
from typing import Any

from hypothesis import example, given, settings
from hypothesis import strategies as st

from openrois.jsonrpc.protocol import ErrorResponse, Notification, Peer, Request, Response, Violation

CODES = {-32700, -32600}

scalars = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20)
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=8,
)
members = st.sampled_from(["jsonrpc", "id", "method", "params", "result", "error", "x"])
envelopes = st.dictionaries(members, values | st.just("2.0") | st.just(1), max_size=7)
nearly = st.fixed_dictionaries(
    {"jsonrpc": st.just("2.0")},
    optional={
        "id": values | st.just(1),
        "method": st.text(max_size=8),
        "params": values,
        "result": values,
        "error": values,
    },
)


def check(text: str) -> None:
    peer = Peer()
    peer.request("asked", {})
    outcome = peer.receive(text)
    assert isinstance(outcome, Request | Notification | Response | ErrorResponse | Violation)
    if isinstance(outcome, Request):
        echoed = json.loads(Peer.response(outcome.id, {}))["id"]
        assert echoed == outcome.id
        assert type(echoed) is type(outcome.id)
    if isinstance(outcome, Violation):
        assert len(outcome.reason) < 300
        if outcome.answer is not None:
            outcome.answer.encode()
            answer = json.loads(outcome.answer)
            assert set(answer) == {"jsonrpc", "id", "error"}
            assert set(answer["error"]) == {"code", "message"}
            assert answer["error"]["code"] in CODES


@settings(max_examples=35)
@given(st.text())
@example("[" * 100_000)
@example('{"a":' * 100_000)
@example("1" * 10_000)
@example('"\\ud800"')
def test_any_text(text: str) -> None:
    check(text)


@settings(max_examples=50)
@given(envelopes | nearly)
def test_any_envelope(envelope: dict[str, Any]) -> None:
    check(json.dumps(envelope))


@settings(max_examples=50)
@given(nearly, st.data())
def test_any_damaged_envelope(envelope: dict[str, Any], data: st.DataObject) -> None:
    text = json.dumps(envelope, ensure_ascii=False)
    at = data.draw(st.integers(0, len(text)))
    until = data.draw(st.integers(at, min(len(text), at + 5)))
    check(text[:at] + data.draw(st.text(max_size=3)) + text[until:])
