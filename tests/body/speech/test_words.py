from math import inf

from hypothesis import given
from hypothesis import strategies as st
from openrois_body.speech.words import Place, WordFinder


def plain(text: str) -> list[tuple[int, int]]:
    return [(place, place + 1) for place in range(len(text))]


def words(reported: list[Place], text: str, origins: list[tuple[int, int]]) -> list[Place]:
    finder = WordFinder(text, origins)
    found = [word for place in reported for word in finder.add([place])]
    return found + finder.find_last()


def told(text: str, *places: tuple[float, int, int]) -> list[tuple[float, str]]:
    found = words([Place(*place) for place in places], text, plain(text))
    return [(offset, text[start : start + length]) for offset, start, length in found]


def test_words_stand_where_they_stand() -> None:
    assert told("Hello world.", (0, 0, 5), (300, 6, 5)) == [(0, "Hello"), (300, "world")]


def test_a_number_that_is_many_words_is_one() -> None:
    # As espeak tells "1234 euros": the first part with its length, the rest from the second figure on.
    places = ((0, 0, 4), (221, 1, 4), (674, 1, 4), (1377, 1, 4), (1971, 5, 5))
    assert told("1234 euros", *places) == [(0, "1234"), (1971, "euros")]


def test_signs_are_no_words() -> None:
    # "$" is said as "dollar", a picture as what it shows.
    assert told("$5, 🙂 smile", (0, 0, 1), (200, 1, 1), (400, 4, 1), (700, 5, 1), (900, 6, 5)) == [
        (200, "5"),
        (900, "smile"),
    ]
    assert told("a --", (0, 0, 1), (5, 2, 2), (9, 4, 1)) == [(0, "a")]


def test_a_contraction_is_one_word_though_it_is_told_a_character_too_early() -> None:
    assert told("I don't know", (0, 0, 1), (116, 1, 1), (460, 8, 4)) == [(0, "I"), (116, "don't"), (460, "know")]
    assert told("L'avion n'est", (0, 0, 1), (300, 2, 5), (342, 8, 3)) == [(0, "L'avion"), (342, "n'est")]


def test_characters_of_one_place_of_the_document_are_one_word() -> None:
    # <sub alias="World Web">WW</sub>: both words of the alias stand for the characters 24 and 25.
    origins = [(24, 26)] * 9
    assert words([Place(0, 0, 5), Place(200, 6, 3)], "World Web", origins) == [Place(0, 24, 2)]
    assert words([Place(0, 0, 5)], "World", [(7, 7)] * 5) == []


def test_a_word_is_found_when_the_next_one_is_told() -> None:
    finder = WordFinder("$5 now", plain("$5 now"))
    assert finder.pending_ms == inf
    assert finder.add([Place(0, 0, 1)]) == []
    assert finder.pending_ms == 0
    assert finder.add([Place(200, 1, 1)]) == []
    assert finder.add([Place(400, 3, 3)]) == [Place(200, 1, 1)]
    assert finder.pending_ms == 400
    assert finder.find_last() == [Place(400, 3, 3)]
    assert finder.pending_ms == inf


@given(
    st.text(max_size=20),
    st.lists(st.tuples(st.floats(0, 9), st.integers(-2, 25), st.integers(-1, 25)), max_size=8).map(sorted),
)
def test_whatever_is_told_the_words_are_in_order_and_in_the_text(
    text: str, places: list[tuple[float, int, int]]
) -> None:
    until = 0
    for _, start, length in words([Place(*place) for place in places], text, plain(text)):
        assert start >= until
        assert length > 0
        until = start + length
        assert until <= len(text)
