"""What a change behind a nested gateway costs."""

from openrois_bench.gateway.nested import measure


async def test_by_the_directory_less_is_read_than_by_the_whole_profile() -> None:
    found = await measure(20, 2)
    whole, read = (changes[1] for changes in found.values())
    assert list(found) == ["whole profile", "directory"]
    assert 0 < 20 * read.characters < whole.characters
    assert read.told > 0
