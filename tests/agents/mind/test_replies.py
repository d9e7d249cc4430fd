"""Sentences of the mind without a language model."""

import pytest
from openrois_agents.mind import replies
from openrois_agents.mind.placing import Place
from openrois_agents.tools.answer import Answer


def test_a_list_reads_as_in_a_sentence() -> None:
    assert replies.listed([]) == ""
    assert replies.listed(["wave"]) == "wave"
    assert replies.listed(["wave", "bow"], "or") == "wave or bow"
    assert replies.listed(["wave", "bow", "nod"]) == "wave, bow and nod"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Unsupported: robot is held without what go_to needs", "I cannot do that with this body."),
        ("OutOfResources: robot was stopped by ann", "I cannot do that just now."),
        ("ComponentFailed: stuck 0.46 m before it", "That did not work."),
    ],
)
def test_a_failure_is_told_without_its_details(text: str, said: str) -> None:
    answer = Answer(text, {"failed": text.partition(":")[0]})
    assert replies.failed(answer)
    assert replies.refusal(answer) == said
    assert not replies.failed(Answer("robot did: wave.", {"body": "robot"}))


def test_what_a_body_can_do_follows_from_its_tools() -> None:
    assert replies.ability(("say",)) == "I can talk."
    assert replies.ability(("go_to", "gesture")) == "I can talk, make gestures and go to places."


def test_things_are_named_the_nearest_first_and_not_all_of_many() -> None:
    things = {name: Place(float(number), 0.0) for number, name in enumerate("abcdef")}
    assert replies.around(things, {}, Place(5.0, 0.0)) == ["Around me I know the f, e, d, c and b and more."]
    assert replies.around({"plant": Place(1, 1)}, {"visitor": Place(0, 1)}, None) == [
        "On my floor there is one person.",
        "Around me I know the plant.",
    ]
    assert replies.around({}, {"a": Place(0, 0), "b": Place(0, 0)}, None) == ["On my floor there are 2 persons."]


@pytest.mark.parametrize(("count", "said"), [(0, "no face"), (1, "one face"), (3, "3 faces")])
def test_faces_are_counted(count: int, said: str) -> None:
    assert replies.faces(count, "face") == f"Through the camera I notice {said}."


def test_a_distance_is_told_in_metres() -> None:
    assert replies.distance("plant", Place(2.6, 0.0), Place(0.0, 0.0)) == "The plant is about 3 metres away, before me."
    assert replies.distance("plant", Place(0.1, 0.0), Place(0.0, 0.0)) == (
        "The plant is about one metre away, before me."
    )
