import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_signaling import messages
from openrois_signaling.messages import Answer, Bye, Candidate, CaptureClocks, IceServer, Offer, Restart
from pydantic import BaseModel, ValidationError

SECTION = {
    "mid": "0",
    "stream_id": "engine/1",
    "component_ref": "engine/video_streaming",
    "kind": "video",
    "direction": "recvonly",
}
OFFER = {"peer_id": "engine/p", "generation": 1, "sdp": "v=0", "streams": [SECTION]}
ANSWER = {"peer_id": "engine/p", "generation": 1, "sdp": "v=0"}
CANDIDATE = {
    "peer_id": "engine/p",
    "generation": 2,
    "candidate": "candidate:1 1 udp 1 192.0.2.1 9 typ host",
    "sdp_mid": "0",
    "sdp_m_line_index": 0,
}
CLOCK = {"mid": "0", "ssrc": 2**32 - 1, "clock_rate": 90_000, "rtp_origin": 0, "wall": 1_800_000_000_000}
EXAMPLES: list[tuple[type[BaseModel], dict[str, object]]] = [
    (Offer, OFFER),
    (Offer, {**OFFER, "replaces": "engine/o"}),
    (Answer, ANSWER),
    (Candidate, CANDIDATE),
    (Candidate, {"peer_id": "engine/p", "generation": 1, "candidate": None}),
    (Restart, {"peer_id": "engine/p"}),
    (CaptureClocks, {"peer_id": "engine/p", "senders": [CLOCK]}),
    (Bye, {"peer_id": "engine/p", "reason": "because"}),
    (IceServer, {"urls": ["turn:turn.example.org"], "username": "u", "credential": "c"}),
    (IceServer, {"urls": ["stun:stun.example.org"]}),
]


@pytest.mark.parametrize(("model", "params"), EXAMPLES)
def test_the_wire_form_comes_back_as_it_was(model: type[BaseModel], params: dict[str, object]) -> None:
    message = model.model_validate(params)
    assert isinstance(message, Offer | Answer | Candidate | Restart | CaptureClocks | Bye | IceServer)
    assert message.wire() == params


@pytest.mark.parametrize(("model", "params"), EXAMPLES)
def test_unknown_fields_are_refused(model: type[BaseModel], params: dict[str, object]) -> None:
    with pytest.raises(ValidationError, match="Extra inputs"):
        model.model_validate({**params, "client_id": "x"})


@pytest.mark.parametrize(("model", "params"), EXAMPLES)
def test_messages_do_not_change(model: type[BaseModel], params: dict[str, object]) -> None:
    message = model.model_validate(params)
    with pytest.raises(ValidationError, match="frozen"):
        setattr(message, next(iter(params)), "other")


def test_absent_optional_fields_do_not_stand_on_the_wire_and_the_last_candidate_does() -> None:
    assert "replaces" not in Offer.model_validate(OFFER).wire()
    last = Candidate(peer_id="p", generation=1, candidate=None, sdp_mid="0")
    assert last.wire() == {"peer_id": "p", "generation": 1, "candidate": None, "sdp_mid": "0"}


@pytest.mark.parametrize("generation", [0, -1, True, 1.0, "1", None, 2**31])
def test_a_generation_is_a_positive_integer_and_nothing_that_only_looks_like_one(generation: object) -> None:
    with pytest.raises(ValidationError, match="generation"):
        Answer.model_validate({**ANSWER, "generation": generation})


@pytest.mark.parametrize(
    ("model", "params", "field", "limit"),
    [
        (Answer, ANSWER, "sdp", messages.SDP_LIMIT),
        (Offer, OFFER, "sdp", messages.SDP_LIMIT),
        (Candidate, CANDIDATE, "candidate", messages.CANDIDATE_LIMIT),
        (Candidate, CANDIDATE, "sdp_mid", messages.MID_LIMIT),
        (Restart, {}, "peer_id", messages.ID_LIMIT),
    ],
)
def test_limits_count_bytes_and_say_so(
    model: type[BaseModel], params: dict[str, object], field: str, limit: int
) -> None:
    model.model_validate({**params, field: "x" * limit})
    for text in ("x" * (limit + 1), "é" * (limit // 2 + 1)):
        with pytest.raises(ValidationError, match=field) as refusal:
            model.model_validate({**params, field: text})
        assert [error["type"] for error in refusal.value.errors()] == [messages.TOO_LONG]


def test_an_offer_has_at_most_sixteen_streams() -> None:
    sections = [{**SECTION, "mid": str(mid)} for mid in range(17)]
    assert len(Offer.model_validate({**OFFER, "streams": sections[:16]}).streams) == 16
    with pytest.raises(ValidationError, match="streams"):
        Offer.model_validate({**OFFER, "streams": sections})


def test_of_very_many_sections_that_do_not_fit_one_is_told() -> None:
    with pytest.raises(ValidationError) as refused:
        Offer.model_validate({"peer_id": "e/p", "generation": 1, "sdp": "v=0", "streams": [{}] * 20_000})
    assert refused.value.error_count() < 10


def test_a_candidate_names_its_section() -> None:
    unplaced = {key: value for key, value in CANDIDATE.items() if not key.startswith("sdp_m")}
    with pytest.raises(ValidationError, match="neither sdp_mid nor sdp_m_line_index"):
        Candidate.model_validate(unplaced)
    for place in ({"sdp_mid": "1"}, {"sdp_m_line_index": 3}):
        Candidate.model_validate({**unplaced, **place})


def test_credentials_do_not_show_in_logs() -> None:
    assert "secret" not in repr(IceServer(urls=("turn:turn.example.org",), username="u", credential="secret"))


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
        max_leaves=5,
    )
)
def test_whatever_a_field_holds_it_is_taken_or_refused(value: object) -> None:
    for field in CANDIDATE:
        try:
            taken = Candidate.model_validate({**CANDIDATE, field: value})
        except ValidationError:
            continue
        assert Candidate.model_validate(taken.wire()) == taken
