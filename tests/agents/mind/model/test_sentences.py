# ruff: noqa: RUF001 - the marks of several scripts are meant
"""Sentences of a text that arrives in pieces, in several languages."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_agents.mind.model.sentences import MAX_SENTENCE, Sentences

TEXTS = {
    "Hello! I am a robot. And you?": ["Hello!", "I am a robot.", "And you?"],
    "Dr. Smith and Mr. J. R. Tolkien are here. So am I. Fine.": [
        "Dr. Smith and Mr. J. R. Tolkien are here.",
        "So am I.",
        "Fine.",
    ],
    "It is 3.14 m, at 9.30 a.m. or so. No. 5 is alive. It has 2. Two are enough.": [
        "It is 3.14 m, at 9.30 a.m. or so.",
        "No. 5 is alive.",
        "It has 2.",
        "Two are enough.",
    ],
    "Since 1990. Until now.": ["Since 1990.", "Until now."],
    "Robots, avatars, etc. are bodies. They sit, stand, etc. Then they go.": [
        "Robots, avatars, etc. are bodies.",
        "They sit, stand, etc.",
        "Then they go.",
    ],
    'He said "Stop!" and left. "Why?" She asked.': ['He said "Stop!" and left.', '"Why?"', "She asked."],
    "Look at openrois.org, or node.js. There it is!": ["Look at openrois.org, or node.js.", "There it is!"],
    "Really?! Yes... perhaps.": ["Really?!", "Yes...", "perhaps."],
    "z. B. Herr Dr. Müller kommt am 3. Mai bzw. später. Gut!": [
        "z. B. Herr Dr. Müller kommt am 3.",
        "Mai bzw. später.",
        "Gut!",
    ],
    "„Guten Tag.“ Er ging. «Bonjour !» M. Dupont rit.": ["„Guten Tag.“", "Er ging.", "«Bonjour !»", "M. Dupont rit."],
    "¿Qué tal? ¡Muy bien! El Sr. Gómez espera.": ["¿Qué tal?", "¡Muy bien!", "El Sr. Gómez espera."],
    "你好。我是机器人！「你呢？」很好": ["你好。", "我是机器人！", "「你呢？」", "很好"],
    "こんにちは。元気ですか？はい。": ["こんにちは。", "元気ですか？", "はい。"],
    "नमस्ते। मैं रोबोट हूँ।": ["नमस्ते।", "मैं रोबोट हूँ।"],
    "هل تسمعني؟ نعم.": ["هل تسمعني؟", "نعم."],
    "First line\n- **second** `line`\n\n# Third\n***\n1. Four": ["First line", "second line", "Third", "1. Four"],
    "Set reaction_ref to 5 *now*. _Please_.": ["Set reaction_ref to 5 now.", "Please."],
    "... !!! 🙂": [],
}


def cut(text: str, piece: int) -> list[str]:
    sentences = Sentences()
    found = [each for at in range(0, len(text), piece) for each in sentences.add(text[at : at + piece])]
    return found + sentences.finish()


@pytest.mark.parametrize("piece", [1, 2, 3, 7, 1000])
@pytest.mark.parametrize("text", TEXTS)
def test_a_text_is_cut_into_its_sentences_whatever_the_pieces(text: str, piece: int) -> None:
    assert cut(text, piece) == TEXTS[text]


def test_a_sentence_is_whole_as_soon_as_the_next_one_begins() -> None:
    sentences = Sentences()
    assert sentences.add("Hello there.") == []
    assert sentences.add(" ") == ["Hello there."]
    assert sentences.add("好的。") == []
    assert sentences.add("我") == ["好的。"]


@pytest.mark.parametrize(
    ("text", "settled"),
    [
        ("Hello there.", ["Hello there."]),
        ("Hello there! ", []),
        ('He said "Stop!" ', ['He said "Stop!"']),
        ("Really?", ["Really?"]),
        ("好的。", ["好的。"]),
        ("I like Dr.", []),
        ("It is 3.", []),
        ("We sit, etc.", []),
        ("Hello there", []),
    ],
)
def test_a_sentence_that_seems_whole_is_spoken_in_a_pause(text: str, settled: list[str]) -> None:
    sentences = Sentences()
    before = sentences.add(text)
    assert sentences.settle() == settled
    assert "".join((*before, *settled, *sentences.finish())) == text.strip()


@pytest.mark.parametrize("text", ["word " * 500, "word, and so on " * 200, "x" * 3000, "字" * 3000, "字，字" * 900])
def test_a_text_without_an_end_is_cut_where_it_may_be(text: str) -> None:
    sentences = Sentences()
    found = sentences.add(text)
    assert all(len(each) <= MAX_SENTENCE for each in found)
    assert len(found) >= len(text) // MAX_SENTENCE - 1
    assert "".join("".join((*found, *sentences.finish())).split()) == "".join(text.split())


def test_a_long_sentence_is_cut_behind_a_comma() -> None:
    text = f"{'word ' * 30}end, {'word ' * 30}end."
    assert [each[-4:] for each in cut(text, 5)] == ["end,", "end."]


@given(st.text(alphabet=st.sampled_from("ab AB.!?,。\n\"'”13*_-#我"), max_size=600), st.integers(1, 50))
def test_whatever_comes_nothing_is_lost_and_each_is_short(text: str, piece: int) -> None:
    found = cut(text, piece)
    assert all(0 < len(each) <= MAX_SENTENCE and each == each.strip() for each in found)
    kept = [each for each in text if each.isalnum()]
    assert [each for each in "".join(found) if each.isalnum()] == kept
