"""One stream over changing paths."""

import asyncio

import pytest
from openrois_streaming.source.fanout import SourceEnded, Subscription
from openrois_streaming.source.source import MediaSource
from openrois_streaming.viewing.switched_source import SwitchedSource

from tests.support.streaming import FedSource, settle


class Paths:
    """A switched source, and two paths that are fed by hand."""

    def __init__(self) -> None:
        self.switches: list[MediaSource[int]] = []
        self.source = SwitchedSource[int]("paths", self.switches.append)
        self.old, self.new = FedSource[int](), FedSource[int]()
        self.source.add(self.old)


async def taken(reader: Subscription[int], count: int) -> list[int]:
    async with asyncio.timeout(5):
        return [await reader.get() for _ in range(count)]


async def test_a_path_is_open_only_while_there_is_a_reader() -> None:
    paths = Paths()
    await settle()
    assert paths.old.opened == 0
    async with paths.source.subscribe(), paths.source.subscribe():
        await settle()
        assert (paths.old.opened, paths.old.closed) == (1, 0)
    assert not paths.old.is_open


async def test_a_new_path_takes_over_with_its_first_item() -> None:
    paths = Paths()
    async with paths.source.subscribe(4) as reader, paths.source.subscribe(4) as other:
        await settle()
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
        assert await taken(reader, 4) == await taken(other, 4) == [1, 2, 3, 5]
    assert paths.switches == [paths.old, paths.new]


async def test_a_removed_path_is_closed_and_the_reader_waits_for_the_next() -> None:
    paths = Paths()
    async with paths.source.subscribe() as reader:
        await settle()
        paths.source.remove(paths.old)
        paths.source.remove(paths.old)
        await settle()
        assert not paths.old.is_open
        paths.source.add(paths.new)
        paths.source.add(paths.new)
        await paths.new.feed(1)
        assert await taken(reader, 1) == [1]
        assert paths.new.opened == 1


async def test_the_end_of_a_path_is_not_that_of_the_stream() -> None:
    paths = Paths()
    async with paths.source.subscribe() as reader:
        await paths.old.end()
        paths.source.add(paths.new)
        await paths.new.feed(1)
        assert await taken(reader, 1) == [1]
        paths.source.end_input()
        with pytest.raises(SourceEnded) as ended:
            await taken(reader, 1)
        assert ended.value.__cause__ is None
    async with paths.source.subscribe() as reader:
        with pytest.raises(SourceEnded):
            await taken(reader, 1)


async def test_the_failure_of_a_path_is_that_of_the_stream_until_it_is_opened_again() -> None:
    paths = Paths()
    async with paths.source.subscribe() as reader:
        await paths.old.feed(1)
        await paths.old.end(OSError("no decoder"))
        assert await taken(reader, 1) == [1]
        with pytest.raises(SourceEnded) as ended:
            await taken(reader, 1)
        assert str(ended.value.__cause__) == "no decoder"
    async with paths.source.subscribe() as reader:
        await paths.old.feed(2)
        assert await taken(reader, 1) == [2]


async def test_a_slow_reader_loses_the_oldest() -> None:
    paths = Paths()
    async with paths.source.subscribe(2) as slow, paths.source.subscribe(4) as quick:
        await paths.old.feed(1, 2, 3, 4)
        assert await taken(slow, 2) == [3, 4]
        assert await taken(quick, 4) == [1, 2, 3, 4]
        assert slow.dropped == 2
