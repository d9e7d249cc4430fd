import numpy as np
import pytest
from openrois_bench.streams.fanout.picture import Grain
from openrois_bench.streams.fanout.runs import FPS

from tests.support.streaming import VirtualClock


async def test_pictures_come_on_time_move_and_repeat_every_second() -> None:
    clock = VirtualClock()
    pictures = []
    async with Grain(320, 180, clock=clock).open() as frames:
        for _ in range(FPS + 1):
            pictures.append(await anext(frames))
            clock.jump(1 / FPS + 1e-9)
    assert [picture.sequence for picture in pictures] == list(range(FPS + 1))
    assert pictures[3].captured_at == pytest.approx(1000 + 3 / FPS)
    assert not np.array_equal(pictures[0].data, pictures[1].data)
    assert pictures[0].data is pictures[FPS].data
    assert not pictures[0].data.flags.writeable


async def test_a_picture_has_as_much_in_it_as_a_camera_s() -> None:
    async with Grain(320, 180, clock=VirtualClock()).open() as frames:
        luma = (await anext(frames)).data[:180].astype(int)
    assert luma.min() >= 16
    assert luma.max() <= 235
    assert luma.std() > 20
    assert 0 < np.abs(np.diff(luma, axis=1)).mean() < 10, "detail, and no noise"
