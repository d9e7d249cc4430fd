import argparse

import pytest
from openrois_avatar.options.picture_size import picture_size, size_text


@pytest.mark.parametrize("text", ["160x90", "640x360", "1280x720", "1920x1080", "720x1080", "auto"])
def test_a_size_is_read_and_written_alike(text: str) -> None:
    assert size_text(picture_size(text)) == text


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("big", "'big' is no size: write WIDTHxHEIGHT, as 1280x720, or auto"),
        ("1280", "'1280' is no size: write WIDTHxHEIGHT, as 1280x720, or auto"),
        ("-640x360", "'-640x360' is no size: write WIDTHxHEIGHT, as 1280x720, or auto"),
        ("641x361", "641x361: width and height must be even numbers, as 640x360"),
        ("158x90", "158x90 is out of bounds: choose a size from 160x90 to 1920x1080"),
        ("640x1082", "640x1082 is out of bounds: choose a size from 160x90 to 1920x1080"),
    ],
)
def test_a_bad_size_is_refused_with_the_remedy(text: str, words: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError) as caught:
        picture_size(text)
    assert str(caught.value) == words
