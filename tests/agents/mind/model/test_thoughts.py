"""What a language model thinks is not spoken."""

import pytest
from openrois_agents.mind.model.thoughts import Thoughts

TEXTS = {
    "Hello <think> there": "Hello <think> there",
    "<think>Who is it?\n</think>\n\nHello.": "\n\nHello.",
    "\n <think></think>Yes. <think>no</think>": "Yes. <think>no</think>",
    "<think>" + "hm " * 50 + "</thin </think>So.": "So.",
    "<think>without an end": "",
    "<thinking": "<thinking",
    " Hi": " Hi",
    "": "",
}


@pytest.mark.parametrize("piece", [1, 2, 5, 1000])
@pytest.mark.parametrize("text", TEXTS)
def test_thoughts_at_the_beginning_are_left_out_whatever_the_pieces(text: str, piece: int) -> None:
    thoughts = Thoughts()
    said = "".join(thoughts.leave_out(text[at : at + piece]) for at in range(0, len(text), piece))
    assert said == TEXTS[text]
