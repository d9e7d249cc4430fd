"""One source over changing paths."""

import pytest
from openrois_streaming.source.source import MediaSource
from openrois_streaming.viewing.switched_source import SwitchedSource

from tests.support.streaming import FedSource, settle


class Paths:
    """A switched source, and two paths that are fed by hand."""

    def __init__(self, depth: int = 3) -> None:
        self.switches: list[MediaSource[int]] = []
        self.source = SwitchedSource[int]("paths", depth, self.switches.append)
        self.old, self.new = FedSource[int](), FedSource[int]()


async def test_a_path_is_opened_only_while_the_source_is() -> None:
    paths = Paths()
    paths.source.add(paths.old)
    await settle()
    assert paths.old.opened == 0
    async with paths.source.open():
        await settle()
        assert paths.old.is_open
    assert not paths.old.is_open


async def test_a_new_path_takes_over_with_its_first_item() -> None:
    paths = Paths(depth=4)
    paths.source.add(paths.old)
    async with paths.source.open() as items:
        await paths.old.feed(1)
        paths.source.add(paths.new)
        await settle()
        assert paths.old.is_open
        assert paths.new.is_open
        await paths.old.feed(2)
        await paths.new.feed(3)
        await settle()
        assert not paths.old.is_open
        await paths.old.feed(4)
        await paths.new.feed(5)
        assert [await anext(items) for _ in range(4)] == [1, 2, 3, 5]
    assert paths.switches == [paths.old, paths.new]


async def test_a_removed_path_is_closed_and_the_reader_waits_for_the_next() -> None:
    paths = Paths()
    paths.source.add(paths.old)
    async with paths.source.open() as items:
        await settle()
        paths.source.remove(paths.old)
        paths.source.remove(paths.old)
        await settle()
        assert not paths.old.is_open
        paths.source.add(paths.new)
        paths.source.add(paths.new)
        await paths.new.feed(1)
        assert await anext(items) == 1
        assert paths.new.opened == 1


async def test_the_end_of_a_path_is_not_that_of_the_source() -> None:
    paths = Paths()
    paths.source.add(paths.old)
    async with paths.source.open() as items:
        await paths.old.end()
        paths.source.add(paths.new)
        await paths.new.feed(1)
        assert await anext(items) == 1
        paths.source.end_input()
        with pytest.raises(StopAsyncIteration):
            await anext(items)


async def test_the_failure_of_a_path_is_raised() -> None:
    paths = Paths()
    paths.source.add(paths.old)
    async with paths.source.open() as items:
        await paths.old.feed(1)
        await paths.old.end(OSError("no decoder"))
        assert await anext(items) == 1
        with pytest.raises(OSError, match="no decoder"):
            await anext(items)


async def test_a_slow_reader_gets_the_newest() -> None:
    paths = Paths(depth=2)
    paths.source.add(paths.old)
    async with paths.source.open() as items:
        await paths.old.feed(1, 2, 3, 4)
        assert [await anext(items), await anext(items)] == [3, 4]


async def test_it_is_open_once_at_a_time_and_over_when_it_has_ended() -> None:
    paths = Paths()
    async with paths.source.open():
        with pytest.raises(RuntimeError, match="close it first"):
            await paths.source.open().__aenter__()
    paths.source.end_input()
    async with paths.source.open() as items:
        assert [each async for each in items] == []
