import gc

import numpy as np
from numpy.typing import NDArray
from openrois_avatar.link.picture_memory import KEPT, PictureMemory


def address(array: NDArray[np.uint8]) -> int:
    return int(array.ctypes.data)


def test_memory_without_views_is_reused() -> None:
    memory = PictureMemory()
    place = address(memory.allocate(10_000))
    assert address(memory.allocate(10_000)) == place


def test_any_view_keeps_the_memory_from_being_given_out_again() -> None:
    memory = PictureMemory()
    array = memory.allocate(12_000)
    array[:] = 7
    views = [
        np.frombuffer(array.data[40:], np.uint8)[4:].reshape(-1, 4)[:10],
        memory.allocate(12_000)[100:][::2],
    ]
    places = {address(array), address(views[1]) - 100}
    del array
    gc.collect()
    other = memory.allocate(12_000)
    assert address(other) not in places
    other[:] = 9
    assert (views[0] == 7).all()
    del views
    assert {address(memory.allocate(12_000))} < places


def test_so_many_are_kept_and_no_more() -> None:
    memory = PictureMemory()
    taken = [memory.allocate(5_000) for _ in range(KEPT + 2)]
    assert len({address(array) for array in taken}) == KEPT + 2
    kept = {address(array) for array in taken[:KEPT]}
    taken.clear()
    again = [memory.allocate(5_000) for _ in range(KEPT)]
    assert {address(array) for array in again} == kept


def test_memory_of_another_size_is_let_go() -> None:
    memory = PictureMemory()
    small, large = memory.allocate(5_000), memory.allocate(50_000)
    assert (small.size, large.size) == (5_000, 50_000)
    place = address(large)
    del small, large
    assert address(memory.allocate(50_000)) == place
    large = memory.allocate(50_000)
    memory.clear()
    assert address(memory.allocate(50_000)) != address(large)


def test_a_picture_lies_where_a_processor_copies_it_fast() -> None:
    assert address(PictureMemory().allocate(5_000)) % 4096 == 2048
