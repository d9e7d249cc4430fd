import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.hearing.dictionary import has_word

WORDS = st.text(alphabet="abc'z", min_size=1, max_size=4)


@given(st.sets(WORDS, max_size=30), st.sets(WORDS, max_size=5), st.booleans())
def test_words_are_found_and_no_others(words: set[str], others: set[str], closed: bool) -> None:
    lines = [f"{word}{number} W ER D" for word in sorted(words) for number in ("", "(2)", "(3)")[: 1 + len(word) % 3]]
    dictionary = ("\n".join(lines) + ("\n" if closed else "")).encode()
    for word in words | others:
        assert has_word(dictionary, word) is (word in words)
    assert not has_word(dictionary, "")


@pytest.mark.parametrize("dictionary", [b"", b"\n", b"\n\n"])
def test_an_empty_dictionary_has_none(dictionary: bytes) -> None:
    assert not has_word(dictionary, "stop")
    assert not has_word(dictionary, "")
