"""Questions and answers about a STOP: what fits into notifications, and what is none."""

import pytest

from openrois.cluster.postgres.stop_messages import (
    MAX_PARTS,
    MAX_PAYLOAD,
    AnswerParts,
    StopAnswer,
    StopAsked,
    StopTold,
    answer_texts,
    question_text,
    read_message,
)

pytestmark = pytest.mark.extra(name="base")

ID = "0123456789abcdef" * 2
ASKED = StopAsked(id=ID, asker="front", owner="owner", engine_id="robot", subject="ann")
SPLIT = answer_texts(ASKED, StopAnswer(stopped=tuple("x" * 250 for _ in range(60))))


def assembled(texts: list[str]) -> StopAnswer | None:
    parts = AnswerParts("owner")
    answer = None
    for text in reversed(texts):
        assert len(text.encode()) <= MAX_PAYLOAD
        assert answer is None
        told = read_message(text)
        assert isinstance(told, StopTold)
        answer = parts.add(told)
    return answer


def test_a_question_is_read_as_it_was_written() -> None:
    assert read_message(question_text(ID, "front", "owner", "robot", "ann")) == ASKED
    ranked = read_message(question_text(ID, "front", "owner", "robot", "ann", "person"))
    assert ranked == ASKED.model_copy(update={"rank": "person"})
    numbered = read_message(question_text(ID, "front", "owner", "robot", "ann", stop_id="7"))
    assert numbered == ASKED.model_copy(update={"stop_id": "7"})


def test_a_long_subject_is_cut_and_the_question_fits() -> None:
    text = question_text(ID, "\U0001f916" * 128, "\U0001f916" * 128, "\U0001f916" * 128, *["\U0001f916" * 5000] * 2)
    assert len(text.encode()) <= MAX_PAYLOAD
    asked = read_message(text)
    assert isinstance(asked, StopAsked)
    assert asked.subject == "\U0001f916" * 256


@pytest.mark.parametrize("name", ["", "x" * 129])
def test_a_question_without_a_right_name_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="engine_id"):
        question_text(ID, "front", "owner", name, "ann")


@pytest.mark.parametrize(
    "answer",
    [
        StopAnswer(),
        StopAnswer(stopped=("robot/lamp", "robot/voice"), failed=("robot/arm",)),
        StopAnswer(problem="there is no engine 'robot'"),
        StopAnswer(stopped=("robot/\U0001f916",), unnamed=3, problem="not all \0"),
    ],
)
def test_a_short_answer_is_one_text(answer: StopAnswer) -> None:
    texts = answer_texts(ASKED, answer)
    assert len(texts) == 1
    assert assembled(texts) == answer


def test_a_long_answer_is_split_and_what_has_failed_comes_first() -> None:
    answer = StopAnswer(
        stopped=tuple(f"robot/{number}{'x' * 240}" for number in range(50)),
        failed=tuple(f"robot/{number}{'y' * 240}" for number in range(50)),
        problem="z" * 500,
    )
    texts = answer_texts(ASKED, answer)
    assert 3 < len(texts) <= MAX_PARTS
    assert "robot/0y" in texts[0]
    whole = assembled(texts)
    assert whole == StopAnswer(answer.stopped, answer.failed, problem="z" * 200)


def test_of_too_long_an_answer_the_rest_is_counted() -> None:
    answer = StopAnswer(
        stopped=tuple(f"robot/{'ü' * 200}{number}" for number in range(500)), failed=("robot/arm",), unnamed=2
    )
    texts = answer_texts(ASKED, answer)
    assert len(texts) == MAX_PARTS
    whole = assembled(texts)
    assert whole is not None
    assert whole.failed == ("robot/arm",)
    assert whole.stopped == answer.stopped[: len(whole.stopped)]
    assert len(whole.stopped) + whole.unnamed == 502
    assert len(whole.stopped) > 100


def test_a_name_that_fits_into_no_text_is_counted() -> None:
    whole = assembled(answer_texts(ASKED, StopAnswer(stopped=("x" * MAX_PAYLOAD, "robot/lamp"))))
    assert whole == StopAnswer(("robot/lamp",), unnamed=1)


def test_half_a_surrogate_pair_leaves_as_json_has_it() -> None:
    (text,) = answer_texts(ASKED, StopAnswer(stopped=("robot/\ud800",)))
    assert r"robot/\ud800" in text


@pytest.mark.parametrize(
    "text",
    [
        "",
        "nonsense",
        "asked",
        "asked {",
        "asked []",
        "asked {}",
        'asked {"id":"0","asker":"front","owner":"owner","engine_id":"robot","subject":"ann"}',
        f'asked {{"id":"{ID}","asker":"front","owner":"owner","engine_id":"{"x" * 200}","subject":"ann"}}',
        f'told {{"id":"{ID}","asker":"front","owner":"owner","part":8,"parts":9}}',
        f'told {{"id":"{ID}","asker":"front","owner":"owner","part":-1,"parts":1}}',
        f'told {{"id":"{ID}","asker":"front","owner":"owner","part":0,"parts":1,"stopped":7}}',
    ],
)
def test_what_is_no_message_is_none(text: str) -> None:
    assert read_message(text) is None


def test_fields_of_a_later_version_are_left_out() -> None:
    text = question_text(ID, "front", "owner", "robot", "ann")
    assert read_message(text[:-1] + ',"colour":"red"}') == ASKED


def test_what_another_gateway_answers_is_no_answer() -> None:
    parts = AnswerParts("another")
    for text in SPLIT:
        told = read_message(text)
        assert isinstance(told, StopTold)
        assert parts.add(told) is None


def test_parts_of_two_answers_are_not_mixed() -> None:
    parts = AnswerParts("owner")
    first = read_message(SPLIT[0])
    (other,) = answer_texts(ASKED, StopAnswer())
    alone = read_message(other)
    assert isinstance(first, StopTold)
    assert isinstance(alone, StopTold)
    assert parts.add(first) is None
    assert parts.add(alone) is None
    assert parts.add(first) is None
