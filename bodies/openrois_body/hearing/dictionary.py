"""Look-up in a pronouncing dictionary like CMU's: a sorted text with a word at the beginning of each line. Pure."""

__all__ = ["has_word"]


def has_word(dictionary: bytes, word: str) -> bool:
    """Return whether there is a pronunciation of `word`, by binary search.

    Args:
        dictionary: its lines are sorted by their words, but for the number that further pronunciations have: `the(2)`.
        word: in lower case.
    """
    wanted = word.encode()
    low, high = 0, len(dictionary)
    while low < high:
        start = dictionary.rfind(b"\n", 0, (low + high) // 2) + 1
        end = dictionary.find(b"\n", start)
        end = len(dictionary) if end < 0 else end
        found = dictionary[start:end].partition(b" ")[0].partition(b"(")[0]
        if found == wanted:
            return bool(wanted)
        if found < wanted:
            low = end + 1
        else:
            high = start
    return False
