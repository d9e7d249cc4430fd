"""What can be said: the grammar, what sentences mean, and what is left out."""

import pytest
from openrois_agents.mind.phrases import Intent, Phrases, make_phrases, spoken_name
from openrois_agents.mind.requests import GESTURE_SENTENCES, OTHER_WORDS, POLITE_AFTER, POLITE_BEFORE, REQUESTS
from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.vocabulary import MAX_CHOICES
from openrois_body.hearing.jsgf import MAX_GRAMMAR, Grammar, read_grammar

VOCABULARY = Vocabulary(
    bodies=("avatar",), gestures=("fly_high", "shake_head", "wave"), places=("Café", "Room 12", "coffee table", "plant")
)


def grammar_of(phrases: Phrases) -> Grammar:
    return read_grammar(phrases.grammar)


@pytest.mark.parametrize(
    ("text", "intent"),
    [
        ("hello", Intent("greet")),
        ("wave", Intent("gesture", "wave")),
        ("please wave", Intent("gesture", "wave")),
        ("Could you please wave your hand now?", Intent("gesture", "wave")),
        ("shake your head", Intent("gesture", "shake_head")),
        ("show me the fly high", Intent("gesture", "fly_high")),
        ("go to the plant", Intent("go_to", "plant")),
        ("walk to the coffee table please", Intent("go_to", "coffee table")),
        ("go to room twelve", Intent("go_to", "Room 12")),
        ("Where is the plant?", Intent("find", "plant")),
        ("look to the left", Intent("look_at", "left")),
        ("What do you see?", Intent("see")),
        ("come here", Intent("come")),
        ("who are you", Intent("who")),
        ("stop", Intent("stop")),
        ("goodbye", Intent("leave")),
    ],
)
def test_a_sentence_is_understood_and_is_in_the_grammar(text: str, intent: Intent) -> None:
    phrases = make_phrases(VOCABULARY)
    assert phrases.understand(text) == intent
    assert grammar_of(phrases).accepts("heard", text.lower().rstrip("?"))


@pytest.mark.parametrize(
    "text",
    ["", "go to the moon", "please", "please hello", "do not wave", "wave at him", "stop the robot", "day", "12"],
)
def test_another_sentence_is_not_understood(text: str) -> None:
    assert make_phrases(VOCABULARY).understand(text) is None


def test_every_sentence_is_in_the_grammar_and_every_example_is_understood() -> None:
    phrases = make_phrases(VOCABULARY)
    grammar = grammar_of(phrases)
    assert all(grammar.accepts("heard", each) for each in phrases.meanings)
    assert all(phrases.understand(each) for each in phrases.examples)
    for request in phrases.requests:
        for polite in (f"{POLITE_BEFORE[-1]} {request}", f"{request} {POLITE_AFTER[0]}"):
            assert grammar.accepts("heard", polite)
            assert phrases.understand(polite) == phrases.meanings[request]
    assert len(set(phrases.examples)) == len(phrases.examples)


def test_each_intent_has_one_meaning() -> None:
    phrases = make_phrases(Vocabulary(gestures=tuple(GESTURE_SENTENCES), places=("plant",)))
    sentences = [each for request in REQUESTS for each in request.sentences]
    sentences += [each for name, said in GESTURE_SENTENCES.items() if name != "surprised" for each in said]
    assert len(sentences) == len(set(sentences))
    assert {each.name for each in phrases.meanings.values()} == {each.intent for each in REQUESTS}


def test_other_speech_is_caught_by_words_that_are_no_sentence() -> None:
    phrases = make_phrases(VOCABULARY)
    grammar = grammar_of(phrases)
    assert grammar.has_other_speech("heard")
    assert set(OTHER_WORDS) <= grammar.words("heard")
    assert not grammar.accepts("heard", " ".join(OTHER_WORDS[:3]))
    assert phrases.understand(" ".join(OTHER_WORDS[:3])) is None
    assert not [each for each in phrases.meanings if set(each.split()) <= set(OTHER_WORDS)]


def test_only_what_bodies_can_do_is_in_the_grammar() -> None:
    phrases = make_phrases(VOCABULARY, ("say", "look_at"))
    intents = {each.name for each in phrases.meanings.values()}
    assert "look_at" in intents
    assert not {"gesture", "gestures", "go_to", "come", "places"} & intents
    # Where a place is can be asked without going there.
    assert phrases.understand("where is the plant") == Intent("find", "plant")
    assert phrases.understand("wave") is None
    assert "wave" not in grammar_of(phrases).words("heard")
    assert "fly_high" not in phrases.left_out


def test_a_vocabulary_without_names_needs_no_rule_for_them() -> None:
    phrases = make_phrases(Vocabulary(), ())
    assert phrases.understand("hello") == Intent("greet")
    assert not phrases.requests
    assert grammar_of(phrases).accepts("heard", "hello")
    assert make_phrases(Vocabulary()).names == frozenset()


def test_names_that_cannot_be_said_or_heard_are_left_out_and_told() -> None:
    assert make_phrases(VOCABULARY).left_out == ("Café",)
    phrases = make_phrases(VOCABULARY, unknown={"coffee", "wave"})
    assert phrases.left_out == ("wave", "Café", "coffee table")
    assert phrases.understand("wave") is None
    assert "coffee" not in grammar_of(phrases).words("heard")


def test_a_wake_word_begins_every_sentence() -> None:
    phrases = make_phrases(VOCABULARY, wake_word="Computer")
    grammar = grammar_of(phrases)
    assert phrases.understand("computer please wave") == Intent("gesture", "wave")
    assert phrases.understand("please wave") is None
    assert phrases.is_addressed("Computer, what?")
    assert not phrases.is_addressed("computers are nice")
    assert grammar.accepts("heard", "computer hello")
    assert not grammar.accepts("heard", "hello")
    # Who wants a body to stop need not think of a wake word.
    assert grammar.accepts("heard", "stop moving")
    # Other speech is caught, with the wake word or without.
    assert "[computer] (<other_speech>)+;" in phrases.grammar


@pytest.mark.parametrize("words", ["", " of the north east wing upstairs", " a b c d e f g h i j k l m n o p"])
def test_the_largest_vocabulary_has_a_grammar_that_bodies_take(words: str) -> None:
    letters = "abcdefghijklmnopqrstuvwxyz"
    names = tuple(f"{letters[each // 26]}{letters[each % 26]}{words}" for each in range(MAX_CHOICES))
    vocabulary = Vocabulary(gestures=tuple(f"{each} g" for each in names), places=names)
    phrases = make_phrases(vocabulary, wake_word="computer")
    assert len(phrases.grammar) <= MAX_GRAMMAR
    grammar_of(phrases)
    assert phrases.names
    assert phrases.left_out == (() if not words else phrases.left_out)
    assert {*phrases.left_out, *(each.argument for each in phrases.meanings.values())} >= {*names, *vocabulary.gestures}


@pytest.mark.parametrize(
    ("name", "spoken"),
    [
        ("look_around", "look around"),
        ("Ann's desk", "ann's desk"),
        ("room 7", "room seven"),
        ("room-20", "room twenty"),
        ("room 42", "room forty two"),
        ("room 1234", ""),
        ("Größe", ""),
        ("...", ""),
    ],
)
def test_a_name_is_said_in_english_letters(name: str, spoken: str) -> None:
    assert spoken_name(name) == spoken
